//! A battery that was swapped, and a vehicle that only turns level.

use crate::qemu::support::{HARD_IRON_UT, ask, board_with, bytes, eeprom, numbers, ok, record, start};
use ironout::heading::heading_deg;
use ironout::record::{PredictedError, Record};
use ironout_rig::qemu::{self, Emulator, Options, Reply};
use nalgebra::{Rotation3, Vector3};

/// North and down, µT.
const EARTH_UT: Vector3<f64> = Vector3::new(21.0, 0.0, 45.38);

/// The number behind a key of a reply.
fn number(reply: &Reply, key: &str) -> f64 {
    reply.value(key).and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{key} in {reply}"))
}

/// A board whose calibration has this hard iron.
fn calibrated(hard_iron_ut: f64) -> Emulator {
    let record = Record { predicted_error: PredictedError::of_share(2e-4), ..record(1, hard_iron_ut) };
    board_with(&eeprom([&bytes(&record), &[]]), &Options::default())
}

/// The field in the board's axes at a heading, pitch and roll, rad.
fn field_ut(heading: f64, pitch: f64, roll: f64) -> Vector3<f64> {
    Rotation3::from_euler_angles(roll, pitch, heading).inverse() * EARTH_UT
}

/// What the corrected stream says of a reading.
fn corrected(board: &mut Emulator, measured_ut: [f64; 3]) -> [f64; 3] {
    let lines = board.expose(measured_ut).expect("a sample");
    let [x, y, z, ..]: [f64; 5] = numbers(lines.last().expect("a line"), 2).try_into().expect("five numbers");
    [x, y, z]
}

#[test]
fn turns_by_thirty_degrees_give_the_offset_of_a_swapped_battery() {
    let Some(_turn) = qemu::turn("cal zero") else { return };
    let mut board = calibrated(HARD_IRON_UT);
    let moved = Vector3::new(6.0, -4.0, 5.0);
    let truth = moved.add_scalar(HARD_IRON_UT);
    ok(&mut board, "stream cal");
    let early = ask(&mut board, "cal zero");
    assert_eq!(early.code(), Some("refused"), "{early}");
    for i in 0..500 {
        let t = f64::from(i) * 0.1;
        let (yaw, pitch, roll) = (0.6 * (0.9 * t).sin(), 0.5 * (0.7 * t).sin(), 0.5 * (1.3 * t).cos());
        board.expose((field_ut(yaw, pitch, roll) + truth).into()).expect("a sample");
    }
    let status = ok(&mut board, "status");
    assert!(
        status.values("offset").count() == 1 || status.to_string().contains("offset change_ut="),
        "{status}"
    );
    let zeroed = ok(&mut board, "cal zero");
    let (change_ut, error_ut) = (number(&zeroed, "change_ut"), number(&zeroed, "error_ut"));
    assert!((change_ut - moved.norm()).abs() < 3.0 * error_ut && error_ut < 0.5, "{zeroed}");
    ok(&mut board, "cal accept");

    // After a power cut too: the field is right where the board was not.
    let mut board = start(board.power_cut().expect("power"));
    ok(&mut board, "stream cal");
    for heading in [0.0, 2.0, 4.0] {
        let field = field_ut(heading, 0.2, -0.1);
        let got = Vector3::from(corrected(&mut board, (field + truth).into()));
        assert!((got - field).norm() < 4.0 * error_ut.max(0.1), "{got} {field} {zeroed}");
    }
}

#[test]
fn level_circles_give_level_headings_that_outlast_a_power_cut() {
    let Some(_turn) = qemu::turn("cal start level") else { return };
    let mut board = calibrated(HARD_IRON_UT);
    let truth = Vector3::new(6.0, -4.0, 3.0).add_scalar(HARD_IRON_UT);
    ok(&mut board, "cov ax_mps2=0 ay_mps2=0 az_mps2=-9.81");
    ok(&mut board, "stream raw");
    board.expose((field_ut(0.0, 0.0, 0.0) + truth).into()).expect("a sample");
    ok(&mut board, "cal start level");
    let mut heading = 0.0;
    let mut circle = |board: &mut Emulator, sense: f64, samples: u32| {
        for i in 0..samples {
            heading += sense * std::f64::consts::TAU / 100.0;
            let pitch = 0.01 * (0.37 * f64::from(i)).sin();
            board.expose((field_ut(heading, pitch, 0.0) + truth).into()).expect("a sample");
        }
    };
    circle(&mut board, 1.0, 30);
    let early = ask(&mut board, "cal stop");
    assert_eq!(early.code(), Some("refused"), "{early}");
    circle(&mut board, 1.0, 200);
    circle(&mut board, -1.0, 200);
    let stopped = ok(&mut board, "cal stop");
    assert_eq!(stopped.value("model"), Some("level"), "{stopped}");
    let error_deg = number(&stopped, "heading_error_deg");
    let accepted = ok(&mut board, "cal accept");
    assert_eq!(accepted.value("holds_to_deg"), stopped.value("holds_to_deg"));
    println!("{stopped}\nstack used: {} bytes", board.stack_used().expect("a figure"));

    let mut board = start(board.power_cut().expect("power"));
    let status = ok(&mut board, "status");
    assert!(status.to_string().contains("holds_for tilt_deg="), "{status}");
    ok(&mut board, "stream cal");
    for place in 0..8 {
        let heading = f64::from(place) * std::f64::consts::FRAC_PI_4;
        let got = corrected(&mut board, (field_ut(heading, 0.0, 0.0) + truth).into());
        let off = heading_deg(got, [0.0, 0.0, -9.81], 0.0).expect("level") - heading.to_degrees();
        let off = off - 360.0 * (off / 360.0).round();
        // One count is 0.117 µT, 0.3° of a level field of 21 µT.
        assert!(off.abs() < 3.0 * error_deg + 0.4, "{place}: {off} of {error_deg}");
    }
    // Tilted, it says so with every sample.
    ok(&mut board, "cov ax_mps2=4.9 ay_mps2=0 az_mps2=-8.5");
    let lines = board.expose((field_ut(0.0, 0.5, 0.0) + truth).into()).expect("a sample");
    assert!(lines.last().is_some_and(|line| line.ends_with(",tilted")), "{lines:?}");
}
