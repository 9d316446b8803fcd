//! One recording through the board's core and through the host's analysis: the same names, the same statuses, the same numbers.
//!
//! The base is the same to the bit. With an effect the board goes through the recording twice: the first time it finds where it has
//! to make the model linear, the second time it stands there from the first sample on, as the host does in its last pass.

use ironout_analysis::calibration::FittedEffect;
use ironout_analysis::{Diagnosis, Options, diagnose, fit};
use ironout_host_tests::learning::{Board, One, Recording, Said, apart};
use ironout_simulation::{EffectSpec, Temperature, World, WorldOptions};

/// Seeds that the study was not made with.
const FIRST: u64 = 9001;
const FIELD_UT: f64 = 50.0;
const TESTED: [&str; 2] = ["temp_c", "current_a"];
const RATE_HZ: f64 = 75.0;

fn recording(hidden: &str, temperature: Temperature, seed: u64, without: &[&str]) -> Recording {
    let log = World::new(WorldOptions {
        seed,
        rate_hz: RATE_HZ,
        lsb_ut: 0.0,
        temperature,
        effects: EffectSpec::parse(hidden).into_iter().collect(),
        ..WorldOptions::default()
    })
    .run();
    let without: Vec<&str> = without.iter().copied().chain(["height_m"]).collect();
    Recording::of_log(&log, &without).expect("a simulated log has a clock and a magnetometer")
}

/// A board that has collected the recording so often, accepting what was accepted; and its clock at the last beginning, s. More than
/// once: up to four times, until it has stood well from the first sample on.
fn board(recording: &Recording, times: usize) -> (Board, f64) {
    let mut board = Board::new(RATE_HZ as f32);
    assert_eq!(board.last(&format!("field {FIELD_UT}")), "ok field_ut=50.0");
    let mut begin_ms = 0;
    for time in 0..if times > 1 { 4 } else { 1 } {
        if time >= times && board.device().learner().rows() as usize == recording.rows() {
            break;
        }
        begin_ms = board.next_row_ms();
        assert_eq!(board.last("cal start"), "ok state=collecting");
        board.feed(recording, 0..recording.rows(), &TESTED);
        if board.last("cal stop").starts_with("ok verdict=accepted") {
            assert!(board.last("cal accept force").starts_with("ok calibrated=1 "));
        }
    }
    (board, begin_ms as f64 * 1e-3)
}

fn options(add: &[&str]) -> Options {
    let add: Vec<String> = add.iter().map(|id| (*id).to_owned()).collect();
    Options { field_ut: Some(FIELD_UT), search: add.is_empty(), add, ..Options::default() }
}

/// The same verdict, and the same said of every effect that both know.
fn same_words(said: &Said, host: &Diagnosis) {
    assert_eq!(said.verdict(), host.verdict.name(), "{:?}", said.lines);
    for id in ["offset:temp_c", "offset:current_a", "drift", "step", "lag"] {
        let of_host = host.candidates.iter().find(|one| one.id == id).map(|one| one.status.name());
        let of_board = said.of(id, "status");
        // The dip is looked at anew where the base has moved, and a board may know no moment that a step could be at.
        let not_yet =
            ["lag", "step"].contains(&id) && of_board == Some("untestable") && of_host == Some("not-needed");
        assert!(of_board == of_host || not_yet, "{id}: {of_host:?} {:?}", said.lines);
    }
    let added = host.steps.iter().find_map(|step| step.added.as_deref());
    if let Some(added) = added {
        assert_eq!(said.first(), added, "{:?}", said.lines);
    }
}

/// What both have of an effect: the board's, the host's, and that with its standard errors.
fn both(board: &mut Board, recording: &Recording, id: &str) -> (One, One, FittedEffect) {
    let answer = board.last(&format!("effect add {id}"));
    assert!(answer.starts_with("ok effects=1 "), "{id}: {answer}");
    let record = *board.record().expect("stored");
    let own = record.effects.iter().next().expect("the effect");
    let fitted = fit(&recording.table(), &options(&[id])).expect("a known effect");
    let solution = fitted.solution.expect("a calibration");
    let host = solution.effects.first().expect("the effect").clone();
    let three = |values: &[f64]| -> [f64; 3] {
        std::array::from_fn(|i| values.get(i).copied().filter(|value| value.is_finite()).unwrap_or(0.0))
    };
    let mine = One {
        calibration: record.calibration,
        theta: three(&own.coefficients),
        reference: own.effect.parts().reference().unwrap_or(0.0),
    };
    let its = One {
        calibration: solution.calibration,
        theta: three(&host.coefficients),
        reference: host.reference.first().map_or(0.0, |(_, value)| *value),
    };
    // What it says of the offset's error is the scale for both.
    assert!(solution.std_errors.offset_ut.iter().all(|error| (0.001..0.05).contains(error)));
    (mine, its, host)
}

#[test]
fn the_base_is_the_same_to_the_bit() {
    let axes = ["ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps"];
    for seed in FIRST..FIRST + 2 {
        let recording = recording("", Temperature::WarmUp, seed, &axes);
        let (mut board, _) = board(&recording, 1);
        let own = board.record().expect("accepted").calibration;
        let host = fit(&recording.table(), &options(&[])).expect("nothing is asked for");
        let host = host.solution.expect("a calibration").calibration;
        let bits = |c: &ironout::calibration::Calibration<f64>| {
            (c.offset_ut.map(f64::to_bits), c.matrix.map(|row| row.map(f64::to_bits)), c.field_ut.to_bits())
        };
        assert_eq!(bits(&own), bits(&host), "{own:?} and {host:?}");
        assert_eq!(board.why().verdict(), "complete");
    }
}

#[test]
fn what_follows_a_column_is_the_same_to_a_tenth_of_its_standard_error() {
    for (hidden, id, temperature) in [
        ("offset:temp_c=3", "offset:temp_c", Temperature::WarmUp),
        ("offset:current_a=3", "offset:current_a", Temperature::WarmUp),
        // As the clock: both say that it is confounded with a drift.
        ("offset:temp_c=3", "offset:temp_c", Temperature::Ramp),
    ] {
        for seed in FIRST..FIRST + 2 {
            let recording = recording(hidden, temperature, seed, &[]);
            let (mut board, _) = board(&recording, 2);
            let rows = board.device().learner().rows() as usize;
            assert_eq!(rows, recording.rows(), "{id} {seed}: from the first sample on");
            same_words(&board.why(), &diagnose(&recording.table(), &options(&[])).expect("a log"));
            let (mine, its, host) = both(&mut board, &recording, id);
            let apart = apart(&mine, &its);
            println!("{id} {temperature:?} {seed}: {apart:?} {:?}", host.std_errors);
            for axis in 0..3 {
                let errors = (mine.theta[axis] - its.theta[axis]) / host.std_errors[axis];
                assert!(errors.abs() < 0.15, "{id} {seed}: {errors} standard errors on axis {axis}");
            }
            assert!(apart.offset_ut < 0.001 && apart.triangle < 0.000_05, "{id} {seed}: {apart:?}");
        }
    }
}

#[test]
fn a_step_and_a_lag_are_the_same_to_what_a_board_can_tell() {
    for seed in FIRST..FIRST + 2 {
        let recording = recording("step=3", Temperature::WarmUp, seed, &[]);
        let (mut board, begin_s) = board(&recording, 1);
        let said = board.why();
        same_words(&said, &diagnose(&recording.table(), &options(&[])).expect("a log"));
        let (mine, its, host) = both(&mut board, &recording, "step");
        let own =
            board.record().and_then(|record| record.effects.iter().next().copied()).expect("the effect");
        let at_s = own.effect.parts().parameter().map_or(f64::NAN, |(_, value)| value) - begin_s;
        let host_s = host.parameters.first().map_or(f64::NAN, |(_, value)| *value);
        println!("step {seed}: {at_s} {host_s} {:?}", apart(&mine, &its));
        assert!((at_s - host_s).abs() < 0.5, "{at_s} and {host_s}");
        assert!(apart(&mine, &its).coefficient < 0.15, "{mine:?} {its:?}");
    }
    for seed in FIRST..FIRST + 2 {
        let recording = recording("lag=18ms", Temperature::WarmUp, seed, &[]);
        let (mut board, _) = board(&recording, 2);
        same_words(&board.why(), &diagnose(&recording.table(), &options(&[])).expect("a log"));
        let (mine, its, host) = both(&mut board, &recording, "lag");
        let errors = (mine.theta[0] - its.theta[0]) / host.std_errors[0];
        println!("lag {seed}: {errors} standard errors");
        assert!(errors.abs() < 1.5, "{mine:?} {its:?}");
        assert!(apart(&mine, &its).triangle < 1e-6 && apart(&mine, &its).offset_ut < 1e-6);
    }
}
