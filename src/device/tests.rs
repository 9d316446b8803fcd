//! What a line of the console does to the correction.

extern crate std;

use super::active::Active;
use super::config::DeviceConfig;
use super::light::Light;
use super::machine::{Action, Device};
use super::sensor::{Pace, SensorAnswer, SensorTask};
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
fn record(effect: BuiltIn<f64>) -> Record {
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
    }
}

/// A device without sensor and store that applies this effect.
fn device(effect: BuiltIn<f64>) -> Device {
    let mut device = plain_device();
    device.rest();
    device.active = Some(Active::new(Slot::A, record(effect), AxisMap::IDENTITY));
    device
}

/// The answer to a line that comes at this time.
fn answer(device: &mut Device, line: &str, now_ms: u64) -> std::string::String {
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
    assert_eq!(corrected(&mut device, 0), None, "nothing is known yet");
    assert_eq!(answer(&mut device, "cov current_a=1", 10), "ok current_a=1.0 used=1 tested=1");
    assert_eq!(corrected(&mut device, 20), Some([20.0, -10.0, 35.0]), "the current at the reference");
    assert_eq!(answer(&mut device, "cov current_a=5", 30), "ok current_a=5.0 used=1 tested=1");
    assert_eq!(corrected(&mut device, 40), Some([12.0, -6.0, 33.0]));
    assert_eq!(answer(&mut device, "cov throttle=9", 50), "ok throttle=9.0 used=0 tested=1");
    assert_eq!(corrected(&mut device, 60), Some([12.0, -6.0, 33.0]));
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
    device.active = Some(Active::new(Slot::A, drift, AxisMap::IDENTITY));
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
    device.store_unread = false;
    for (record, hint) in [
        (
            mounted_otherwise,
            "+ hint the stored calibration is not applied: it was made with the sensor mounted",
        ),
        (drift, "+ hint the calibration waits for: cov t_s=VALUE"),
    ] {
        device.active = Some(Active::new(Slot::A, record, AxisMap::IDENTITY));
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
    let _ = answer(&mut used, "cov temp_c=20 current_a=3", 5);
    let _ = answer(&mut used, "field 48", 6);
    used.begin_anew(config);
    let mut new = Device::new(config);
    for (line, now_ms) in [("status", 2000), ("effect list", 2001), ("cal show", 2002), ("version", 2003)] {
        assert_eq!(answer(&mut used, line, now_ms), answer(&mut new, line, now_ms), "{line}");
    }
    assert_eq!(used.session.config(), new.session.config());
}
