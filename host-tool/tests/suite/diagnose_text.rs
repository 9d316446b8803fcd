//! What `diagnose` says to people, against snapshots of seeded logs.
//!
//! A snapshot is compared as `crate::common::alike` says. `IRONOUT_BLESS=1` writes them anew.

use crate::common::alike::{self, number};
use crate::common::{folder, ironout};
use std::path::Path;

/// The explanation of a simulated log, with the log's path taken out.
fn explained(name: &str, simulate: &[&str], diagnose: &[&str]) -> (String, i32) {
    let folder = folder(&format!("diagnose_text_{name}"));
    let log = folder.join("log.csv");
    let log = log.to_str().expect("a path of text");
    let made = ironout(["simulate", "-o", log, "--rate", "50"].iter().chain(simulate));
    assert_eq!(made.status, 0, "{}", made.stderr);
    let run = ironout(["diagnose", log, "-v"].iter().chain(diagnose));
    // How the log was read, and nothing else.
    assert!(run.stderr.starts_with("read as  CSV") && run.stderr.lines().count() == 1, "{}", run.stderr);
    (run.stdout.replace(log, "LOG"), run.status)
}

const SPARKS: &str = "▁▂▃▄▅▆▇█";

fn compare(name: &str, now: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/snapshots/diagnose-{name}.txt"));
    if std::env::var_os("IRONOUT_BLESS").is_some() {
        std::fs::write(&path, now).expect("a snapshot");
        return;
    }
    let then = std::fs::read_to_string(&path).expect("a snapshot: write it with IRONOUT_BLESS=1");
    alike::assert_alike(name, now, &then);
}

fn lines_fit(text: &str) {
    for line in text.lines() {
        // The commands are meant to be copied, so they are not broken.
        let width = line.chars().count();
        assert!(width <= 100 || line.trim_start().starts_with("ironout "), "{width} wide: {line}");
    }
}

/// The text without its line breaks.
fn joined(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn a_hidden_temperature_offset_is_explained_from_the_noise_to_the_command() {
    let (text, status) =
        explained("temperature", &["--seed", "3", "--seconds", "80", "--effect", "offset:temp_c=3"], &[]);
    assert_eq!(status, 0);
    lines_fit(&text);
    // In this order.
    let mut rest = text.as_str();
    for part in [
        "FOUND: offset proportional to temperature (offset:temp_c).",
        "noise floor",
        "Next steps",
        "ironout fit LOG --add offset:temp_c -o cal.json",
        "ironout check second.csv --cal cal.json",
        "sensor noise",
        "× the noise floor, so the model lacks",
        "Residual by column",
        "temp_c",
        "1. offset proportional to temperature   offset:temp_c",
        "The offset of the sensor element drifts with temperature",
        "µT/°C",
        "held out",
        "Error with each effect added",
        "+ offset:temp_c",
        "noise floor",
        "Tested and not significant",
    ] {
        let at = rest.find(part).unwrap_or_else(|| panic!("no `{part}` in its place in\n{text}"));
        rest = &rest[at + part.len()..];
    }
    compare("temperature", &text);
}

#[test]
fn a_curve_rises_with_the_temperature_and_is_flat_with_the_effect() {
    let (text, _) =
        explained("curve", &["--seed", "3", "--seconds", "80", "--effect", "offset:temp_c=3"], &[]);
    let curve = |label: &str| -> Vec<usize> {
        let line = text.lines().find(|line| line.trim_start().starts_with(label)).expect(label);
        line.chars().filter_map(|c| SPARKS.chars().position(|spark| spark == c)).collect()
    };
    let (before, after) = (curve("residual before"), curve("residual after"));
    assert!(before.len() >= 20 && after.len() >= 20, "{text}");
    let mean = |levels: &[usize]| levels.iter().sum::<usize>() as f64 / levels.len() as f64;
    assert!(mean(&before[..8]) + 3.0 < mean(&before[before.len() - 8..]), "{before:?}");
    assert!(after.iter().max().unwrap_or(&9) - after.iter().min().unwrap_or(&0) <= 2, "{after:?}");
}

#[test]
fn a_steady_ramp_is_said_to_be_ambiguous_with_the_recording_that_separates() {
    let ramp = ["--seed", "13", "--seconds", "80", "--effect", "offset:temp_c=3", "--ramp"];
    let (text, status) = explained("ramp", &ramp, &[]);
    assert_eq!(status, 0);
    lines_fit(&text);
    let flat = joined(&text);
    assert!(
        flat.contains(
            "CONFOUNDED: offset proportional to temperature (offset:temp_c) and offset drift (drift) explain the \
             error equally well"
        ),
        "{text}"
    );
    assert!(flat.contains("while it cools down") && flat.contains("at constant temperature"), "{text}");
    assert!(flat.contains("ironout fit LOG --add drift -o cal.json"), "{text}");
    compare("ramp", &text);
}

#[test]
fn a_clean_log_with_a_passing_magnet_is_complete_and_the_burst_is_reported() {
    let (text, status) = explained("burst", &["--seed", "20", "--seconds", "80", "--effect", "burst"], &[]);
    assert_eq!(status, 0);
    lines_fit(&text);
    assert!(text.contains("Faults of the data") && text.contains("burst"), "{text}");
    assert!(text.contains("COMPLETE: offset and matrix explain this log"), "{text}");
    assert!(text.contains("Residual by column (none is significant)"), "{text}");
    compare("burst", &text);
}

#[test]
fn a_pure_lag_falls_in_the_dip_and_is_given_in_milliseconds() {
    let (text, status) = explained("lag", &["--seed", "5", "--seconds", "80", "--effect", "lag=18ms"], &[]);
    assert_eq!(status, 0);
    lines_fit(&text);
    let line = text.lines().find(|line| line.trim_start().starts_with("delay")).expect("a delay");
    let ms = line.split_whitespace().nth(1).and_then(number).expect("a number");
    assert!((ms - 18.0).abs() < 1.8 && line.ends_with("ms"), "{line}");
    assert!(text.contains("Error with each effect added (dip spread, rms)"), "{text}");
    compare("lag", &text);
}

#[test]
fn the_commands_keep_the_users_options() {
    let folder = folder("diagnose_text_options");
    let log = folder.join("my log.csv");
    let log = log.to_str().expect("a path of text");
    let simulate =
        ["simulate", "-o", log, "--seed", "2", "--seconds", "60", "--effect", "offset:current_a=3"];
    assert_eq!(ironout(simulate).status, 0);
    let options = ["--field", "48", "--rotate", "roll180", "--map", "load_a=current_a"];
    let run = ironout(["diagnose", log].iter().chain(&options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    let expected = format!(
        "ironout fit '{log}' --map load_a=current_a --rotate roll180 --field 48 --add offset:load_a -o cal.json"
    );
    assert!(run.stdout.contains(&expected), "{}", run.stdout);
    assert!(
        run.stdout
            .contains("ironout check second.csv --map load_a=current_a --rotate roll180 --cal cal.json"),
        "{}",
        run.stdout
    );
}

#[test]
fn what_a_log_lacks_is_said_with_how_to_log_it() {
    let without =
        ["temp_c", "current_a", "gx_radps", "gy_radps", "gz_radps", "ax_mps2", "ay_mps2", "az_mps2"];
    let mut simulate = vec!["--seed", "8", "--seconds", "60"];
    without.iter().for_each(|name| simulate.extend(["--without", name]));
    let (text, status) = explained("lacking", &simulate, &[]);
    assert_eq!(status, 0);
    lines_fit(&text);
    let at = text.find("Not testable with this log").expect("the section");
    for part in ["offset:temp_c", "°C", "offset:current_a", "module", "lag", "gyroscope", "misalignment"] {
        assert!(text[at..].contains(part), "no {part} in\n{}", &text[at..]);
    }
}

#[test]
fn what_only_a_longer_log_can_tell_is_said_so() {
    let short = ["--seed", "5", "--seconds", "20", "--noise", "0.8", "--effect", "nonlinearity=4"];
    let (text, status) = explained("unsure", &short, &[]);
    assert_eq!(status, 0);
    lines_fit(&text);
    let said = joined(&text);
    for part in [
        "UNEXPLAINED: The predicted error of",
        "the noise floor. No other effect is significant in this log",
        "Record longer, in more orientations, and diagnose that log: ironout diagnose longer.csv",
    ] {
        assert!(said.contains(part), "{part}: {text}");
    }
    // The same recorded longer.
    let longer = ["--seed", "5", "--seconds", "120", "--noise", "0.8", "--effect", "nonlinearity=4"];
    let (text, _) = explained("unsure_longer", &longer, &[]);
    assert!(joined(&text).contains("FOUND: nonlinearity"), "{text}");
}

#[test]
fn a_strength_that_makes_no_numbers_is_refused() {
    let folder = folder("diagnose_text_no_numbers");
    let log = folder.join("log.csv");
    let log = log.to_str().expect("a path of text");
    for seed in ["3", "4", "8"] {
        let strong = ["--seed", seed, "--seconds", "20", "--noise", "0.8", "--effect", "nonlinearity=4"];
        let run = ironout(["simulate", "-o", log].iter().chain(&strong));
        assert!(
            run.status == 2 && run.said().contains("Choose a smaller one"),
            "{seed}: {} {}",
            run.status,
            run.stderr
        );
        assert!(!Path::new(log).exists(), "{seed}: nothing is written");
    }
}
