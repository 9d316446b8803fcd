//! `fit` and `diagnose` say the same of one log, to the digits that are printed: which samples count, the base model with
//! its errors and floors, and the model with the effects that `diagnose` finds and `fit --add` adds.

use crate::common::{folder, ironout, recording};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn simulated(name: &str, arguments: &[&str]) -> PathBuf {
    let log = folder(&format!("truth_{name}")).join("log.csv");
    let path = log.to_str().expect("a path of text");
    let run = ironout(["simulate", "-o", path, "--seconds", "70", "--rate", "50"].iter().chain(arguments));
    assert_eq!(run.status, 0, "{}", run.stderr);
    log
}

fn run(command: &str, log: &Path, options: &[&str]) -> Value {
    let path = log.to_str().expect("a path of text");
    // A diagnosis is of all attitudes.
    let all = if command == "fit" { &["--for", "all"][..] } else { &[] };
    let run = ironout([command, path, "--json"].iter().chain(options).chain(all));
    assert!(run.status <= 1, "{command} {path}: {}", run.stderr);
    run.json()
}

/// Every number of `one` against that of `other`: equal to five significant digits, or to what rounding leaves of `scale`.
fn assert_same(what: &str, one: &Value, other: &Value, scale: f64) {
    match (one, other) {
        (Value::Array(ones), Value::Array(others)) => {
            assert_eq!(ones.len(), others.len(), "{what}");
            ones.iter().zip(others).for_each(|(one, other)| assert_same(what, one, other, scale));
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            let most = (1e-5 * a.abs().max(b.abs())).max(1e-6 * scale);
            assert!((a - b).abs() <= most, "{what}: {a} against {b}");
        }
        (one, other) => assert_eq!(one, other, "{what}"),
    }
}

/// Offset, matrix and their errors.
fn assert_same_calibration(what: &str, one: &Value, other: &Value) {
    assert_same(&format!("{what}: offset_ut"), &one["offset_ut"], &other["offset_ut"], 50.0);
    assert_same(&format!("{what}: matrix"), &one["matrix"], &other["matrix"], 1.0);
    for (key, scale) in [("offset_ut", 1.0), ("matrix", 0.01)] {
        let (one, other) = (&one["std_errors"][key], &other["std_errors"][key]);
        assert_same(&format!("{what}: std_errors.{key}"), one, other, scale);
    }
}

/// Ids that `fit --add` takes.
fn found(diagnosis: &Value) -> Vec<String> {
    let steps = diagnosis["steps"].as_array().expect("steps");
    let ids = steps.iter().filter_map(|step| step["added"].as_str());
    ids.filter(|id| *id != "axis-order").map(String::from).collect()
}

/// Holds the two against each other; gives what `diagnose` found.
fn assert_one_truth(log: &Path, options: &[&str]) -> Vec<String> {
    let what = log.display().to_string();
    let (fit, diagnosis) = (run("fit", log, options), run("diagnose", log, options));
    let first = &diagnosis["steps"][0];
    let rests = diagnosis["residual"] == "vector";
    if !rests {
        for key in ["samples_used", "samples_set_aside"] {
            assert_eq!(fit[key], diagnosis[key], "{what}: {key}");
        }
    }
    // A resting board has no calibration, and a sensor that is taken as calibrated keeps its own scale.
    let base = &diagnosis["base"];
    assert_eq!(base.is_null(), rests || fit["offset_ut"].is_null(), "{what}: {base}");
    if !base.is_null() {
        assert_same_calibration(&what, &fit, base);
        for key in ["rms_ut", "holdout_rms_ut", "noise_floor_ut", "residual_floor_ut", "field_ut"] {
            assert_same(&format!("{what}: {key}"), &fit[key], &base[key], 0.0);
        }
        assert_eq!(base["method"], fit["method"]);
        if diagnosis["lower_order"] == false {
            for key in ["rms_ut", "holdout_rms_ut"] {
                assert_same(&format!("{what}: first row, {key}"), &fit[key], &first[key], 0.0);
            }
        }
    }
    let ids = found(&diagnosis);
    let plain = ids.is_empty() && diagnosis["effects"].as_array().is_some_and(Vec::is_empty);
    // Axes that are not in order are told with the base that they give, and with no calibration.
    if plain && !base.is_null() && !diagnosis["calibration"].is_null() {
        assert_same_calibration(&what, &fit, &diagnosis["calibration"]);
        for key in ["noise_floor_ut", "residual_floor_ut"] {
            assert_same(&format!("{what}: {key}"), &fit[key], &diagnosis[key], 0.0);
        }
    }
    // A study of what a sensor that was calibrated before leaves is none that `fit` makes.
    if ids.is_empty() || ids.len() > 4 || rests || diagnosis["calibration"].is_null() {
        return ids;
    }
    // Effects are fitted together with the base, which --method is not about.
    let mut adding = options.to_vec();
    if let Some(at) = adding.iter().position(|option| *option == "--method") {
        adding.drain(at..at + 2);
    }
    ids.iter().for_each(|id| adding.extend(["--add", id.as_str()]));
    let with = run("fit", log, &adding);
    assert_same_calibration(&format!("{what} {ids:?}"), &with, &diagnosis["calibration"]);
    for key in ["samples_used", "samples_set_aside", "noise_floor_ut", "residual_floor_ut"] {
        assert_same(&format!("{what} {ids:?}: {key}"), &with[key], &diagnosis[key], 0.0);
    }
    let last = diagnosis["steps"].as_array().and_then(|steps| steps.last()).expect("a last row");
    for key in ["rms_ut", "holdout_rms_ut"] {
        assert_same(&format!("{what} {ids:?}: {key}"), &with[key], &last[key], 0.0);
    }
    for effect in with["effects"].as_array().expect("effects") {
        let all = diagnosis["effects"].as_array().expect("effects");
        let other = all.iter().find(|other| other["id"] == effect["id"]).expect("the same effects");
        for key in ["coefficients", "std_errors"] {
            let sizes =
                effect["coefficients"].as_array().expect("coefficients").iter().filter_map(Value::as_f64);
            let scale = 10.0 * sizes.fold(0.0, |most: f64, size| most.max(size.abs()));
            assert_same(&format!("{what} {}: {key}", effect["id"]), &effect[key], &other[key], scale);
        }
        for key in ["reference", "parameters"] {
            assert_eq!(effect[key], other[key], "{what} {}", effect["id"]);
        }
    }
    ids
}

#[test]
fn of_clean_logs_and_of_faulty_ones() {
    for (name, arguments) in [
        ("clean", &["--seed", "31"][..]),
        ("noisy", &["--seed", "32", "--noise", "1.5"]),
        ("burst", &["--seed", "33", "--effect", "burst"]),
        ("clipping", &["--seed", "34", "--effect", "clipping"]),
        ("stuck", &["--seed", "35", "--effect", "stuck"]),
        ("gap", &["--seed", "36", "--effect", "gap"]),
        ("repeats", &["--seed", "37", "--effect", "repeats"]),
        ("hand", &["--seed", "38", "--motion", "hand"]),
        ("cap", &["--seed", "39", "--motion", "cap=0.3"]),
        ("small_cap", &["--seed", "40", "--motion", "cap=0.12"]),
        ("planar", &["--seed", "41", "--motion", "planar"]),
        ("rest", &["--seed", "42", "--motion", "rest"]),
    ] {
        assert_one_truth(&simulated(name, arguments), &[]);
    }
}

#[test]
fn of_correlated_noise() {
    use ironout_simulation::{World, WorldOptions};
    for (index, (noise_ut, noise_correlation)) in [(0.25, 0.6), (0.5, 0.9)].into_iter().enumerate() {
        let options =
            WorldOptions { seed: 43 + index as u64, noise_ut, noise_correlation, ..Default::default() };
        let log = World::new(options).run();
        let path = folder(&format!("truth_correlated{index}")).join("log.csv");
        let mut file = std::fs::File::create(&path).expect("a file");
        log.write_csv(&mut file, "").expect("written");
        assert_one_truth(&path, &[]);
    }
}

#[test]
fn of_hidden_effects() {
    for (name, seed, hidden) in [
        ("temperature", "51", &["offset:temp_c=3"][..]),
        ("late", "52", &["offset:current_a@delay=3"]),
        ("step", "53", &["step=3"]),
        ("tone", "54", &["periodic=3"]),
        ("lag", "55", &["lag=20ms"]),
        ("eddy", "56", &["eddy=3"]),
        ("two", "57", &["offset:temp_c=3", "offset:current_a=3"]),
    ] {
        let mut arguments = vec!["--seed", seed];
        hidden.iter().for_each(|id| arguments.extend(["--effect", id]));
        let found = assert_one_truth(&simulated(name, &arguments), &[]);
        assert_eq!(found.len(), hidden.len(), "{name}: {found:?}");
    }
}

#[test]
fn by_every_method_and_scaled() {
    let log = simulated("methods", &["--seed", "61", "--effect", "drift=3"]);
    for method in ["adjusted", "trace", "constant"] {
        assert_one_truth(&log, &["--method", method, "--field", "48.5"]);
    }
    // The base is the method's own: plain least squares is biased by the noise, and says so.
    let noisy = simulated("method_bias", &["--seed", "62", "--noise", "1.5"]);
    let offset = |method| run("diagnose", &noisy, &["--method", method])["base"]["matrix"][0][0].as_f64();
    let (adjusted, trace) = (offset("adjusted").expect("a base"), offset("trace").expect("a base"));
    assert!((adjusted - trace).abs() > 1e-5, "{adjusted} {trace}");
}

#[test]
fn of_recordings() {
    for (name, options) in [
        ("cubesat-magnetorquer-mag1.csv", &[][..]),
        ("cubesat-magnetorquer-mag2.csv", &[]),
        ("hand-rotated-counts.csv", &["--ut-per-count", "0.1"]),
        ("hmc5883l-mpu6050-full-sphere.csv", &[]),
        ("hmc5883l-mpu6050-roll-and-tilt-at-45-90.csv", &[]),
        ("hmc5883l-mpu6050-tilt-sphere.csv", &[]),
        ("imu-gnss-board.csv", &["--ut-per-count", "0.1"]),
        ("lsm9ds1-hand-outliers.csv", &[]),
        ("px4-quad-flight.csv", &[]),
        ("qmc5883l-filtered.csv", &["--ut-per-count", "0.0333"]),
        ("qmc5883l-noisy.csv", &["--ut-per-count", "0.0333"]),
    ] {
        if let Some(log) = recording(name) {
            assert_one_truth(&log, options);
        }
    }
}
