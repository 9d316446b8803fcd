//! What a line of the console does to the correction.

extern crate std;

use super::active::Active;
use super::config::DeviceConfig;
use super::light::Light;
use super::machine::{Action, Device};
use super::own::Origin;
use super::sensor::{Pace, SensorAnswer, SensorTask, SensorWatch};
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, ColumnName, Drift, Offset};
use crate::extended::{Effects, FittedEffect};
use crate::fit::{Method, Order};
use crate::record::Record;
use crate::sensor::{Axis, AxisMap, Reading, Sensor};
use crate::store::{Slot, StoreAnswer};
use heapless::String;

fn plain_device() -> Device {
    let sensor = Sensor::uniform("a chip", 0.1, 50.0);
    Device::new(DeviceConfig { board: "bench", sensor, pace: Pace::EachConversion })
}

/// A record with this effect, with coefficients of 2, −1 and 0.5.
pub(super) fn record(effect: BuiltIn<f64>) -> Record {
    let mut coefficients = [0.0; 9];
    coefficients[..3].copy_from_slice(&[2.0, -1.0, 0.5]);
    let fitted = FittedEffect::new(effect, coefficients, [0.001; 9]);
    Record {
        sequence: 1,
        calibration: Calibration::identity(50.0),
        effects: Effects::of([Some(fitted), None, None, None]),
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.25,
        axes: None,
        predicted_error: crate::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    }
}

/// A device without sensor and store that applies this effect.
fn device(effect: BuiltIn<f64>) -> Device {
    let mut device = plain_device();
    device.rest();
    Active::install(&mut device.active, Slot::A, &record(effect), AxisMap::IDENTITY);
    device
}

/// The answer to a line that comes at this time.
pub(super) fn answer(device: &mut Device, line: &str, now_ms: u64) -> std::string::String {
    let mut out = String::<4096>::new();
    for byte in line.bytes().chain([b'\n']) {
        assert!(device.take_byte(byte), "{line}");
    }
    loop {
        match device.poll(now_ms, &mut out) {
            Action::Sensor(SensorTask::Start) => device.complete_sensor(SensorAnswer::Started, now_ms),
            Action::Sensor(SensorTask::Sample) => {
                let reading = Reading { counts: [200, -100, 350], overflow: [false; 3] };
                device.complete_sensor(SensorAnswer::Reading(reading), now_ms);
            }
            Action::Sensor(SensorTask::Temperature) => {
                device.complete_sensor(SensorAnswer::Temperature(None), now_ms);
            }
            Action::Store(_) => device.complete_store(&StoreAnswer::Failed, now_ms),
            Action::Again => {}
            Action::Sleep => break,
        }
    }
    std::string::String::from(out.trim_end())
}

fn corrected(device: &mut Device, now_ms: u64) -> Option<[f32; 3]> {
    device.active.as_mut()?.at(now_ms)?.apply([20.0, -10.0, 35.0], None).ok()
}

#[test]
fn the_value_that_is_fed_is_the_one_that_is_corrected_for() {
    let column = ColumnName::new("current_a").expect("a name");
    let mut device = device(BuiltIn::Offset(Offset::linear(column, 1.0)));
    // Without the study nothing is tested.
    let tested = u8::from(cfg!(feature = "study"));
    assert_eq!(corrected(&mut device, 0), None, "nothing is known yet");
    assert_eq!(
        answer(&mut device, "cov current_a=1", 10),
        std::format!("ok current_a=1.0 used=1 tested={tested}")
    );
    assert_eq!(corrected(&mut device, 20), Some([20.0, -10.0, 35.0]), "the current at the reference");
    assert_eq!(
        answer(&mut device, "cov current_a=5", 30),
        std::format!("ok current_a=5.0 used=1 tested={tested}")
    );
    assert_eq!(corrected(&mut device, 40), Some([12.0, -6.0, 33.0]));
    assert_eq!(
        answer(&mut device, "cov throttle=9", 50),
        std::format!("ok throttle=9.0 used=0 tested={tested}")
    );
    assert_eq!(corrected(&mut device, 60), Some([12.0, -6.0, 33.0]));
}

#[test]
fn the_corrected_field_of_the_last_sample_is_known_while_it_is_one() {
    let column = ColumnName::new("current_a").expect("a name");
    let mut device = device(BuiltIn::Offset(Offset::linear(column, 1.0)));
    let sample = |device: &mut Device, overflow, t_ms| {
        device.on_sample(&Reading { counts: [200, -100, 350], overflow: [overflow; 3] }, t_ms);
        device.corrected_ut()
    };
    assert_eq!(sample(&mut device, false, 0), None, "the effect waits for its column");
    answer(&mut device, "cov current_a=5", 10);
    assert_eq!(sample(&mut device, false, 20), Some([12.0, -6.0, 33.0]));
    assert_eq!(sample(&mut device, true, 40), None, "out of range");
    assert_eq!(sample(&mut device, false, 60), Some([12.0, -6.0, 33.0]));
    assert_eq!(sample(&mut plain_device(), false, 80), None, "no calibration");
}

#[test]
fn the_time_that_is_fed_is_that_of_now_and_goes_on() {
    let mut device = device(BuiltIn::Drift(Drift { reference_s: 100.0 }));
    assert_eq!(corrected(&mut device, 7000), None, "the recording's clock is not known yet");
    assert_eq!(answer(&mut device, "cov t_s=100", 7000), "ok t_s=100.0 used=1 tested=0");
    assert_eq!(corrected(&mut device, 7000), Some([20.0, -10.0, 35.0]));
    assert_eq!(corrected(&mut device, 9000), Some([16.0, -8.0, 34.0]), "two seconds later");
    assert_eq!(answer(&mut device, "cov t_s=104", 9000), "ok t_s=104.0 used=1 tested=0");
    assert_eq!(corrected(&mut device, 9000), Some([12.0, -6.0, 33.0]));
}

#[test]
fn the_light_shows_the_calibration_then_the_session_and_a_fault_before_all() {
    let mut device = plain_device();
    assert_eq!(device.light(), Light::SensorFault, "it has not been heard of");
    device.on_sample(&Reading { counts: [200, -100, 350], overflow: [false; 3] }, 5);
    assert_eq!(device.light(), Light::Uncalibrated);
    let drift = record(BuiltIn::Drift(Drift { reference_s: 100.0 }));
    Active::install(&mut device.active, Slot::A, &drift, AxisMap::IDENTITY);
    assert_eq!(device.light(), Light::Calibrated);
    device.session.start();
    assert_eq!(device.light(), Light::Collecting);
    assert!(device.session.stop().is_ok());
    assert_eq!(device.light(), Light::Refused, "nothing was collected");
    device.rest();
    assert_eq!(device.light(), Light::SensorFault);
}

#[test]
fn status_says_what_keeps_a_calibration_from_use() {
    let mut device = plain_device();
    for now_ms in 0..3000 {
        answer(&mut device, "", now_ms);
    }
    let turned = AxisMap::new([Axis::Y, Axis::MinusX, Axis::Z]);
    let drift = record(BuiltIn::Drift(Drift { reference_s: 100.0 }));
    let mounted_otherwise = Record { axes: turned, ..drift };
    device.store_watch.answered();
    for (record, hint) in [
        (
            mounted_otherwise,
            "+ hint the stored calibration is not applied: it was made with another mounting of the sensor",
        ),
        (drift, "+ hint the calibration needs: cov t_s=VALUE"),
    ] {
        Active::install(&mut device.active, Slot::A, &record, AxisMap::IDENTITY);
        let said = answer(&mut device, "status", 3000);
        assert!(said.starts_with(hint), "{said}");
    }
}

#[test]
fn a_device_that_begins_anew_is_as_good_as_a_new_one() {
    let other = Sensor::uniform("another chip", 0.05, 100.0);
    let config = DeviceConfig { board: "bench", sensor: other, pace: Pace::Pushed };
    let mut used = device(BuiltIn::Drift(Drift { reference_s: 100.0 }));
    used.session.start();
    assert!(answer(&mut used, "cov temp_c=20 current_a=3", 5).starts_with("ok "));
    assert!(answer(&mut used, "field 48", 6).starts_with("ok "));
    used.begin_anew(config);
    let mut new = Device::new(config);
    for now_ms in 0..3000 {
        answer(&mut used, "", now_ms);
        answer(&mut new, "", now_ms);
    }
    used.store_watch.answered();
    new.store_watch.answered();
    for (line, now_ms) in [("status", 4000), ("effect list", 4001), ("cal show", 4002), ("help", 4003)] {
        assert_eq!(answer(&mut used, line, now_ms), answer(&mut new, line, now_ms), "{line}");
    }
    assert_eq!(used.session.config(), new.session.config());
}

/// A device that applies an identity in a field of 50 µT, and has a memory in which everything can be stored.
fn calibrated() -> Device {
    let mut device = plain_device();
    let plain = Record { effects: Effects::none(), ..record(BuiltIn::Drift(Drift { reference_s: 0.0 })) };
    Active::install(&mut device.active, Slot::A, &plain, AxisMap::IDENTITY);
    device.store_watch.answered();
    device
}

#[test]
fn the_heading_needs_a_sample_and_the_way_down_and_takes_a_declination() {
    let mut device = calibrated();
    device.rest();
    assert!(answer(&mut device, "heading", 1).starts_with("err sensor "), "nothing was measured");
    // Level, the front to the east: 20 µT of north come from the left.
    device.on_sample(&Reading { counts: [0, -200, 450], overflow: [false; 3] }, 10);
    assert!(answer(&mut device, "heading", 11).starts_with("err state the direction of gravity is unknown"));
    device.on_motion(Some([0.0, 0.0, -9.81]), None);
    assert_eq!(answer(&mut device, "heading", 12), "ok heading_deg=90.0 declination_deg=0.0");
    assert_eq!(answer(&mut device, "heading 3.5", 13), "ok heading_deg=93.5 declination_deg=3.5");
    // On its right side.
    device.on_sample(&Reading { counts: [0, 450, 200], overflow: [false; 3] }, 20);
    device.on_motion(Some([0.0, -9.81, 0.0]), None);
    assert_eq!(
        answer(&mut device, "heading", 21),
        "ok heading_deg=93.5 declination_deg=3.5",
        "it is remembered"
    );
    device.on_motion(Some([-9.81, 0.0, 0.0]), None);
    assert!(answer(&mut device, "heading", 22).starts_with("err state the x axis points up or down"));
    device.active = None;
    assert!(answer(&mut device, "heading", 23).starts_with("err state there is no calibration in use"));
}

#[test]
fn lights_that_can_show_north_do_and_others_show_the_state() {
    let mut device = calibrated();
    device.on_sample(&Reading { counts: [0, -200, 450], overflow: [false; 3] }, 10);
    device.on_motion(Some([0.0, 0.0, -9.81]), None);
    assert_eq!((device.shown(20).light, device.shown(20).heading_deg), (Light::Calibrated, None));
    device.show_coverage();
    assert_eq!(device.shown(30).ring(), 1 << 6, "north is on the left");
    device.session.start();
    assert_eq!(device.shown(40).light, Light::Collecting);
    assert_eq!(device.shown(40).seen.count(), 0);
}

/// Bytes to the console, with a memory that takes everything.
fn typed(device: &mut Device, bytes: &[u8], now_ms: u64) -> std::string::String {
    let mut out = String::<4096>::new();
    let mut slots = [[0xff_u8; crate::record::MAX_RECORD_BYTES]; 2];
    let (mut bytes, mut turns) = (bytes.iter(), 0);
    loop {
        if device.is_idle()
            && let Some(byte) = bytes.next()
        {
            assert!(device.take_byte(*byte));
        }
        match device.poll(now_ms, &mut out) {
            Action::Store(crate::store::StoreTask::Read { slot, at, length }) => {
                let bytes = crate::store::Chunk::from_slice(&slots[slot.index()][at..at + length]).unwrap();
                device.complete_store(&StoreAnswer::Read(bytes), now_ms);
            }
            Action::Store(crate::store::StoreTask::Write { slot, at, bytes }) => {
                slots[slot.index()][at..at + bytes.len()].copy_from_slice(&bytes);
                device.complete_store(&StoreAnswer::Written, now_ms);
            }
            Action::Sensor(SensorTask::Start) => device.complete_sensor(SensorAnswer::Started, now_ms),
            Action::Sensor(SensorTask::Sample) => {
                let reading = Reading { counts: [200, -100, 350], overflow: [false; 3] };
                device.complete_sensor(SensorAnswer::Reading(reading), now_ms);
            }
            Action::Sensor(SensorTask::Temperature) => {
                device.complete_sensor(SensorAnswer::Temperature(None), now_ms);
            }
            Action::Again => {}
            Action::Sleep if device.is_idle() && bytes.len() == 0 => break,
            Action::Sleep => {
                turns += 1;
                assert!(turns < 1000, "it waits for something: {out}");
            }
        }
    }
    let replies = out.lines().filter(|line| !line.starts_with("Raw:"));
    replies.collect::<std::vec::Vec<_>>().join("\n")
}

#[test]
fn a_packet_of_motioncal_is_confirmed_stored_and_applied() {
    let mut device = plain_device();
    assert!(typed(&mut device, b"stream motioncal\n", 5).contains("ok stream=motioncal"));
    let calibration = Calibration {
        offset_ut: [12.5, -30.25, 7.0],
        matrix: [[1.25, 0.125, 0.0], [0.125, 1.0, 0.0], [0.0, 0.0, 0.75]],
        field_ut: 48.5,
    };
    let packet = crate::protocol::Packet(calibration).bytes();
    let mut spoilt = packet;
    spoilt[30] ^= 1;
    assert!(typed(&mut device, &spoilt, 6).starts_with("err usage the packet is damaged"));
    assert_eq!(
        typed(&mut device, &packet, 7),
        "Cal1:0.0,0.0,0.0,0.0,0.0,0.0,12.5,-30.25,7.0,48.5\nCal2:1.25,0.125,0.0,0.125,1.0,0.0,0.0,0.0,0.75\n\
         ok calibrated=1 slot=0 sequence=1"
    );
    let applied = device.active.as_ref().expect("it is applied").record.calibration;
    assert_eq!(applied, calibration.cast());
    // A line in between, and one that begins as a packet does.
    assert!(typed(&mut device, b"uT?\n", 8).starts_with("err unknown"));
    device.session.start();
    assert!(typed(&mut device, &packet, 9).starts_with("err state samples are being collected"));
    // Without the stream a packet is bytes that are no text.
    assert!(typed(&mut device, b"cal cancel\nstream off\n", 10).ends_with("ok stream=off"));
    assert!(typed(&mut device, &[&packet[..], b"\n"].concat(), 11).starts_with("err "));
}

/// What the study of a device tests now.
#[cfg(feature = "study")]
fn tested(device: &Device) -> heapless::Vec<&str, 3> {
    device.learner_inputs.learner.tested().collect()
}

#[cfg(feature = "study")]
#[test]
fn what_the_board_measures_is_tested_where_it_is_asked_for() {
    let mut device = plain_device();
    device.rest();
    let say = |device: &mut Device, line: &str| answer(device, line, 0);
    let warm = |device: &mut Device, temp_c| device.complete_sensor(SensorAnswer::Temperature(temp_c), 0);
    // A pin is tested once that is wanted, ...
    device.on_own_column("adc0_v", 1.5, Origin::Pin);
    device.on_own_column("cpu_temp_c", 40.0, Origin::Inside);
    warm(&mut device, Some(30.0));
    assert_eq!(tested(&device), ["temp_c"]);
    assert!(say(&mut device, "cov adc0_v=on").contains("ok adc0_v=1.5 used=0 tested=1"));
    assert_eq!(tested(&device), ["temp_c", "adc0_v"]);
    device.on_own_column("adc0_v", 2.5, Origin::Pin);
    assert_eq!(device.learner_inputs.learner.value("adc0_v"), Some(2.5));
    // ... what is fed stands before it, and it comes back once that is forgotten; forgotten itself it is not tested any more.
    say(&mut device, "cov adc0_v=9");
    device.on_own_column("adc0_v", 2.5, Origin::Pin);
    assert_eq!(device.learner_inputs.learner.value("adc0_v"), Some(9.0));
    say(&mut device, "cov adc0_v=- temp_c=-");
    device.on_own_column("adc0_v", 2.5, Origin::Pin);
    warm(&mut device, Some(30.0));
    assert!(tested(&device).is_empty());
    // What it does not measure, nor three others beside one, changes nothing.
    let refused = say(&mut device, "cov adc0_v=on wind=on");
    assert!(
        refused
            .contains("err state the board does not measure wind; it measures: adc0_v, cpu_temp_c, temp_c"),
        "{refused}"
    );
    say(&mut device, "cov a=1 b=2 c=3");
    let refused = say(&mut device, "cov adc0_v=on");
    assert!(refused.starts_with("err state no room"), "{refused}");
    // A sensor without a temperature has the processor's.
    device.begin_anew(device.config);
    device.on_own_column("cpu_temp_c", 40.0, Origin::Inside);
    assert!(tested(&device).is_empty());
    warm(&mut device, None);
    device.on_own_column("cpu_temp_c", 40.0, Origin::Inside);
    assert_eq!(tested(&device), ["cpu_temp_c"]);
}

/// A device whose calibration is the identity, and its readings while it turns to and fro by this much with another offset, counts of
/// 0.1 µT.
pub(super) fn turned(most_deg: f64, offset: [i16; 3], seconds: u64) -> Device {
    let sensor = Sensor::uniform("a chip", 0.1, 50.0);
    let mut device = Device::new(DeviceConfig { board: "bench", sensor, pace: Pace::Pushed });
    // Without a store, and with a sensor.
    device.rest();
    device.sensor = SensorWatch::new(Pace::Pushed, &sensor);
    let column = ColumnName::new("current_a").expect("a name");
    let mut record = record(BuiltIn::Offset(Offset::linear(column, 1.0)));
    record.effects = Effects::none();
    record.predicted_error = crate::record::PredictedError::of_share(2e-4);
    Active::install(&mut device.active, Slot::A, &record, AxisMap::IDENTITY);
    turn(&mut device, most_deg, offset, 0..seconds);
    device
}

fn turn(device: &mut Device, most_deg: f64, offset: [i16; 3], seconds: std::ops::Range<u64>) {
    for i in seconds.start * 50..seconds.end * 50 {
        let (t, most) = (i as f64 * 0.02, most_deg.to_radians());
        let (a, b) = (most * crate::math::sin(1.1 * t), most * crate::math::sin(0.7 * t + 1.0));
        let (cos, sin) = (crate::math::cos, crate::math::sin);
        let field = [cos(a) * cos(b), sin(a) * cos(b), sin(b)];
        let counts = [0, 1, 2].map(|axis| (500.0 * field[axis]) as i16 + offset[axis]);
        device.on_sample(&Reading { counts, overflow: [false; 3] }, 20 * i);
    }
}

/// The number behind this key.
pub(super) fn number(line: &str, key: &str) -> f64 {
    let after = line.split_once(key).unwrap_or_else(|| panic!("{key} in {line}")).1;
    after.split([' ', ';']).next().and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("{line}"))
}

#[test]
fn a_changed_offset_is_proposed_and_zeroed_and_waits() {
    let mut device = turned(40.0, [40, -30, 60], 60);
    let status = answer(&mut device, "status", 60_000);
    assert!(status.contains("+ offset change_ut=") && status.contains("cal zero"), "{status}");
    let before = device.record().expect("in use").calibration;
    let said = answer(&mut device, "cal zero", 60_020);
    assert!(said.starts_with("ok state=solved change_ut=7.8"), "{said}");
    let error_ut = number(&said, "error_ut=");
    assert!(error_ut < 0.5, "{said}");
    assert_eq!(device.record().expect("in use").calibration, before, "nothing is applied by itself");
    let waiting = device.waiting().expect("it waits for cal accept").calibration;
    for (found, truth) in waiting.offset_ut.into_iter().zip([4.0, -3.0, 6.0]) {
        assert!((found - truth).abs() < 3.0 * error_ut, "{found} {truth} {error_ut}");
    }
    assert_eq!(waiting.matrix, before.matrix);
    assert!(answer(&mut device, "cal cancel", 60_040).starts_with("ok state=idle"));
}

#[test]
fn an_offset_that_is_right_is_not_proposed() {
    let mut device = turned(40.0, [0; 3], 60);
    let status = answer(&mut device, "status", 60_000);
    assert!(!status.contains("+ offset"), "{status}");
}

#[test]
fn cal_zero_says_why_the_turns_do_not_suffice() {
    let refused = |mut device: Device, seconds: u64, words: &str| {
        let said = answer(&mut device, "cal zero", 1000 * seconds);
        assert!(said.starts_with("err refused ") && said.contains(words), "{said}");
        assert!(device.waiting().is_none());
    };
    refused(turned(0.0, [40, -30, 60], 60), 60, "too-few-samples");
    refused(turned(5.0, [40, -30, 60], 600), 600, "error-too-large");
    // Half of the looks are of another offset.
    let mut moved = turned(40.0, [40, -30, 60], 60);
    turn(&mut moved, 40.0, [-90, 30, 60], 60..66);
    refused(moved.clone(), 66, "residual-too-large");
    // Begun again, the rest is enough.
    assert!(answer(&mut moved, "cal zero start", 66_000).starts_with("ok turns=0"));
    turn(&mut moved, 40.0, [-90, 30, 60], 67..120);
    assert!(answer(&mut moved, "cal zero", 120_000).starts_with("ok state=solved"));
    let mut none = turned(0.0, [0; 3], 1);
    none.active = None;
    assert!(answer(&mut none, "cal zero", 1000).starts_with("err state there is no calibration in use"));
}

/// A gyro of 1 % of gain that is fed in this way, while the board turns to and fro by this much about all its axes with an offset.
fn turned_with_gyro(most_deg: f64, feed: impl Fn(&mut Device, [f32; 3], u64)) -> Device {
    let mut device = turned(0.0, [0; 3], 1);
    let mut field = [20.0, 0.0, 45.8_f64];
    for i in 50..3050_u64 {
        let most = most_deg.to_radians();
        let rate = [1.9, 1.3, 2.3].map(|pace| most * pace * crate::math::cos(pace * i as f64 * 0.02 + pace));
        feed(&mut device, rate.map(|rate| (1.01 * rate + 0.01) as f32), 20 * i);
        let counts = [0, 1, 2].map(|axis| (10.0 * field[axis]).round() as i16 + [40, -30, 60][axis]);
        device.on_sample(&Reading { counts, overflow: [false; 3] }, 20 * i);
        field = crate::vector::turned(field, rate.map(|rate| -0.02 * rate));
    }
    device
}

#[test]
fn a_gyro_that_is_fed_makes_the_offset_more_exact() {
    let zeroed = |mut device: Device| answer(&mut device, "cal zero", 61_000);
    let without = zeroed(turned_with_gyro(15.0, |_, _, _| {}));
    assert!(without.starts_with("ok state=solved") && without.ends_with("gyro=none"), "{without}");
    let by_owner = zeroed(turned_with_gyro(15.0, |device, rate, _| device.on_motion(None, Some(rate))));
    let by_console = zeroed(turned_with_gyro(15.0, |device, [x, y, z], now_ms| {
        let line = std::format!("cov gx_radps={x} gy_radps={y} gz_radps={z}");
        assert!(answer(device, &line, now_ms).starts_with("ok"));
    }));
    for said in [&by_owner, &by_console] {
        assert!(said.starts_with("ok state=solved") && said.ends_with("gyro=used"), "{said}");
        let (change_ut, error_ut) = (number(said, "change_ut="), number(said, "error_ut="));
        assert!((change_ut - 7.81).abs() < 2.0 * error_ut, "{said}");
        assert!(error_ut < number(&without, "error_ut="), "{said} {without}");
    }
    // It says nothing any more, or something else.
    let silent = zeroed(turned_with_gyro(30.0, |device, rate, now_ms| {
        if now_ms < 2000 {
            device.on_motion(None, Some(rate));
        }
    }));
    assert!(silent.ends_with("gyro=none"), "{silent}");
    let degrees =
        |device: &mut Device, rate: [f32; 3], _| device.on_motion(None, Some(rate.map(f32::to_degrees)));
    let wrong = zeroed(turned_with_gyro(30.0, degrees));
    assert!(wrong.ends_with("gyro=disagrees"), "{wrong}");
    let wrong = zeroed(turned_with_gyro(10.0, degrees));
    assert!(wrong.starts_with("err refused error-too-large") && wrong.contains("unit (rad/s)"), "{wrong}");
}

#[test]
fn level_turns_are_refused_with_a_gyro_too() {
    let mut device = turned(0.0, [0; 3], 1);
    for i in 50..3050_u64 {
        let heading = i as f64 * 0.02;
        let (north, east) = (crate::math::cos(heading), -crate::math::sin(heading));
        device.on_motion(None, Some([0.0, 0.0, 1.0]));
        let counts = [(200.0 * north) as i16 + 40, (200.0 * east) as i16 - 30, 458 + (i % 2) as i16];
        device.on_sample(&Reading { counts, overflow: [false; 3] }, 20 * i);
    }
    let said = answer(&mut device, "cal zero", 61_000);
    assert!(
        said.starts_with("err refused error-too-large") && said.contains("tilt the sensor further"),
        "{said}"
    );
}
