//! Causes outside of what single columns do at once: late and slow columns, soft iron that follows one, recordings with an offset each, an
//! offset that switches, a true field that was logged.

use crate::common::{case, folder, ironout, simulate, text, write};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

fn diagnosed(logs: &[&Path]) -> Value {
    let logs = logs.iter().map(|log| text(log));
    ironout(["diagnose"].into_iter().chain(logs).chain(["--json"])).json()
}

fn triple(value: &Value) -> [f64; 3] {
    std::array::from_fn(|axis| value[axis].as_f64().expect("a number"))
}

fn named(diagnosis: &Value) -> Vec<String> {
    let steps = diagnosis["steps"].as_array().expect("steps");
    steps.iter().filter_map(|step| step["added"].as_str().map(str::to_string)).collect()
}

#[test]
fn an_unlogged_offset_that_switches_is_given_with_its_vector_and_its_times() {
    let Some(log) = case("12_onoff_unlogged.csv") else { return };
    let diagnosis = diagnosed(&[&log]);
    let found = &diagnosis["switching"];
    for (value, truth) in triple(&found["offset_ut"]).into_iter().zip([2.5, -1.0, 1.8]) {
        // On and off are each other's negative: which of the two it is, the smaller part of the log says.
        let sign = triple(&found["offset_ut"])[0].signum();
        assert!((sign * value - truth).abs() < 0.15, "{found}");
    }
    assert!(found["rms_ut"].as_f64() < Some(0.35), "{found}");
    assert!(found["on_s"].as_array().is_some_and(|spans| spans.len() >= 3), "{found}");
    let said = ironout(["diagnose", text(&log), "-v"]).stdout;
    assert!(said.contains("switches between two values"), "{said}");
}

#[test]
fn three_days_have_one_matrix_and_an_offset_each() {
    let (Some(a), Some(b), Some(c)) = (case("24_day0.csv"), case("24_day1.csv"), case("24_day2.csv")) else {
        return;
    };
    let diagnosis = diagnosed(&[&a, &b, &c]);
    let found = &diagnosis["recordings"];
    for (value, truth) in triple(&found["per_recording_ut"]).into_iter().zip([1.6, -1.0, 1.2]) {
        assert!((value - truth).abs() < 0.2, "{found}");
    }
    assert_eq!(found["recordings"].as_array().map(Vec::len), Some(3), "{found}");
    assert_eq!(diagnosis["verdict"], "complete", "{diagnosis}");
    // The calibration is of the last day: its own log agrees with it, the first one's does not.
    let here = folder("unlogged_days");
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&a), text(&b), text(&c), "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let off = |log: &Path| {
        let object = ironout(["check", text(log), "--cal", text(&cal), "--json"]).json();
        object["rms_ut"].as_f64().expect("an error")
    };
    assert!(off(&c) < 0.5 && off(&a) > 1.0, "{} {}", off(&c), off(&a));
}

#[test]
fn a_current_that_is_logged_late_leads_its_column() {
    let Some(log) = case("10_current_logged_late.csv") else { return };
    let diagnosis = diagnosed(&[&log]);
    assert_eq!(named(&diagnosis).first().map(String::as_str), Some("offset:current_a@delay"), "{diagnosis}");
    let delay_s = &diagnosis["effects"][0]["parameters"]["delay_s"];
    assert!((delay_s.as_f64().expect("a delay") + 0.3).abs() < 0.02, "{delay_s}");
}

#[test]
fn a_slow_column_and_soft_iron_of_a_column_are_named_fitted_and_applied() {
    let here = folder("unlogged_slow");
    for (effect, seed, key) in
        [("offset:current_a~tau", "3", Some("time_constant_s")), ("soft-iron:height_m", "5", None)]
    {
        let strength = format!("{effect}=6");
        let log = simulate(&here, "log.csv", &["--seconds", "120", "--seed", seed, "--effect", &strength]);
        let diagnosis = diagnosed(&[&log]);
        let cal = here.join("cal.json");
        let run = ironout(["fit", text(&log), "--add", effect, "-o", text(&cal)]);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        if let Some(key) = key {
            let file: Value =
                serde_json::from_str(&std::fs::read_to_string(&cal).expect("a file")).expect("JSON");
            assert!(file["effects"][0]["parameters"][key].as_f64() > Some(0.5), "{file}");
        }
        let object = ironout(["check", text(&log), "--cal", text(&cal), "--json"]).json();
        let (rms, plain) =
            (object["rms_ut"].as_f64().unwrap(), diagnosis["steps"][0]["rms_ut"].as_f64().unwrap());
        assert!(rms < 0.6 * plain, "{effect}: {rms} of {plain}");
    }
}

/// A board that turns in a field that grows and shrinks by a tenth, and a reference sensor beside it.
fn surveyed() -> String {
    let mut log = String::from("t_s,mx_ut,my_ut,mz_ut,base_nt\n");
    for i in 0..3000 {
        let t = f64::from(i) * 0.05;
        let field = 50.0 + 5.0 * (t * 0.07).sin();
        let (z, turn) = ((t * 0.31).sin(), t * 1.1 + 0.4 * (t * 0.17).cos());
        let level = (1.0 - z * z).sqrt();
        let [x, y, z] = [level * turn.cos(), level * turn.sin(), z].map(|axis| axis * field);
        // Noise of some 0.05 µT, the same each time.
        let noise = |k: f64| 0.07 * ((f64::from(i) + 1.0) * k).sin();
        let read =
            [1.02 * x + 12.0 + noise(911.7), 0.97 * y - 25.0 + noise(517.3), 1.04 * z + 31.0 + noise(733.9)];
        let _ = writeln!(log, "{t:.2},{:.4},{:.4},{:.4},{:.2}", read[0], read[1], read[2], 1000.0 * field);
    }
    log
}

#[test]
fn a_logged_true_field_gives_offset_and_absolute_gains() {
    let here = folder("unlogged_reference");
    let log = write(&here, "survey.csv", surveyed());
    let fitted = ironout(["fit", text(&log), "--reference", "base_nt", "--json"]).json();
    assert_eq!(fitted["accepted"], true, "{fitted}");
    for (value, truth) in triple(&fitted["offset_ut"]).into_iter().zip([12.0, -25.0, 31.0]) {
        assert!((value - truth).abs() < 0.05, "{fitted}");
    }
    for (axis, gain) in [1.02, 0.97, 1.04].into_iter().enumerate() {
        let entry = fitted["matrix"][axis][axis].as_f64().expect("a number");
        assert!((entry * gain - 1.0).abs() < 2e-3, "{axis}: {entry}");
    }
    let without = ironout(["fit", text(&log), "--json"]).json();
    assert!(without["rms_ut"].as_f64() > Some(1.0), "one field for all is none: {without}");
    let wrong = ironout(["fit", text(&log), "--reference", "t_s,base_nt"]);
    assert!(
        wrong.status != 0 && wrong.stderr.contains("one column") && wrong.stderr.contains("three"),
        "{}",
        wrong.stderr
    );
}
