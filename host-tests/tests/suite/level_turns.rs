//! `cal start level` on the simulated board: what has moved is calibrated anew, and a calibration that is as good stays.

use std::cell::Cell;
use std::f64::consts::TAU;
use std::rc::Rc;

use crate::common::{HARD_IRON_UT, NOISE_UT, calibrate, last, value};
use ironout::device::ButtonEvent;
use ironout_rig::board::SimBoard;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// North and down, µT.
const EARTH_UT: Vector3<f64> = Vector3::new(21.0, 0.0, 45.38);
/// Seconds of a circle.
const CIRCLE_S: f64 = 12.0;
/// Samples in all directions until this time, circles to the right and to the left from then on.
const SPHERE_S: f64 = 61.0;

/// What the sensor of a board reads, its offset moved by what the cell says.
fn board(seed: u64, soft: Matrix3<f64>, moved_ut: Rc<Cell<[f64; 3]>>) -> SimBoard {
    let field = move |t_s: f64| {
        let attitude = if t_s < SPHERE_S {
            Rotation3::from_euler_angles(1.7 * t_s, 0.37 * t_s, 0.9 * t_s + seed as f64)
        } else {
            let on = t_s - SPHERE_S;
            let turned = if on < 2.0 * CIRCLE_S { on } else { 4.0 * CIRCLE_S - on };
            let pitch = 0.01 * (4.1 * on).sin();
            Rotation3::from_euler_angles(0.0, pitch, TAU * turned / CIRCLE_S + seed as f64)
        };
        let offset_ut = Vector3::from(HARD_IRON_UT) + Vector3::from(moved_ut.get());
        (soft * (attitude.inverse() * EARTH_UT) + offset_ut).into()
    };
    let mut board = SimBoard::new(field, NOISE_UT, seed);
    board.run_ms(100);
    board
}

/// Gains of the axes; no soft iron turns the axes, so that a full calibration is right about the vertical.
const GAINS: Matrix3<f64> = Matrix3::new(1.05, 0.0, 0.0, 0.0, 0.97, 0.0, 0.0, 0.0, 1.01);
/// Soft iron that turns them: an ellipsoid does not show by how much.
const TURNED: Matrix3<f64> = Matrix3::new(1.05, 0.02, -0.01, 0.02, 0.97, 0.03, -0.01, 0.03, 1.01);

/// A board with a full calibration in use, and then an offset that has moved.
fn calibrated(seed: u64, soft: Matrix3<f64>, change_ut: [f64; 3]) -> SimBoard {
    let moved_ut = Rc::new(Cell::new([0.0; 3]));
    let mut board = board(seed, soft, moved_ut.clone());
    let verdict = calibrate(&mut board, 60);
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"));
    moved_ut.set(change_ut);
    board.run_ms(1000);
    board
}

/// What the level session in the document says; lines that are typed begin with `>`.
fn session(board: &mut SimBoard) -> Vec<String> {
    let mut said = Vec::new();
    for (command, seconds) in [
        ("cov ax_mps2=0 ay_mps2=0 az_mps2=-9.81", 0.0),
        ("cal start level", 4.0 * CIRCLE_S),
        ("status", 0.0),
        ("cal stop", 0.0),
        ("cal accept", 0.0),
    ] {
        said.push(format!("> {command}"));
        said.extend(board.command(command));
        board.run_ms((1000.0 * seconds) as u64);
    }
    said
}

#[test]
fn the_console_document_shows_what_a_board_says_of_level_turns() {
    let document = include_str!("../../../docs/console.md");
    for change_ut in [[6.0, -4.0, 3.0], [0.0; 3]] {
        let said = session(&mut calibrated(1, GAINS, change_ut));
        // The second session begins as the first one does.
        let from = if change_ut == [0.0; 3] {
            said.iter().position(|line| line == "> cal stop").unwrap()
        } else {
            0
        };
        let block = said[from..].join("\n");
        assert!(document.contains(&block), "docs/console.md should have:\n{block}");
    }
}

#[test]
fn a_calibration_whose_level_headings_are_as_good_stays() {
    for seed in 1..=12 {
        let mut board = calibrated(seed, GAINS, [0.0; 3]);
        let shown = board.command("cal show");
        let said = session(&mut board);
        let stopped = said.iter().find(|line| line.starts_with("ok verdict")).expect("accepted");
        assert!(said.iter().any(|line| line.starts_with("+ note worse-than-in-use ")), "{seed}: {said:#?}");
        let accepted = said.last().expect("an answer");
        assert!(accepted.starts_with("err refused worse-than-in-use "), "{seed}: {said:#?}");
        assert!(
            value(stopped, "in_use_error_deg").parse::<f64>().is_ok_and(|error_deg| error_deg <= 0.15),
            "{stopped}"
        );
        assert_eq!(board.command("cal show"), shown);
        if seed == 1 {
            assert!(
                last(&mut board, "cal accept force").starts_with("ok calibrated=1"),
                "who insists gets it"
            );
            assert_ne!(board.command("cal show"), shown);
        }
    }
}

#[test]
fn what_has_moved_replaces_it() {
    // 3 µT of a horizontal field of 21 µT are 6° rms; soft iron that turned the axes, 2 or 3°.
    let moved = (1..=12).map(|seed| (seed, GAINS, [3.0, 1.0, 0.0], 5.0..7.5));
    let turned = (1..=12).map(|seed| (seed, TURNED, [0.0; 3], 2.0..3.5));
    for (seed, soft, change_ut, in_use_range) in moved.chain(turned) {
        let mut board = calibrated(seed, soft, change_ut);
        let said = session(&mut board);
        assert!(!said.iter().any(|line| line.contains("worse-than-in-use")), "{seed}: {said:#?}");
        let stopped = said.iter().find(|line| line.starts_with("ok verdict")).expect("accepted");
        let in_use_deg: f64 = value(stopped, "in_use_error_deg").parse().expect("a figure");
        assert!(in_use_range.contains(&in_use_deg), "{seed}: {stopped}");
        assert!(said.last().is_some_and(|line| line.starts_with("ok calibrated=1")), "{seed}: {said:#?}");
    }
}

#[test]
fn the_button_keeps_the_better_one_of_level_turns_too() {
    let mut board = calibrated(3, GAINS, [0.0; 3]);
    let shown = board.command("cal show");
    board.command("cov ax_mps2=0 ay_mps2=0 az_mps2=-9.81");
    board.command("cal start level");
    board.run_ms((4000.0 * CIRCLE_S) as u64);
    assert_eq!(board.press(), ButtonEvent::Worse);
    assert_eq!(board.command("cal show"), shown);
}
