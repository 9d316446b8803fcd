//! The board's own study on the simulated bus: hidden effects are named, taken in, kept over a restart, and taken out again.
//!
//! A few seeds of the table that the program `learning` writes in full.

use ironout_host_tests::learning::{Kind, Trace, TraceOptions, row};
use ironout_simulation::Motion;

/// Seeds that the study was not made with.
const FIRST: u64 = 3001;

/// Names what was hidden in all of some traces but `misses`.
fn named(kind: Kind, correlation: f64, motion: Motion, traces: u64, misses: u64) {
    let row = row(kind, correlation, motion, FIRST..FIRST + traces);
    assert!(row.right.count + misses >= row.right.of, "{}: {} wrong: {:?}", row.name, row.right, row.wrong);
}

#[test]
fn a_hidden_effect_is_named_first() {
    for kind in Kind::HIDDEN {
        named(kind, 0.0, Motion::Sphere, 8, 0);
    }
}

#[test]
fn nothing_is_missing_in_clean_traces_and_a_confounded_pair_is_called_so() {
    named(Kind::Clean, 0.0, Motion::Sphere, 12, 0);
    named(Kind::Clean, 0.6, Motion::Sphere, 4, 0);
    named(Kind::Clean, 0.9, Motion::Sphere, 4, 1);
    named(Kind::Clean, 0.0, Motion::Hand, 4, 0);
    named(Kind::Ramp, 0.0, Motion::Sphere, 6, 0);
}

#[test]
fn noise_with_a_memory_and_a_hand_hide_no_effect_of_the_magnitude() {
    // The gyro tells a late sensor from the acceleration of a hand.
    named(Kind::Lag, 0.0, Motion::Hand, 6, 1);
    for kind in [Kind::Temperature, Kind::Current, Kind::Step] {
        named(kind, 0.6, Motion::Sphere, 3, 0);
        named(kind, 0.9, Motion::Sphere, 3, 1);
        named(kind, 0.0, Motion::Hand, 3, 0);
    }
}

/// Rms of the dip that is streamed, degrees: the angle between the corrected field and gravity, about its mean.
fn dip_rms_deg(trace: &mut Trace, seconds: u64) -> f64 {
    let begin_ms = trace.board.clock.ms();
    let values = trace.streamed(seconds);
    let step_s = seconds as f64 / values.len() as f64;
    let dips: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(index, (field, _))| {
            let force = trace.world.accel_mps2(begin_ms as f64 * 1e-3 + (index as f64 + 0.5) * step_s);
            let dot: f64 = (0..3).map(|axis| -force[axis] * field[axis]).sum();
            let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            (dot / size(&force) / size(field)).asin().to_degrees()
        })
        .collect();
    let mean = dips.iter().sum::<f64>() / dips.len() as f64;
    (dips.iter().map(|dip| (dip - mean) * (dip - mean)).sum::<f64>() / dips.len() as f64).sqrt()
}

#[test]
fn an_effect_that_is_added_takes_the_streamed_residual_to_the_noise_and_survives_a_restart() {
    for kind in [Kind::Temperature, Kind::Current, Kind::Step] {
        let mut trace = Trace::new(TraceOptions::new(kind, FIRST));
        trace.calibrate();
        let before_ut = trace.why().base("rms_ut");
        let added = trace.last(&format!("effect add {}", kind.id()));
        assert!(added.starts_with("ok effects=1 "), "{kind:?}: {added}");
        let said = trace.why();
        assert_eq!(said.of(kind.id(), "status"), Some("in-use"), "{:?}", said.lines);
        let floor_ut = said.base("noise_floor_ut");
        let streamed_ut = trace.streamed_rms_ut(20);
        println!("{kind:?}: {before_ut:.3} {streamed_ut:.3} floor {floor_ut:.3}");
        let most = 1.1;
        assert!(streamed_ut <= most * floor_ut, "{kind:?}: {streamed_ut} over a floor of {floor_ut}");
        let shown = trace.board.command("cal show");
        assert!(shown.iter().any(|line| line.starts_with(&format!("+ effect={} ", kind.id()))), "{shown:?}");

        trace.board.restart();
        trace.run_ms(2000);
        assert_eq!(trace.board.command("cal show"), shown, "{kind:?}: the same to the last digit");
        let after_ut = trace.streamed_rms_ut(20);
        assert!(
            after_ut <= most * floor_ut,
            "{kind:?}: {after_ut} over a floor of {floor_ut} after a restart"
        );

        let removed = trace.last(&format!("effect remove {}", kind.id()));
        assert!(removed.starts_with("ok effects=0 "), "{kind:?}: {removed}");
        let shown = trace.board.command("cal show");
        assert!(shown.iter().all(|line| !line.starts_with("+ effect=")), "{shown:?}");
        if kind == Kind::Step {
            // What was attached is attached still: without it the board is off by the whole step.
            assert!(trace.streamed_rms_ut(20) > 1.5 * floor_ut);
        }
    }
}

#[test]
fn an_effect_that_is_removed_brings_the_old_error_back() {
    let mut trace = Trace::new(TraceOptions::new(Kind::Temperature, FIRST + 1));
    trace.calibrate();
    let before_ut = trace.why().base("rms_ut");
    assert!(trace.last("effect add offset:temp_c").starts_with("ok effects=1 "));
    assert!(trace.why().base("rms_ut") < 0.6 * before_ut);
    assert!(trace.last("effect add offset:temp_c").starts_with("err state offset:temp_c is in use"));
    assert!(trace.last("effect remove offset:temp_c").starts_with("ok effects=0 "));
    let said = trace.why();
    let again_ut = said.base("rms_ut");
    assert!((again_ut / before_ut - 1.0).abs() < 0.05, "{before_ut} and then {again_ut}");
    assert_eq!(said.first(), "offset:temp_c", "{:?}", said.lines);
    assert!(trace.last("effect remove offset:temp_c").starts_with("err state offset:temp_c is not in use"));
}

#[test]
fn a_lag_is_seen_in_the_dip_and_taken_off_live() {
    let mut trace = Trace::new(TraceOptions::new(Kind::Lag, FIRST));
    trace.calibrate();
    let said = trace.why();
    assert_eq!(said.of("lag", "status"), Some("missing"), "{:?}", said.lines);
    let before_deg = said.base("dip_rms_deg");
    assert!(trace.last("effect add lag").starts_with("ok effects=1 "));
    let after_deg = trace.why().base("dip_rms_deg");
    let shown = trace.board.command("cal show");
    let row = shown.iter().find(|line| line.starts_with("+ effect=lag coefficients=")).expect("a lag");
    let delay_s: f64 = row.split(['=', ' ', ',']).nth(4).and_then(|word| word.parse().ok()).expect("a delay");
    println!("{before_deg:.3} {after_deg:.3} deg, {delay_s} s");
    assert!(after_deg < 0.85 * before_deg, "{before_deg} and then {after_deg}");
    // Up to 2 ms are the age of a sample and of the motion that it is held against.
    assert!((delay_s - 0.018).abs() < 0.003, "{delay_s}");
    let with_deg = dip_rms_deg(&mut trace, 20);
    assert!(trace.last("effect remove lag").starts_with("ok effects=0 "));
    let without_deg = dip_rms_deg(&mut trace, 20);
    assert!(with_deg < 0.85 * without_deg, "{with_deg} with it, {without_deg} without");
}

#[test]
fn without_a_gyro_the_field_itself_shows_a_late_sensor_and_corrects_it() {
    let (mut with, mut without) = (0.0, 0.0);
    for seed in FIRST..FIRST + 4 {
        let mut trace = Trace::new(TraceOptions { gyro: false, ..TraceOptions::new(Kind::Lag, seed) });
        trace.calibrate();
        let said = trace.why();
        assert_eq!(said.first(), "lag", "{:?}", said.lines);
        assert!(trace.last("effect add lag").starts_with("ok effects=1 "));
        let with_deg = dip_rms_deg(&mut trace, 40);
        assert!(trace.last("effect remove lag").starts_with("ok effects=0 "));
        let without_deg = dip_rms_deg(&mut trace, 40);
        println!("{with_deg:.3} deg with it, {without_deg:.3} without");
        (with, without) = (with + with_deg * with_deg, without + without_deg * without_deg);
    }
    assert!(with < 0.9 * without, "{with} deg² with it, {without} without");
    let mut clean = Trace::new(TraceOptions {
        gyro: false,
        motion: Motion::Hand,
        ..TraceOptions::new(Kind::Clean, FIRST)
    });
    clean.calibrate();
    assert_eq!(clean.why().verdict(), "complete");
}

#[test]
fn what_the_samples_do_not_show_is_refused() {
    let mut trace = Trace::new(TraceOptions::new(Kind::Clean, FIRST));
    trace.calibrate();
    let before = trace.board.command("cal show");
    for id in ["drift", "offset:current_a", "offset:temp_c"] {
        let answer = trace.last(&format!("effect add {id}"));
        assert!(
            answer.starts_with("err refused not-needed not significant in these samples"),
            "{id}: {answer}"
        );
    }
    for id in ["offset:fan_rpm", "gain:temp_c", "nonsense"] {
        let answer = trace.last(&format!("effect add {id}"));
        assert!(answer.starts_with(&format!("err unknown {id} is not tested here")), "{id}: {answer}");
    }
    assert_eq!(trace.board.command("cal show"), before, "nothing changed");
    let list = trace.board.command("effect list");
    for id in ["drift", "offset:current_a", "offset:temp_c", "lag"] {
        assert!(
            list.iter().any(|line| line.starts_with(&format!("+ effect id={id} state=tested "))),
            "{list:?}"
        );
    }
}

#[test]
fn the_console_document_shows_what_a_board_says() {
    let document = include_str!("../../../docs/console.md");
    let mut trace = Trace::new(TraceOptions::new(Kind::Temperature, 1));
    trace.calibrate();
    let why = trace.why().lines.join("\n");
    let added = trace.last("effect add offset:temp_c");
    let block = format!("> why\n{why}\n> effect add offset:temp_c\n{added}\n");
    assert!(document.contains(&block), "docs/console.md should have:\n{block}");
}
