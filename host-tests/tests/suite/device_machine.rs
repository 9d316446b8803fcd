//! The device as a state machine: any rate of the sensor, any mounting, any part of the world, and a console that never ends.

use crate::common::{last, value};
use ironout::calibration::Calibration;
use ironout::device::{
    Action, ButtonEvent, Device, DeviceConfig, Pace, SensorAnswer, SensorTask, StoreAnswer, StoreTask,
};
use ironout::effect::{BuiltIn, ColumnName, Offset, Past, Power};
use ironout::extended::{Effects, FittedEffect};
use ironout::fit::{Method, Order};
use ironout::record::Record;
use ironout::sensor::{Axis, AxisMap, Reading, Sensor};
use ironout_drivers::lsm303dlhc::{Config, DataRate, Range};
use ironout_rig::board::{SimBoard, SimOptions};
use ironout_rig::bus::Hit;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use std::cell::RefCell;
use std::rc::Rc;

#[test]
fn every_conversion_of_every_rate_is_taken_once() {
    for (rate, seconds) in [
        (DataRate::Hz0_75, 120),
        (DataRate::Hz1_5, 60),
        (DataRate::Hz7_5, 20),
        (DataRate::Hz30, 20),
        (DataRate::Hz75, 20),
        (DataRate::Hz220, 20),
    ] {
        let options = SimOptions {
            sensor: Config { rate, ..SimOptions::default().sensor },
            pace: Pace::EachConversion,
            ..SimOptions::default()
        };
        // No two conversions are the same, so that one taken twice would show.
        let mut board = SimBoard::with(options, |t_s: f64| [20.0 * t_s.sin(), 30.0, 1.0], 0.5, 3);
        board.run_ms(5000);
        last(&mut board, "stream raw");
        board.run_ms(1000 * seconds);
        let lines = board.received().into_iter().filter(|line| line.starts_with("R,")).collect::<Vec<_>>();
        let expected = f64::from(rate.hz()) * seconds as f64;
        assert!((lines.len() as f64 - expected).abs() <= 1.0 + 0.002 * expected, "{rate:?}: {}", lines.len());
        assert_eq!(board.device.samples_lost(), 0, "{rate:?}");
        assert_eq!(value(&last(&mut board, "status"), "faults"), "0", "{rate:?}: no start but the first");
    }
}

/// Polls until nothing is due, with `answer` for the sensor and no memory. Time does not pass but by the store's pauses.
fn settle(
    device: &mut Device,
    now_ms: &mut u64,
    mut answer: impl FnMut(SensorTask) -> SensorAnswer,
) -> String {
    let mut out = heapless::String::<4096>::new();
    let mut said = String::new();
    loop {
        match device.poll(*now_ms, &mut out) {
            Action::Sensor(task) => device.complete_sensor(answer(task), *now_ms),
            Action::Store(_) => device.complete_store(&StoreAnswer::Failed, *now_ms),
            Action::Again => {}
            Action::Sleep if device.is_idle() => return said + &out,
            Action::Sleep => *now_ms = device.next_deadline_ms().max(*now_ms + 1),
        }
        said += &out;
        out.clear();
    }
}

fn send(device: &mut Device, line: &str) {
    for byte in line.bytes().chain(*b"\n") {
        assert!(device.take_byte(byte), "nothing waits");
    }
}

const READING: Reading = Reading { counts: [100, -200, 300], overflow: [false; 3] };

#[test]
fn a_board_that_reads_its_sensor_itself_needs_nothing_but_to_hand_the_readings_over() {
    let sensor = Sensor::uniform("a chip", 0.1, 100.0);
    let mut device = Device::new(DeviceConfig { board: "pushed", sensor, pace: Pace::Pushed });
    // It never starts the sensor when asked to.
    let refuse = |_| SensorAnswer::NotReady;
    let mut now_ms = 0;
    send(&mut device, "cal start");
    assert!(settle(&mut device, &mut now_ms, refuse).starts_with("err sensor "), "nothing was heard of it");
    device.on_sample(&READING, now_ms);
    for (line, answer) in [("cal start", "ok state=collecting\n"), ("stream raw", "ok stream=raw\n")] {
        send(&mut device, line);
        assert_eq!(settle(&mut device, &mut now_ms, refuse), answer);
    }
    // Several in one go, as after a long turn: each has its line and its time.
    for t_ms in [now_ms + 10, now_ms + 20, now_ms + 30] {
        device.on_sample(&READING, t_ms);
    }
    let lines = settle(&mut device, &mut now_ms, refuse);
    assert_eq!(lines.lines().count(), 3, "{lines}");
    assert!(lines.lines().all(|line| line.starts_with("R,") && line.ends_with(",100,-200,300")), "{lines}");
    assert_eq!(device.session().counts().n + device.session().counts().skipped, 3);
}

#[test]
fn a_console_without_end_starves_neither_the_sensor_nor_the_button() {
    let sensor = Sensor::uniform("a chip", 0.1, 75.0);
    let mut device = Device::new(DeviceConfig { board: "flooded", sensor, pace: Pace::Every(20) });
    let mut out = heapless::String::<4096>::new();
    let (mut now_ms, mut samples, mut answers, mut longest_ms) = (0, 0_u64, 0, 0);
    let mut line_since_ms = None;
    let mut flood = "status\nhelp\nfield 48\ncal start\ncal cancel\n".bytes().cycle().peekable();
    let (mut pressed_ms, mut event_ms) = (None, None);
    while now_ms < 20_000 {
        while flood.peek().is_some_and(|&byte| device.take_byte(byte)) {
            flood.next();
        }
        if now_ms > 10_000 && pressed_ms.is_none() {
            device.on_press();
            pressed_ms = Some(now_ms);
        }
        let since_ms = *line_since_ms.get_or_insert(now_ms);
        match device.poll(now_ms, &mut out) {
            Action::Sensor(SensorTask::Start) => device.complete_sensor(SensorAnswer::Started, now_ms),
            Action::Sensor(SensorTask::Sample) => {
                samples += 1;
                let turn = samples as f64 * 0.05;
                let counts = [500.0 * turn.sin(), 500.0 * turn.cos(), 300.0 * (0.1 * turn).sin()];
                let reading = Reading { counts: counts.map(|c| c as i16), overflow: [false; 3] };
                device.complete_sensor(SensorAnswer::Reading(reading), now_ms);
            }
            Action::Sensor(SensorTask::Temperature) => {
                device.complete_sensor(SensorAnswer::Temperature(Some(25.0)), now_ms);
            }
            // An erased memory.
            Action::Store(StoreTask::Read { length, .. }) => {
                let bytes = std::iter::repeat_n(0xff, length).collect();
                device.complete_store(&StoreAnswer::Read(bytes), now_ms);
            }
            Action::Store(task) => panic!("nothing is stored: {task:?}"),
            // Whatever it was took its time; the line after it has waited since.
            Action::Again => now_ms += 9,
            Action::Sleep => now_ms = device.next_deadline_ms().max(now_ms + 1),
        }
        if out.lines().any(|line| line.starts_with("ok") || line.starts_with("err")) {
            answers += 1;
            longest_ms = longest_ms.max(now_ms - since_ms);
            line_since_ms = None;
        }
        out.clear();
        if event_ms.is_none() && device.take_event().is_some_and(|event| event == ButtonEvent::Started) {
            event_ms = Some(now_ms);
        }
    }
    assert_eq!(device.samples_lost(), 0);
    assert!((999..=1001).contains(&samples), "{samples}");
    assert!(answers > 1000, "{answers}");
    assert!(longest_ms < 400, "a line waited {longest_ms} ms");
    assert!(event_ms.unwrap() - pressed_ms.unwrap() < 100, "{pressed_ms:?} {event_ms:?}");
}

/// A vector through a side, by its name.
fn side(name: &str) -> Vector3<f64> {
    let mut direction = Vector3::zeros();
    for word in name.split('-') {
        direction += match word {
            "front" => Vector3::x(),
            "back" => -Vector3::x(),
            "right" => Vector3::y(),
            "left" => -Vector3::y(),
            "bottom" => Vector3::z(),
            "top" => -Vector3::z(),
            _ => panic!("{name}"),
        };
    }
    direction.normalize()
}

/// A user who first turns the board a little, and then does what the hint says until it says that it is enough. Returns how many
/// hints that took, with the last `status`, and the board.
fn obey(dip_deg: f64, mounting: AxisMap, seed: u64) -> (usize, String, SimBoard) {
    let field = 50.0 * Vector3::new(dip_deg.to_radians().cos(), 0.0, dip_deg.to_radians().sin());
    let start = UnitQuaternion::from_euler_angles(0.3 * seed as f64, 0.5, 1.0 + seed as f64);
    let attitude = Rc::new(RefCell::new(start));
    let seen = attitude.clone();
    let field_at_chip = move |_t_s: f64| {
        let at_board = seen.borrow().inverse() * field + Vector3::new(30.0, -20.0, 40.0);
        // The board's axis is the chip's axis that the map names.
        let mut at_chip = [0.0; 3];
        for (board, chip) in mounting.axes().into_iter().enumerate() {
            let (place, sign) = match chip {
                Axis::X => (0, 1.0),
                Axis::Y => (1, 1.0),
                Axis::Z => (2, 1.0),
                Axis::MinusX => (0, -1.0),
                Axis::MinusY => (1, -1.0),
                Axis::MinusZ => (2, -1.0),
            };
            at_chip[place] = sign * at_board[board];
        }
        at_chip
    };
    let options = SimOptions {
        sensor: Config { range: Range::Gauss1_9, ..SimOptions::default().sensor },
        mounting,
        ..SimOptions::default()
    };
    let mut board = SimBoard::with(options, field_at_chip, 0.3, seed);
    board.run_ms(100);
    last(&mut board, "field 50");
    last(&mut board, "cal start");
    let turn_to = |board: &mut SimBoard, target: UnitQuaternion<f64>| {
        let from = *attitude.borrow();
        for step in 1..=75 {
            let part = f64::from(step) / 75.0;
            // A hand wobbles a little on the way.
            let wobble = Vector3::new(0.15 * (9.0 * part).sin(), 0.15 * (7.0 * part).sin(), 0.0);
            let way = from.try_slerp(&target, part, 1e-9).unwrap_or(target);
            *attitude.borrow_mut() = way * UnitQuaternion::from_scaled_axis(wobble);
            board.run_ms(20);
        }
    };
    turn_to(&mut board, start * UnitQuaternion::from_euler_angles(0.4, -0.5, 0.3));
    for hints in 0..60 {
        let status = board.command("status");
        let Some((_, places)) = status[0].split_once("bring the ") else {
            return (hints, status.concat(), board);
        };
        let (missing, rest) = places.split_once(" side to where the ").unwrap();
        let now = rest.strip_suffix(" side is now").unwrap();
        let here = *attitude.borrow();
        let (from, to) = (here * side(missing), here * side(now));
        let turn = Rotation3::rotation_between(&from, &to)
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
        turn_to(&mut board, UnitQuaternion::from_rotation_matrix(&turn) * here);
    }
    panic!("dip {dip_deg}: 60 hints were not enough: {:?}", board.command("status"));
}

#[test]
fn the_hints_lead_to_a_calibration_anywhere_on_earth_and_on_a_rotated_chip() {
    let rotated = AxisMap::new([Axis::MinusY, Axis::Z, Axis::MinusX]).unwrap();
    let mut most = 0;
    for dip_deg in [65.0, 0.0, -65.0] {
        for mounting in [AxisMap::IDENTITY, rotated] {
            for seed in 1..4 {
                let (hints, status, mut board) = obey(dip_deg, mounting, seed);
                let place = format!("dip {dip_deg} {mounting:?} seed {seed}: {hints} hints, {status}");
                assert!(status.contains("enough directions covered"), "{place}");
                most = most.max(hints);
                let verdict = last(&mut board, "cal stop");
                assert!(verdict.starts_with("ok verdict=accepted"), "{place}: {verdict}");
                let offset_ut = board.device.session().solution().unwrap().calibration.offset_ut;
                for (found, truth) in offset_ut.into_iter().zip([30.0, -20.0, 40.0]) {
                    assert!((found - truth).abs() < 1.0, "{place}: {offset_ut:?} in the board's axes");
                }
            }
        }
    }
    println!("{most} hints at most");
    assert!(most <= 30, "{most}");
}

fn late(column: &str) -> FittedEffect<f64> {
    let column = ColumnName::new(column).unwrap();
    let effect = Offset { column, reference: 0.0, power: Power::Linear, past: Past::Delayed(0.2) };
    let coefficients = std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 });
    FittedEffect::new(BuiltIn::Offset(effect), coefficients, [0.01; 9])
}

/// A board in a constant field of (20, −10, 35) µT without noise, this record in its EEPROM.
fn board_with(record: &Record) -> SimBoard {
    let mut board = SimBoard::new(|_| [20.0, -10.0, 35.0], 0.0, 1);
    let encoded = record.encode().unwrap();
    board.eeprom.borrow_mut().memory[..encoded.as_bytes().len()].copy_from_slice(encoded.as_bytes());
    board.restart();
    board.run_ms(100);
    board
}

fn record(effects: &[FittedEffect<f64>]) -> Record {
    let mut list = Effects::none();
    effects.iter().for_each(|effect| list.push(*effect).unwrap());
    Record {
        sequence: 1,
        calibration: Calibration { offset_ut: [3.0, -2.0, 1.0], ..Calibration::identity(50.0) },
        effects: list,
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.25,
        axes: None,
        predicted_error: ironout::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    }
}

/// The corrected x of the last sample of half a second, or `None` where it is not known.
fn corrected_x(board: &mut SimBoard) -> Option<f64> {
    last(board, "stream cal");
    board.run_ms(500);
    let line = board.received().into_iter().rfind(|line| line.starts_with("C,")).expect("a sample");
    last(board, "stream off");
    line.split(',').nth(2).unwrap().parse().ok()
}

#[test]
fn a_record_with_four_late_columns_runs() {
    let mut board = board_with(&record(&["a_a", "b_a", "c_a", "d_a"].map(late)));
    assert_eq!(value(&last(&mut board, "status"), "calibrated"), "1");
    for column in ["a_a", "b_a", "c_a", "d_a"] {
        assert_eq!(corrected_x(&mut board), None, "{column} is not known yet");
        assert_eq!(
            last(&mut board, &format!("cov {column}=2")),
            format!("ok {column}=2.0 used=1 tested={}", u8::from(column != "d_a" && column != "c_a"))
        );
    }
    let x = corrected_x(&mut board).expect("all four are known");
    assert!((x - (20.0 - 3.0 - 8.0)).abs() < 0.1, "{x}");
}

#[test]
fn a_slot_that_does_not_answer_is_asked_again_and_the_columns_that_were_fed_stay() {
    let current = BuiltIn::Offset(Offset::linear(ColumnName::new("current_a").unwrap(), 0.0));
    let fitted = FittedEffect { effect: current, ..late("current_a") };
    let mut board = board_with(&record(&[fitted]));
    // Slot B is silent from the start on: its addresses are never acknowledged.
    let silent = |board: &SimBoard| {
        let at = Rc::new(RefCell::new(0_u64));
        board.store_faults.set(move |transaction, byte| {
            // Reads of slot A come first in every look at the store, seven chunks of them.
            let mut at = at.borrow_mut();
            if *at == 0 {
                *at = transaction;
            }
            if transaction >= *at + 7 && byte == 0 { Hit::Nack } else { Hit::Pass }
        });
    };
    silent(&board);
    board.restart();
    board.run_ms(200);
    assert_eq!(
        board.command("version")[0].split(',').next(),
        Some("+ slots=unreadable"),
        "now both are silent"
    );
    silent(&board);
    assert_eq!(last(&mut board, "cov current_a=4"), "ok current_a=4.0 used=1 tested=1");
    // Every line looks again, and nothing of it is forgotten.
    for _ in 0..3 {
        silent(&board);
        assert!((corrected_x(&mut board).expect("it was fed") - (17.0 - 4.0)).abs() < 0.1);
    }
    board.store_faults.clear();
    assert!((corrected_x(&mut board).expect("it was fed") - (17.0 - 4.0)).abs() < 0.1);
    assert_eq!(board.command("version")[0], "+ slots=current-1,empty");
}

#[test]
fn a_calibration_of_another_mounting_is_shown_and_not_applied() {
    let rotated = AxisMap::new([Axis::Y, Axis::MinusX, Axis::Z]);
    let mut board = board_with(&Record { axes: rotated, ..record(&[]) });
    let status = board.command("status");
    assert_eq!(value(&status[1], "calibrated"), "0");
    assert!(status[0].contains("not applied: it was made with another mounting of the sensor"), "{status:?}");
    assert!(last(&mut board, "stream cal").starts_with("err state "));
    assert!(last(&mut board, "cal show").ends_with("stored=1"), "it is there to be read");
    let mut board = board_with(&Record { axes: Some(AxisMap::IDENTITY), ..record(&[]) });
    assert!((corrected_x(&mut board).unwrap() - 17.0).abs() < 0.1);
}

#[test]
fn the_clock_that_is_fed_is_that_of_the_command() {
    let drift = BuiltIn::Drift(ironout::effect::Drift { reference_s: 100.0 });
    let mut board = board_with(&record(&[FittedEffect { effect: drift, ..late("x") }]));
    // No samples for three seconds: the time of the last one is not now.
    board.sensor_faults.hold_bus();
    board.run_ms(3000);
    last(&mut board, "cov t_s=100");
    board.sensor_faults.clear();
    board.run_ms(4000);
    let x = corrected_x(&mut board).unwrap();
    // Four to five seconds at 1 µT/s, and none of the three before.
    assert!((17.0 - x - 4.5).abs() < 0.7, "{x}");
}
