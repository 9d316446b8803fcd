//! Known answers of the engine as a whole, on simulated logs.

use crate::base::ground::Ground;
use crate::base::prior::Prior;
use crate::base::start::start;
use crate::evidence::select::{Begin, Selection, moving, select};
use crate::evidence::significance::Test;
use crate::evidence::wander::Moving;
use crate::table::Table;
use ironout::effect::Registry;
use ironout::fit::Method;
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

fn of_table(table: &Table) -> Selection {
    let ground = Ground::of(table, Method::Adjusted, None, None);
    let samples = &ground.counted.samples;
    let (model, _) = start(samples, None).unwrap();
    let begin = Begin { model: &model, known: &Prior::default(), stay: &[], is_at_rest: false };
    select(samples, table, Registry::BUILT_IN, &begin).unwrap()
}

fn named(log: &Log) -> Vec<String> {
    ids(&of_table(&Table::from_columns(log.named()).unwrap()))
}

fn ids(selection: &Selection) -> Vec<String> {
    selection.found.iter().map(|one| one.id.clone()).collect()
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
        assert_eq!(named(&log(&[&format!("{effect}=4")], &[], 11)), [effect]);
    }
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    for seed in 0..6 {
        assert!(named(&log(&[], &[], 100 + seed)).is_empty(), "{seed}");
    }
}

#[test]
fn a_cause_that_nobody_logged_accuses_nobody() {
    assert!(named(&log(&["offset:servo=5"], &["servo"], 3)).is_empty());
}

#[test]
fn a_cause_that_nobody_logged_is_described() {
    let mut followed = 0;
    for seed in 3..9 {
        let (known, unknown) =
            (log(&["offset:servo=5"], &[], seed), log(&["offset:servo=5"], &["servo"], seed));
        let table = Table::from_columns(unknown.named()).unwrap();
        let ground = Ground::of(&table, Method::Adjusted, None, None);
        let samples = &ground.counted.samples;
        let (model, _) = start(samples, None).unwrap();
        let begin = Begin { model: &model, known: &Prior::default(), stay: &[], is_at_rest: false };
        let found = moving(samples, &table, Registry::BUILT_IN, &begin).offset.unwrap();
        let v = &known.truth.effects[0].drawn.coefficients;
        let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = found.direction.expect("one direction");
        let cosine = (0..3).map(|i| direction[i] * v[i]).sum::<f64>() / size;
        assert!(cosine.abs() > 0.94, "{seed}: {cosine}");
        // Its trace follows the column.
        let (time, servo) = (known.column("t_s").unwrap(), known.column("servo").unwrap());
        let at = |t: f64| servo[time.partition_point(|one| *one < t).min(servo.len() - 1)];
        let true_ut: Vec<f64> = found.t_s.iter().map(|t| at(*t) * size).collect();
        let along: Vec<f64> =
            found.offset_ut.iter().map(|o| (0..3).map(|i| o[i] * v[i]).sum::<f64>() / size).collect();
        let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
        let (a, b) = (mean(&true_ut), mean(&along));
        let product = |f: &dyn Fn(f64, f64) -> f64| {
            true_ut.iter().zip(&along).map(|(x, y)| f(x - a, y - b)).sum::<f64>()
        };
        let correlation = product(&|x, y| x * y) / (product(&|x, _| x * x) * product(&|_, y| y * y)).sqrt();
        // Where the field lies across a cause its history is a guess.
        assert!(correlation > 0.5, "{seed}: {correlation}");
        followed += usize::from(correlation > 0.8);
        let true_rms = (product(&|x, _| x * x) / true_ut.len() as f64).sqrt();
        // Offset and matrix take a part of a slow cause for themselves.
        let share = found.rms_ut / true_rms;
        assert!((0.5..1.3).contains(&share), "{seed}: {} of {true_rms}", found.rms_ut);
    }
    assert!(followed >= 5, "{followed} of 6 traces follow the column");
}

/// What moves beside the plain model.
fn moving_in(log: &Log) -> Moving {
    let table = Table::from_columns(log.named()).unwrap();
    let ground = Ground::of(&table, Method::Adjusted, None, None);
    let samples = &ground.counted.samples;
    let (model, _) = start(samples, None).unwrap();
    let begin = Begin { model: &model, known: &Prior::default(), stay: &[], is_at_rest: false };
    moving(samples, &table, Registry::BUILT_IN, &begin)
}

#[test]
fn a_field_that_is_stronger_in_one_place_is_told_from_an_offset_and_a_gain_that_move() {
    let mut detected = 0;
    for seed in 3..9 {
        detected += usize::from(
            moving_in(&log(&["field:height_m=5"], &["height_m"], seed))
                .field_share
                .is_some_and(|share| share > 0.5),
        );
        for (hidden, column) in
            [("offset:servo=5", "servo"), ("gain:temp_c=5", "temp_c"), ("nonlinearity=5", "")]
        {
            let log = log(&[hidden], &[column], seed);
            // One gain of all axes is as if the field changed.
            let theta = &log.truth.effects[0].drawn.coefficients;
            let (sum, squares) = (theta.iter().sum::<f64>(), theta.iter().map(|c| c * c).sum::<f64>());
            let is_alike = column == "temp_c" && sum * sum > 0.9 * theta.len() as f64 * squares;
            assert!(moving_in(&log).field_share.is_none() || is_alike, "{hidden}, seed {seed}");
        }
    }
    assert!(detected >= 5, "{detected} of 6");
}

#[test]
fn p_values_of_noise_are_spread_evenly() {
    let (mut below, mut all, mut logs) = (0, 0, 0);
    for seed in 1000..1030 {
        let quiet = of_table(&Table::from_columns(log(&[], &[], seed).named()).unwrap());
        all += quiet.first.len();
        below += quiet.first.iter().filter(|one| one.p_value < 0.1).count();
        // Corrected for all candidates.
        let is_significant = |one: &Test| one.p_value * (quiet.candidates as f64) < 0.05;
        logs += usize::from(quiet.first.iter().any(is_significant));
    }
    let share = f64::from(below as u32) / f64::from(all as u32);
    assert!(all > 400 && (0.05..0.17).contains(&share), "{below} of {all}");
    assert!(logs <= 4, "{logs} of 30");
}

#[test]
fn a_test_says_what_a_term_explains_and_predicts() {
    for seed in 0..4 {
        let loud =
            of_table(&Table::from_columns(log(&["offset:temp_c=6"], &[], 100 + seed).named()).unwrap());
        let of = |list: &[Test], id: &str| list.iter().find(|one| one.id == id).cloned().unwrap();
        let (own, other) = (of(&loud.first, "offset:temp_c"), of(&loud.first, "offset:height_m"));
        assert!(own.share > 0.8 && own.p_value < 1e-6 && own.falls, "{own:?}");
        assert!(other.share < 0.5 * own.share && other.p_value > 1e-3, "{other:?}");
        // Beside it nothing else predicts any better.
        let rest = of(&loud.last, "offset:height_m");
        assert!(rest.share < 0.01 && !rest.falls, "{rest:?}");
        assert!(rest.held_out_rms_ut.unwrap() < 0.3 && own.held_out_rms_ut.unwrap() < 0.3, "{own:?}");
    }
}

#[test]
fn two_effects_are_named_together() {
    let mut both = named(&log(&["offset:current_a=4", "gain:temp_c=4"], &[], 8));
    both.sort();
    assert_eq!(both, ["gain:temp_c", "offset:current_a"]);
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
    assert_eq!(ids(&of_table(&table)), ["nonlinearity"]);
}

#[test]
fn a_tone_too_fast_for_the_blocks_of_a_long_log_is_named() {
    let mut long = WorldOptions { seed: 21, seconds: 200.0, rate_hz: 100.0, ..WorldOptions::default() };
    long.effects = vec![EffectSpec::parse("periodic=4").unwrap()];
    assert_eq!(named(&World::new(long).run()), ["periodic"]);
}
