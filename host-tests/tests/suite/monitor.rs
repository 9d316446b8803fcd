//! The board itself says that its calibration is disturbed or outdated, and that it is good again.

use crate::common::{NOISE_UT, calibrate, last, world};
use ironout_rig::board::SimBoard;
use ironout_simulation::Motion;

/// A calibrated board on which something adds `extra_ut` to the y axis from 200 s to `until_s`.
fn board(seed: u64, extra_ut: f64, until_s: f64) -> SimBoard {
    let world = world(Motion::Sphere, seed);
    let field = move |t_s: f64| {
        let [x, y, z] = world.sensor_ut(t_s);
        [x, if (200.0..until_s).contains(&t_s) { y + extra_ut } else { y }, z]
    };
    let mut board = SimBoard::new(field, NOISE_UT, seed);
    board.run_ms(100);
    calibrate(&mut board, 60);
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"));
    board
}

fn condition(board: &mut SimBoard) -> String {
    let status = board.command("status");
    let line =
        status.iter().find(|line| line.starts_with("+ monitor ")).expect("a calibrated board watches itself");
    crate::common::value(line, "condition").to_string()
}

#[test]
fn a_visit_to_a_girder_disturbs_and_passes() {
    let mut board = board(51, 4.0, 230.0);
    board.run_ms(130_000);
    assert_eq!(condition(&mut board), "good");
    board.run_ms(20_000);
    assert_eq!(condition(&mut board), "disturbed");
    board.run_ms(40_000);
    assert_eq!(condition(&mut board), "good");
}

#[test]
fn a_magnet_outdates_the_calibration_until_there_is_another() {
    let mut board = board(52, 6.0, f64::INFINITY);
    board.run_ms(600_000);
    assert_eq!(condition(&mut board), "outdated");
    calibrate(&mut board, 60);
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"));
    board.run_ms(300_000);
    assert_eq!(condition(&mut board), "good");
}
