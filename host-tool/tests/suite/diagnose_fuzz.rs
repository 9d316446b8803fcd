//! `diagnose` on logs whose columns are broken in every way a recorder has been seen to break them: it answers or refuses,
//! never panics, and what it answers holds no NaN.
//!
//! `IRONOUT_FUZZ_CASES=10000 cargo test -p ironout-cli --test suite -- diagnose_fuzz::` for a long run; `IRONOUT_FUZZ_FROM=4000` begins
//! it there.

use crate::common::{folder, ironout, write};
use ironout_analysis::outcome::json;
use ironout_analysis::{Options, Table, diagnose};
use ironout_cli::input::{ReadOptions, read_stream};
use ironout_simulation::{EffectSpec, FaultSpec, Log, Motion, World, WorldOptions};
use rand::{RngExt, SeedableRng, rngs::ChaCha12Rng};
use serde_json::Value;
use std::io::Write;

/// Share of the remaining variance below which an effect is said to be too small.
const RELEVANCE: f64 = ironout_analysis::bounds::MIN_SHARE;

fn pick<'a, T: ?Sized>(rng: &mut ChaCha12Rng, list: &[&'a T]) -> &'a T {
    list[rng.random_range(0..list.len())]
}

/// A short log, often with something hidden in it, of a board that moved in some way.
fn log(rng: &mut ChaCha12Rng) -> Log {
    let effect = pick(
        rng,
        &["", "", "offset:temp_c=3", "drift=5", "periodic=3", "gain:temp_c=50", "lag=20ms", "eddy=9"],
    );
    let fault = pick(rng, &["", "", "", "burst", "clipping", "stuck", "gap", "repeats"]);
    World::new(WorldOptions {
        seed: rng.random(),
        seconds: rng.random_range(0.5..16.0),
        noise_ut: *pick(rng, &[&0.0, &0.05, &0.25, &5.0]),
        lsb_ut: *pick(rng, &[&0.0, &0.1, &3.0]),
        motion: *pick(rng, &[&Motion::Sphere, &Motion::Sphere, &Motion::Planar, &Motion::Rest]),
        effects: EffectSpec::parse(effect).into_iter().collect(),
        faults: FaultSpec::parse(fault).into_iter().collect(),
        ..WorldOptions::default()
    })
    .run()
}

/// Breaks one column, or adds one.
fn odd(rng: &mut ChaCha12Rng, log: &mut Log) {
    let (rows, count) = (log.rows(), log.columns.len());
    let mut at = rng.random_range(0..count);
    if rng.random_bool(0.4) {
        log.names.push(format!("extra{count}"));
        log.columns.push(log.columns[at].clone());
        at = count;
    }
    let from = rng.random_range(0..rows.max(1));
    let value = *pick(rng, &[&0.0, &-0.0, &1.0, &-1e-5, &32767.0, &1e6, &1e12, &-1e150]);
    let other = log.columns[rng.random_range(0..count)].clone();
    let kind = rng.random_range(0..12);
    let time = log.names[at] == "t_s";
    for (row, cell) in log.columns[at].iter_mut().enumerate() {
        *cell = match kind {
            0 => value,
            1 if row >= from => value,
            2 if row == from => value,
            3 => *cell * value,
            4 => *cell + value,
            5 => other[row],
            // Nothing there: in a column that must have numbers, the log is refused.
            6 if row >= from || row % 3 == 0 => f64::NAN,
            7 => (row % 2) as f64 * value,
            8 => other[row] * other[row] * 1e3,
            9 => (*cell / 10.0).round() * 10.0,
            10 if row >= from => -*cell,
            11 => rng.random_range(-1.0..1.0) * value,
            _ => *cell,
        };
    }
    if time && rng.random_bool(0.9) {
        // Most orders of rows are refused; this one is not.
        log.columns[at].sort_by(f64::total_cmp);
    }
}

/// The text of one case.
fn case(seed: u64) -> Vec<u8> {
    let mut rng = ChaCha12Rng::seed_from_u64(seed);
    let mut log = log(&mut rng);
    for _ in 0..rng.random_range(0..5) {
        odd(&mut rng, &mut log);
    }
    if rng.random_bool(0.3) {
        // Without the sensors beside the magnetometer, or without time.
        let gone = *pick(&mut rng, &[&"a", &"g", &"t", &"h"]);
        let keep: Vec<bool> = log.names.iter().map(|name| !name.starts_with(gone)).collect();
        let mut kept = keep.iter();
        log.names.retain(|_| kept.next() == Some(&true));
        let mut kept = keep.iter();
        log.columns.retain(|_| kept.next() == Some(&true));
    }
    let mut text = Vec::new();
    log.write_csv(&mut text, "odd").expect("memory can be written");
    text
}

/// What must be numbers in the answer: JSON writes a NaN as null.
fn sound(object: &Value) {
    let number = |value: &Value, what: &str| assert!(value.is_f64() || value.is_u64(), "{what} is {value}");
    for step in object["steps"].as_array().expect("a list") {
        number(&step["rms_ut"], "rms_ut");
    }
    for effect in object["effects"].as_array().expect("a list") {
        effect["coefficients"]
            .as_array()
            .expect("a list")
            .iter()
            .for_each(|value| number(value, "a coefficient"));
        // The share of a delay along the identity is invisible without an accelerometer: its error is not known.
        for value in effect["std_errors"].as_array().expect("a list") {
            if effect["id"] != "lag" || !value.is_null() {
                number(value, "an error");
            }
        }
        let named = effect["reference"].as_object().into_iter().chain(effect["parameters"].as_object());
        named.flatten().for_each(|(name, value)| number(value, name));
    }
    for row in object["candidates"].as_array().expect("a list") {
        assert!(
            ["missing", "not-needed", "confounded", "untestable"]
                .contains(&row["status"].as_str().expect("text"))
        );
        if let Some(p) = row["p_value"].as_f64() {
            assert!((0.0..=1.0).contains(&p), "p {p}");
        }
    }
    for one in object["where"].as_array().expect("a list") {
        number(&one["explained"], "explained");
        number(&one["p_value"], "p_value");
    }
    if let Some(calibration) = object["calibration"].as_object() {
        calibration["offset_ut"].as_array().expect("three").iter().for_each(|value| number(value, "offset"));
        for row in calibration["matrix"].as_array().expect("three") {
            row.as_array().expect("three").iter().for_each(|value| number(value, "matrix"));
        }
        number(&calibration["field_ut"], "field_ut");
    }
    for pair in ["dip", "heading"] {
        for (name, value) in object[pair].as_object().into_iter().flatten() {
            number(value, name);
        }
    }
}

/// What is said follows from the figures that stand beside it.
fn truthful(object: &Value) {
    let list = |of: &'static str| object[of].as_array().expect("a list").iter();
    for row in list("candidates") {
        let (why, id) = (row["why"].as_str().expect("text"), &row["id"]);
        let takes = row["takes"].as_f64();
        if why.contains("too small") {
            assert!(takes.is_some_and(|takes| takes < RELEVANCE), "{id}: {why}, but {takes:?}");
        }
        if let Some(takes) = takes.filter(|_| why.contains("it explains") && !why.contains("too small")) {
            assert!(
                takes >= RELEVANCE && why.contains(&format!("{:.0} %", 100.0 * takes)),
                "{id}: {why}, {takes}"
            );
        }
        let angle = object["dip"]["misalignment_deg"].as_f64().unwrap_or(0.0);
        let in_order = id == "axis-order" && why.contains("axis order is correct");
        assert!(!in_order || angle <= 45.0, "{why} beside a misalignment of {angle}");
    }
    // Several of a kind count as one: a step there alone predicts nothing of a time after the step back.
    let kind = |step: &Value| step["added"].as_str().and_then(|id| id.split('#').next()).map(str::to_owned);
    let steps: Vec<&Value> = list("steps").collect();
    let whole = (0..steps.len())
        .filter(|place| steps.get(place + 1).is_none_or(|next| kind(next) != kind(steps[*place])));
    let errors: Vec<f64> = whole.filter_map(|place| steps[place]["holdout_rms_ut"].as_f64()).collect();
    // Effects that hold only together predict worse one by one; all of them predict best.
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(errors.last().is_none_or(|last| *last <= 1.05 * least + 1e-9), "not the least error: {errors:?}");
    let steps = list("steps").count();
    match object["verdict"].as_str().expect("text") {
        "complete" => assert_eq!(steps, 1),
        "missing" => assert!(steps > 1),
        _ => {}
    }
}

fn set(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

/// The seeds of the logs.
fn cases(default: u64) -> std::ops::Range<u64> {
    let from = set("IRONOUT_FUZZ_FROM").unwrap_or(0);
    from..from + set("IRONOUT_FUZZ_CASES").unwrap_or(default)
}

/// Cases that failed once: readings of 1e280 µT at the end of a log gave an error that was no number.
const ONCE_WRONG: [u64; 1] = [87013];

#[test]
fn odd_columns_are_diagnosed_or_refused() {
    let (mut answered, seeds) = (0, cases(100));
    let count = seeds.end - seeds.start + ONCE_WRONG.len() as u64;
    let mut times: Vec<(f64, u64)> = Vec::new();
    for seed in seeds.chain(ONCE_WRONG) {
        let text = case(seed);
        let clock = std::time::Instant::now();
        let result = std::panic::catch_unwind(|| {
            let Ok(log) = read_stream(&text[..], text.len() as u64, &ReadOptions::default()) else {
                return false;
            };
            let options = Options { search: true, ..Options::default() };
            match diagnose(&Table::from(&log), &options) {
                Ok(diagnosis) => {
                    let object = json::object(&diagnosis);
                    sound(&object);
                    truthful(&object);
                }
                Err(refusal) => assert!(!format!("{refusal:?}").is_empty()),
            }
            true
        });
        times.push((clock.elapsed().as_secs_f64(), seed));
        match result {
            Ok(diagnosed) => answered += u64::from(diagnosed),
            Err(_) => {
                let path = write(&folder("diagnose_fuzz"), "broken.csv", &text);
                panic!("case {seed}: {}", path.display());
            }
        }
    }
    times.sort_by(|a, b| b.0.total_cmp(&a.0));
    // No test of times, which are the machine's: they are told.
    let slowest: Vec<String> = times.iter().take(10).map(|(s, seed)| format!("{seed} {s:.2} s")).collect();
    let _ = writeln!(std::io::stderr(), "the slowest of {count} logs: {}", slowest.join(", "));
    // Most are read: else nothing was tried.
    assert!(2 * answered > count, "only {answered} of {count} logs were diagnosed");
}

#[test]
fn odd_columns_are_told_in_words() {
    let here = folder("diagnose_fuzz_words");
    for seed in cases(12) {
        let log = write(&here, "log.csv", case(seed));
        let run = ironout(["diagnose", log.to_str().expect("text")]);
        assert!((0..=2).contains(&run.status), "case {seed}: status {}, {}", run.status, run.stderr);
        assert!(!run.said().contains("panicked"), "case {seed}: {}", run.stderr);
        assert!(!run.stdout.contains("NaN"), "case {seed}: {}", run.stdout);
    }
}
