//! Known answers of the engine as a whole, on simulated logs.

use crate::evidence::verdict::{Evidence, judge};
use crate::outcome::outcome::Verdict;
use crate::outcome::request::Options;
use crate::table::Table;
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

fn log(effects: &[&str], drop: &[&str], seed: u64) -> Log {
    World::new(WorldOptions {
        seed,
        seconds: 60.0,
        rate_hz: 25.0,
        effects: effects.iter().map(|effect| EffectSpec::parse(effect).unwrap()).collect(),
        drop_columns: drop.iter().map(|name| (*name).to_owned()).collect(),
        ..WorldOptions::default()
    })
    .run()
}

fn judged(log: &Log) -> Evidence {
    let table = Table::from_columns(log.named()).unwrap();
    judge(&table, &Options { search: true, ..Options::default() }, false)
}

#[test]
fn each_form_of_a_term_is_named_by_itself() {
    for effect in [
        "offset:temp_c",
        "offset:current_a^2",
        "gain:temp_c",
        "step",
        "nonlinearity",
        "periodic",
        "field:height_m",
    ] {
        let found = judged(&log(&[&format!("{effect}=4")], &[], 11));
        assert_eq!(found.named, [effect], "{found:?}");
        assert_eq!(found.verdict, Verdict::Missing, "{effect}");
        assert!(found.rms_ut[1] < 0.6 * found.rms_ut[0], "{effect}: {:?}", found.rms_ut);
    }
}

#[test]
fn a_late_sensor_is_found_by_the_dip_with_its_delay() {
    let found = judged(&log(&["lag=40ms"], &[], 5));
    assert_eq!(found.named, ["lag"]);
    let late = found.lateness.unwrap();
    assert!((late.delay_s - 0.04).abs() < 0.004, "{late:?}");
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    for seed in 0..6 {
        let found = judged(&log(&[], &[], 100 + seed));
        assert!(found.named.is_empty() && found.confounded.is_empty(), "{found:?}");
        assert_eq!(found.verdict, Verdict::Complete);
    }
}

#[test]
fn a_cause_that_nobody_logged_is_told_with_its_size() {
    let found = judged(&log(&["offset:servo=5"], &["servo"], 3));
    assert!(found.named.is_empty(), "{:?}", found.named);
    assert_eq!(found.verdict, Verdict::Unexplained);
    let hidden = found.hidden.unwrap();
    assert!(!hidden.is_gain && hidden.size_ut > 0.5 && hidden.tau_s < 10.0, "{hidden:?}");
}

#[test]
fn two_effects_are_named_together() {
    let mut named = judged(&log(&["offset:current_a=4", "gain:temp_c=4"], &[], 8)).named;
    named.sort();
    assert_eq!(named, ["gain:temp_c", "offset:current_a"]);
}

/// A sensor whose first axis gives out x + a·x², folded where the slope is negative, and which turns to all sides.
fn folded(a: f64, seed: u64) -> Vec<(String, Vec<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let names = ["t_s", "mx_ut", "my_ut", "mz_ut"];
    let mut columns: Vec<(String, Vec<f64>)> = names.map(|name| (name.to_owned(), Vec::new())).into();
    for sample in 0..2400 {
        let t = 0.04 * f64::from(sample);
        let (z, turn) = ((0.37 * t).sin(), 1.9 * t);
        let across = (1.0_f64 - z * z).sqrt();
        let x = [40.0 * across * turn.cos() + 3.0, 40.0 * across * turn.sin() - 8.0, 40.0 * z + 5.0];
        let read = [x[0] + a * x[0] * x[0], x[1], x[2]];
        columns[0].1.push(t);
        for axis in 0..3 {
            columns[1 + axis].1.push(read[axis] + 0.2 * noise());
        }
    }
    columns
}

#[test]
fn a_nonlinearity_that_folds_the_readings_is_the_only_name() {
    // The slope is 1 + 2ax: at −37 µT it is −0.26.
    let columns = folded(0.017, 4);
    let table =
        Table::from_columns(columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()))).unwrap();
    let found = judge(&table, &Options { search: true, ..Options::default() }, false);
    assert_eq!(found.named, ["nonlinearity"], "{found:?}");
    assert!(found.rms_ut[1] < 0.25, "{:?}", found.rms_ut);
}

#[test]
fn a_tone_too_fast_for_the_blocks_of_a_long_log_is_named() {
    let mut long = WorldOptions { seed: 21, seconds: 200.0, rate_hz: 100.0, ..WorldOptions::default() };
    long.effects = vec![EffectSpec::parse("periodic=4").unwrap()];
    let found = judged(&World::new(long).run());
    assert_eq!(found.named, ["periodic"], "{found:?}");
}
