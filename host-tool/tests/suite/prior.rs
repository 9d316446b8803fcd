//! A log on top of an earlier calibration: what was off when the board was calibrated and ran all through the log is found.

use crate::common::{calibrate, folder, ironout, simulate, text, write};
use std::path::{Path, PathBuf};

/// µT for each ampere.
const FIELD_UT_A: [f64; 3] = [0.3, -0.2, 0.25];

/// The log with another current, whose field it reads.
fn with_current(here: &Path, log: &Path, name: &str, current_a: impl Fn(f64) -> f64) -> PathBuf {
    let content = std::fs::read_to_string(log).expect("text");
    let mut lines = content.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header");
    let place = |name: &str| header.split(',').position(|word| word == name).expect(name);
    let (field, current) = (["mx_ut", "my_ut", "mz_ut"].map(place), place("current_a"));
    let rows = lines.enumerate().map(|(row, line)| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        let now = current_a(row as f64);
        for (place, per_ampere) in field.into_iter().zip(FIELD_UT_A) {
            let own: f64 = cells[place].parse().expect("a number");
            cells[place] = format!("{:.5}", own + per_ampere * now);
        }
        cells[current] = format!("{now:.3}");
        cells.join(",") + "\n"
    });
    write(here, name, format!("{header}\n{}", rows.collect::<String>()))
}

#[test]
fn what_was_off_at_the_calibration_and_ran_all_through_the_log_is_found() {
    let here = folder("prior");
    let turned = simulate(&here, "turned.csv", &["--seed", "5", "--seconds", "80"]);
    let bench = with_current(&here, &turned, "bench.csv", |_| 0.0);
    let cal = calibrate(&here, &bench, &[]);
    let stored: serde_json::Value = serde_json::from_slice(&std::fs::read(&cal).expect("cal")).expect("JSON");
    assert_eq!(stored["conditions"]["current_a"]["mean"], 0.0, "{}", stored["conditions"]);

    // The same board in a seventh of the directions, its motor never off.
    let part = ["--seed", "5", "--recording", "2", "--seconds", "60", "--motion", "cap=0.15"];
    let level = simulate(&here, "level.csv", &part);
    let flight = with_current(&here, &level, "flight.csv", |row| {
        15.0 + 3.0 * (0.01 * row).sin() + 2.0 * (row / 150.0).floor().rem_euclid(2.0)
    });
    let run = ironout(["diagnose", text(&flight), "--prior", text(&cal), "--json"]);
    let found = run.json();
    let added: Vec<&str> = (found["steps"].as_array().expect("steps").iter())
        .filter_map(|step| step["added"].as_str())
        .collect();
    assert_eq!(
        (found["verdict"].as_str(), added.as_slice()),
        (Some("missing"), ["offset:current_a"].as_slice()),
        "{found}"
    );
    let fit = ["fit", text(&flight), "--prior", text(&cal), "--add", "offset:current_a", "--json"];
    let effect = ironout(fit).json()["effects"][0].clone();
    assert_eq!(effect["reference"]["current_a"], 0.0, "{effect}");
    for (axis, per_ampere) in FIELD_UT_A.iter().enumerate() {
        let own = effect["coefficients"][axis].as_f64().expect("a number");
        assert!((own - per_ampere).abs() < 0.02, "axis {axis}: {own}, put in {per_ampere}");
    }
    // A mean that no column has is no calibration's.
    let mut odd = stored.clone();
    odd["conditions"]["current_a"]["mean"] = 1e300.into();
    let odd = write(&here, "odd.json", odd.to_string());
    let refused = ironout(["diagnose", text(&flight), "--prior", text(&odd), "--json"]).error();
    assert_eq!(refused["column"], "conditions", "{refused}");
    // What an earlier program wrote says nothing of the columns: it is read as before.
    let mut old = stored;
    old.as_object_mut().expect("an object").remove("conditions");
    let old = write(&here, "old.json", old.to_string());
    assert_eq!(ironout(["diagnose", text(&flight), "--prior", text(&old), "--json"]).status, 0);
}

#[test]
fn a_calibration_that_was_given_is_not_asked_for() {
    let here = folder("prior_given");
    let turned = simulate(&here, "turned.csv", &["--seed", "6", "--seconds", "60"]);
    let cal = calibrate(&here, &turned, &[]);
    // Half a second says nothing, with the calibration or without.
    let content = std::fs::read_to_string(&turned).expect("text");
    let rows = content.lines().filter(|line| !line.starts_with('#')).take(26);
    let few = write(&here, "few.csv", rows.map(|row| format!("{row}\n")).collect::<String>());
    let alone = ironout(["diagnose", text(&few)]);
    assert!(alone.status == 1 && alone.stdout.contains("--prior earlier.json"), "{}", alone.stdout);
    let on_top = ironout(["diagnose", text(&few), "--prior", text(&cal)]);
    assert!(on_top.status == 1 && on_top.stdout.contains("Record again"), "{}", on_top.stdout);
    assert!(!on_top.stdout.contains("--prior earlier.json"), "{}", on_top.stdout);
}
