//! A calibration is one of a scale and of a mounting: CAL.json knows them, and says so where a log is read otherwise.

mod common;

use common::{Run, folder, ironout, write};
use std::path::{Path, PathBuf};

fn run(words: &[&str], paths: &[&Path]) -> Run {
    ironout(
        words.iter().map(AsRef::<std::ffi::OsStr>::as_ref).chain(paths.iter().map(|path| path.as_os_str())),
    )
}

/// A log in counts, and the folder it is in.
fn counts() -> (PathBuf, PathBuf) {
    let here = folder("reading");
    let log = here.join("ut.csv");
    assert_eq!(run(&["simulate", "--seed", "3", "-o"], &[&log]).status, 0);
    let text = std::fs::read_to_string(&log).expect("the log");
    let mut out = String::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        let row = match cells[1].parse::<f64>() {
            Err(_) => "t_s,mx_counts,my_counts,mz_counts".to_string(),
            Ok(_) => {
                let count = |cell: &str| (cell.parse::<f64>().expect("a number") / 0.05).round().to_string();
                format!("{},{},{},{}", cells[0], count(cells[1]), count(cells[2]), count(cells[3]))
            }
        };
        out.push_str(&row);
        out.push('\n');
    }
    (write(&here, "counts.csv", out), here)
}

#[test]
fn the_scale_and_the_mounting_of_a_calibration_are_kept() {
    let (log, here) = counts();
    let cal = here.join("cal.json");
    let fit = run(&["fit", "--ut-per-count", "0.05", "--rotate", "roll180", "-o"], &[&cal, &log]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    // The scale is the calibration's; the mounting is the log's, and must be said.
    for command in ["apply", "check"] {
        let run_with = |more: &[&str]| {
            let words = [&[command, "--json"], more, &["--cal"]].concat();
            run(&words, &[&cal, &log])
        };
        let good = run_with(&["--rotate", "roll180"]);
        assert_eq!(good.status, 0, "{command}: {} {}", good.stdout, good.stderr);
        assert_eq!(run_with(&["--rotate", "roll180", "--ut-per-count", "0.05"]).status, 0);
        let other_scale = run_with(&["--rotate", "roll180", "--ut-per-count", "0.06"]).error();
        let message = other_scale["message"].as_str().expect("a message").to_string();
        assert!(message.contains("0.05") && message.contains("0.06"), "{message}");
        let message = run_with(&[]).error()["message"].as_str().expect("a message").to_string();
        assert!(message.contains("--rotate=roll180") && message.contains("no --rotate"), "{message}");
    }
    let prior = run(&["fit", "--json", "--ut-per-count", "0.05", "--prior"], &[&cal, &log]).error();
    assert!(prior["message"].as_str().expect("a message").contains("roll180"), "{prior}");
    // A file of an earlier program knows neither.
    let text = std::fs::read_to_string(&cal).expect("the calibration");
    let mut value: serde_json::Value = serde_json::from_str(&text).expect("an object");
    assert_eq!(value["reading"]["ut_per_count"], serde_json::json!([0.05, 0.05, 0.05]));
    value.as_object_mut().expect("an object").remove("reading");
    let old = write(&here, "old.json", value.to_string());
    assert_eq!(run(&["apply", "--json", "--ut-per-count", "0.05", "--cal"], &[&old, &log]).status, 0);
    let missing = run(&["apply", "--json", "--cal"], &[&old, &log]).error();
    assert!(missing["message"].as_str().expect("a message").contains("--ut-per-count"), "{missing}");
}
