//! A clearly better calibration is not replaced by an accepted worse one, unless that is asked for; one that no longer fits is.

use crate::common::{calibrate, last, value, world};
use ironout::device::ButtonEvent;
use ironout_rig::board::SimBoard;
use ironout_simulation::Motion;

/// Noise of an older chip on each axis, µT: so loud that the time of turning matters.
const NOISE_UT: f64 = 0.3;

fn board(seed: u64) -> SimBoard {
    let world = world(Motion::Sphere, seed);
    let mut board = SimBoard::new(move |t_s| world.sensor_ut(t_s), NOISE_UT, seed);
    board.run_ms(100);
    board
}

/// A board with a calibration of two minutes in use, and one of a few seconds solved and accepted by its verdict.
fn better_in_use_and_worse_solved(seed: u64) -> (SimBoard, f64, f64) {
    let mut board = board(seed);
    let good = calibrate(&mut board, 120);
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"), "{good}");
    let worse = calibrate(&mut board, 12);
    assert!(worse.starts_with("ok verdict=accepted"), "{worse}");
    let percent = |verdict: &str| value(verdict, "error_percent").parse().unwrap();
    (board, percent(&good), percent(&worse))
}

#[test]
fn a_worse_one_is_refused_and_taken_when_it_is_insisted() {
    let (mut board, good, worse) = better_in_use_and_worse_solved(31);
    assert!(worse > 2.0 * good && worse > 0.125, "{good} {worse}");
    let shown = board.command("cal show");
    let refused = last(&mut board, "cal accept");
    assert!(refused.starts_with("err refused worse-than-in-use "), "{refused}");
    assert!(refused.contains("cal accept force"), "{refused}");
    assert_eq!(board.command("cal show"), shown);
    board.restart();
    board.run_ms(100);
    assert_eq!(board.command("cal show"), shown, "nothing was stored");

    let (mut board, ..) = better_in_use_and_worse_solved(31);
    assert!(last(&mut board, "cal accept force").starts_with("ok calibrated=1"));
    assert_ne!(board.command("cal show"), shown);
}

#[test]
fn the_button_keeps_the_better_one() {
    let mut board = board(32);
    board.press();
    board.run_ms(120_000);
    assert!(matches!(board.press(), ButtonEvent::Accepted(_)));
    let shown = board.command("cal show");
    board.press();
    board.run_ms(12_000);
    assert_eq!(board.press(), ButtonEvent::Worse);
    assert_eq!(board.command("cal show"), shown);
}

#[test]
fn where_the_old_one_no_longer_fits_the_worse_one_takes_its_place() {
    // A magnet is put on the board after two minutes and a bit.
    let world = world(Motion::Sphere, 33);
    let field = move |t_s: f64| {
        let [x, y, z] = world.sensor_ut(t_s);
        [x, if t_s > 121.0 { y + 8.0 } else { y }, z]
    };
    let mut board = SimBoard::new(field, NOISE_UT, 33);
    board.run_ms(100);
    calibrate(&mut board, 120);
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"));
    board.run_ms(2_000);
    let verdict = calibrate(&mut board, 12);
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    let accepted = last(&mut board, "cal accept");
    assert!(accepted.starts_with("ok calibrated=1"), "{accepted}");
}
