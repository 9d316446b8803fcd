//! Several logs of one calibration.

use crate::common::{folder, ironout, simulate, text, write};
use std::path::{Path, PathBuf};

/// Two recordings of one board; each alone sees a part of the sphere.
fn halves(here: &Path) -> [PathBuf; 2] {
    let log = simulate(here, "whole.csv", &["--seed", "31", "--seconds", "100"]);
    let content = std::fs::read_to_string(log).expect("text");
    let rows: Vec<&str> = content.lines().filter(|line| !line.starts_with('#')).collect();
    let (header, rows) = (rows[0], &rows[1..]);
    let part = |name: &str, rows: &[&str]| write(here, name, format!("{header}\n{}\n", rows.join("\n")));
    // The second begins its clock anew.
    let again: Vec<String> = rows[2500..]
        .iter()
        .map(|row| {
            let (time, rest) = row.split_once(',').expect("cells");
            format!("{:.5},{rest}", time.parse::<f64>().expect("a time") - 50.0)
        })
        .collect();
    let again: Vec<&str> = again.iter().map(String::as_str).collect();
    [part("a.csv", &rows[..2500]), part("b.csv", &again)]
}

fn number(object: &serde_json::Value, key: &str) -> f64 {
    object[key].as_f64().unwrap_or_else(|| panic!("no {key} in {object}"))
}

#[test]
fn two_logs_are_one_calibration() {
    let here = folder("several");
    let [a, b] = halves(&here);
    let cal = here.join("cal.json");
    let whole = ironout(["fit", text(&here.join("whole.csv")), "--json"]).json();
    let both = ironout(["fit", text(&a), text(&b), "--json", "-o", text(&cal)]);
    assert_eq!(both.status, 0, "{}", both.stderr);
    assert!(both.said().contains("is appended (2500 rows) at t = 50."), "{}", both.stderr);
    let both = both.json();
    assert_eq!(
        number(&both, "samples_used") + number(&both, "samples_set_aside"),
        number(&whole, "samples_used") + number(&whole, "samples_set_aside")
    );
    for axis in 0..3 {
        let of = |object: &serde_json::Value| object["offset_ut"][axis].as_f64().expect("a number");
        assert!((of(&both) - of(&whole)).abs() < 1e-3, "{both}");
    }
    // The seam is no fault of the data, and nothing is found there.
    let study = ironout(["diagnose", text(&a), text(&b), "--json"]).json();
    assert_eq!(study["data_faults"], serde_json::json!([]));
    assert_eq!(study["verdict"], "complete", "{study}");
    let words = ironout(["diagnose", text(&a), text(&b)]);
    assert!(words.stdout.contains(&format!("ironout fit {} {}", text(&a), text(&b))), "{}", words.stdout);
    // apply prints each, check judges them together.
    let each = ironout(["apply", text(&a), text(&b), "--cal", text(&cal)]);
    assert_eq!(each.stdout.matches("error after").count(), 2, "{}", each.stdout);
    let each = ironout(["apply", text(&a), text(&b), "--cal", text(&cal), "--json"]).json();
    assert_eq!(each["logs"].as_array().map(Vec::len), Some(2));
    let alone = ironout(["apply", text(&b), "--cal", text(&cal), "--json"]).json();
    assert_eq!(each["logs"][1], alone);
    let good = ironout(["check", text(&a), text(&b), "--cal", text(&cal), "--json"]).json();
    assert_eq!(good["verdict"], "good");
    let error = ironout(["apply", text(&a), text(&b), "--cal", text(&cal), "-o", "x.csv", "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|words| words.contains("one by one")), "{error}");
    let error = ironout(["fit", text(&a), text(&b), "-o", text(&b), "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|words| words.contains("overwrite the input")), "{error}");
}

#[test]
fn what_changed_between_two_recordings_is_an_offset_of_each() {
    let here = folder("several_step");
    let [a, b] = halves(&here);
    let moved: String = std::fs::read_to_string(&b)
        .expect("text")
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            match cells[1].parse::<f64>() {
                Ok(x) => format!("{},{},{}\n", cells[0], x + 2.0, cells[2..].join(",")),
                Err(_) => format!("{line}\n"),
            }
        })
        .collect();
    let moved = write(&here, "moved.csv", moved);
    let study = ironout(["diagnose", text(&a), text(&moved), "--json"]).json();
    let found = &study["recordings"];
    assert_eq!(found["recordings"].as_array().map(Vec::len), Some(2), "{study}");
    for (axis, moved) in [2.0, 0.0, 0.0].into_iter().enumerate() {
        let change = found["per_recording_ut"][axis].as_f64().expect("a number");
        assert!((change - moved).abs() < 0.1, "{found}");
    }
    assert!(number(found, "rms_ut") < 0.8 * number(found, "common_rms_ut"), "{found}");
}

#[test]
fn columns_that_one_log_lacks_are_empty_there_and_other_scales_are_refused() {
    let here = folder("several_columns");
    let a = simulate(&here, "a.csv", &["--seed", "32", "--effect", "offset:temp_c=8"]);
    let b = simulate(
        &here,
        "b.csv",
        &["--seed", "32", "--effect", "offset:temp_c=8", "--recording", "2", "--without", "current_a"],
    );
    let run = ironout(["diagnose", text(&a), text(&b), "--json"]);
    assert!(run.said().contains("it lacks current_a"), "{}", run.stderr);
    assert_eq!(run.json()["steps"][1]["added"], "offset:temp_c");
    let counts = std::fs::read_to_string(&b).expect("text").replacen(
        "mx_ut,my_ut,mz_ut",
        "mx_counts,my_counts,mz_counts",
        1,
    );
    let counts = write(&here, "counts.csv", counts);
    let error = ironout(["fit", text(&a), text(&counts), "--ut-per-count", "1", "--json"]).error();
    assert!(
        error["message"].as_str().is_some_and(|words| words.contains("one sensor, read in one way")),
        "{error}"
    );
    assert_eq!(error["file"], text(&counts));
    // A log that is not there, or wrong, is named.
    let error = ironout(["fit", text(&a), "nowhere.csv", "--json"]).error();
    assert_eq!(error["file"], "nowhere.csv");
}
