//! `diagnose` on the real recordings: an answer with a reason, in lines that fit a terminal.

use crate::common::{ironout, recording};

/// Diagnoses a recording both ways: the JSON object and the words.
fn diagnosed(name: &str, options: &[&str]) -> Option<(serde_json::Value, String)> {
    let path = recording(name)?;
    let path = path.to_str().expect("a path of text");
    let words = ironout(["diagnose", path, "-v"].iter().chain(options));
    let json = ironout(["diagnose", path, "--json"].iter().chain(options));
    assert_eq!(words.status, json.status, "{name}: {}", words.stderr);
    let object = json.json();
    let undetermined = object["verdict"] == "undetermined";
    assert_eq!(json.status, i32::from(undetermined), "{name}");
    let verdict = object["verdict"].as_str().expect("a verdict").to_uppercase().replace("MISSING", "FOUND");
    assert!(words.stdout.lines().any(|line| line.starts_with(&format!("{verdict}:"))), "{}", words.stdout);
    assert!(words.stdout.contains("Next steps"), "{}", words.stdout);
    for line in words.stdout.lines() {
        let command = line.trim_start().starts_with("ironout ") || line.contains(path);
        assert!(command || line.chars().count() <= 100, "{name}: too wide: {line}");
    }
    Some((object, words.stdout))
}

/// The steps' ids.
fn added(object: &serde_json::Value) -> Vec<&str> {
    object["steps"].as_array().into_iter().flatten().filter_map(|step| step["added"].as_str()).collect()
}

/// Error of the first and of the last step, µT.
fn falling(object: &serde_json::Value) -> (f64, f64) {
    let steps = object["steps"].as_array().expect("steps");
    let error =
        |step: Option<&serde_json::Value>| step.and_then(|step| step["rms_ut"].as_f64()).expect("an error");
    (error(steps.first()), error(steps.last()))
}

#[test]
fn the_coils_of_a_resting_cubesat_are_found() {
    let Some((object, words)) = diagnosed("cubesat-magnetorquer-mag1.csv", &[]) else { return };
    assert_ne!(object["verdict"], "complete");
    assert_ne!(object["verdict"], "undetermined");
    let ids = added(&object);
    for coil in ["offset:coil_x_am2", "offset:coil_y_am2", "offset:coil_z_am2"] {
        assert!(ids.iter().any(|id| id.starts_with(coil)), "{coil}: {ids:?}");
    }
    assert!(ids.iter().any(|id| id.ends_with("@delay")), "the command before acts too: {ids:?}");
    let (before, after) = falling(&object);
    assert!(after < 0.25 * before, "{before} -> {after}");
    assert!(words.contains("sensor at rest"), "{words}");
    assert!(object["where"].as_array().is_some_and(|list| !list.is_empty()));
}

#[test]
fn a_quadrotor_in_flight_gets_an_honest_answer() {
    let Some((object, words)) = diagnosed("px4-quad-flight.csv", &[]) else { return };
    // Level within 8°: nothing is named on a base that the log does not carry, and the way out is said.
    assert_eq!(object["verdict"], "undetermined", "{}", object["reasons"]);
    assert!(added(&object).is_empty(), "{:?}", added(&object));
    let reasons = object["reasons"].to_string();
    assert!(reasons.contains("The sensor was tilted"), "{reasons}");
    assert!(words.contains("--prior"), "{words}");
    // What the log gives all the same carries its error with it: tens of µT, more than the field itself.
    let errors = object["calibration"]["std_errors"]["offset_ut"].as_array().expect("three errors");
    let field = object["calibration"]["field_ut"].as_f64().expect("a field");
    assert!(errors.iter().any(|error| error.as_f64().is_some_and(|error| error > field)), "{object}");
}

#[test]
fn the_throttle_asked_for_is_no_calibration() {
    let Some(path) = recording("px4-quad-flight.csv") else { return };
    let path = path.to_str().expect("a path of text");
    let run = ironout(["fit", path, "--add", "offset:throttle_us", "--json"]);
    assert_eq!(run.status, 1, "{}", run.stderr);
    let object = run.json();
    assert_eq!(object["accepted"], false);
    let codes = object["reason_codes"].to_string();
    assert!(codes.contains("tilted-too-little"), "{codes} {}", object["reasons"]);
}

#[test]
fn the_cleanest_recording_is_diagnosed() {
    let Some((object, words)) = diagnosed("hmc5883l-mpu6050-full-sphere.csv", &[]) else { return };
    assert_ne!(object["verdict"], "undetermined");
    let (before, after) = falling(&object);
    assert!(before < 0.3 && after <= before, "{before} -> {after}");
    assert!(object["dip"]["rms_deg_after"].as_f64().expect("an accelerometer") < 4.0);
    assert!(words.contains("dip spread"), "{words}");
}

#[test]
fn every_other_recording_has_an_answer_too() {
    for (name, options) in [
        ("cubesat-magnetorquer-mag2.csv", &[][..]),
        ("hmc5883l-mpu6050-tilt-sphere.csv", &[]),
        ("hmc5883l-mpu6050-roll-and-tilt-at-45-90.csv", &[]),
        ("imu-gnss-board.csv", &["--ut-per-count", "0.1"]),
        ("lsm9ds1-hand-outliers.csv", &[]),
    ] {
        let Some((object, _)) = diagnosed(name, options) else { continue };
        assert_ne!(object["verdict"], "complete", "{name}: no real recording of these is clean");
    }
}
