//! Effects from the fit to the correction: found to their errors, kept in files, applied alike everywhere, refused by name.

use crate::common::{folder, ironout, simulate, text, write};
use std::path::{Path, PathBuf};

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("no list: {value}")).iter().map(number).collect()
}

/// The true coefficients of the hidden effects, one list each, as the log says them.
fn hidden(log: &Path) -> Vec<Vec<f64>> {
    let content = std::fs::read_to_string(log).expect("text");
    let lines = content.lines().filter(|line| line.starts_with("# effect "));
    lines
        .map(|line| {
            let list = line.split_once('[').expect("a list").1;
            let list = list.split_once(']').expect("its end").0;
            list.split(',').map(|word| word.trim().parse().expect("a number")).collect()
        })
        .collect()
}

/// The rows `from..to` of a log, as a log of its own.
fn part(here: &Path, log: &Path, name: &str, from: usize, to: usize) -> PathBuf {
    let content = std::fs::read_to_string(log).expect("text");
    let mut lines = content.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header");
    let rows: Vec<&str> = lines.skip(from).take(to - from).collect();
    write(here, name, format!("{header}\n{}\n", rows.join("\n")))
}

/// The log with the cells of one column rewritten.
fn changed(
    here: &Path,
    log: &Path,
    name: &str,
    column: &str,
    cell: impl Fn(usize, &str) -> String,
) -> PathBuf {
    let content = std::fs::read_to_string(log).expect("text");
    let mut lines = content.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header");
    let place = header.split(',').position(|word| word == column).expect("the column");
    let rows: Vec<String> = lines
        .enumerate()
        .map(|(row, line)| {
            let mut cells: Vec<String> = line.split(',').map(String::from).collect();
            cells[place] = cell(row, &cells[place]);
            cells.join(",")
        })
        .collect();
    write(here, name, format!("{header}\n{}\n", rows.join("\n")))
}

#[test]
fn each_effect_is_fitted_to_its_errors_and_the_noise_is_what_remains() {
    let here = folder("effects_fitted");
    let (mut all, mut beyond_three) = (0, 0);
    for (id, seed) in [
        ("offset:temp_c", "21"),
        ("gain:temp_c", "22"),
        ("field:height_m", "23"),
        ("drift", "24"),
        ("step", "25"),
        ("lag", "26"),
        ("nonlinearity", "5"),
        ("cross-axis", "28"),
        ("periodic", "29"),
        ("offset:current_a^2", "30"),
        ("offset:current_a@delay", "31"),
    ] {
        let hide = format!("{id}=3");
        let log = simulate(&here, "log.csv", &["--seconds", "100", "--seed", seed, "--effect", &hide]);
        let run = ironout(["fit", text(&log), "--add", id, "--json"]);
        assert_eq!(run.status, 0, "{id}: {} {}", run.stdout, run.stderr);
        let object = run.json();
        let effect = &object["effects"][0];
        assert_eq!(effect["id"], id, "{object}");
        let (found, errors) = (numbers(&effect["coefficients"]), numbers(&effect["std_errors"]));
        let truth = hidden(&log).remove(0);
        assert_eq!(found.len(), truth.len(), "{id}");
        for ((found, truth), error) in found.iter().zip(&truth).zip(&errors) {
            let sigmas = (found - truth).abs() / error;
            // A delay, a frequency or a time that was searched has an error of its own beside these.
            assert!(sigmas < 6.0, "{id}: {found} ± {error}, true is {truth}");
            all += 1;
            beyond_three += i32::from(sigmas > 3.0);
        }
        let (held, floor) = (number(&object["holdout_rms_ut"]), number(&object["residual_floor_ut"]));
        assert!(held < 1.05 * floor, "{id}: {held} µT held out, the noise is {floor}");
        assert!((number(&object["noise_floor_ut"]) / 0.2517 - 1.0).abs() < 0.06, "{id}: {object}");
    }
    assert!(beyond_three * 20 <= all, "{beyond_three} of {all} coefficients beyond three standard errors");
}

#[test]
fn two_effects_at_once_and_the_words_say_what_they_are() {
    let here = folder("effects_two");
    let log = simulate(
        &here,
        "log.csv",
        &["--seconds", "100", "--seed", "4", "--effect", "offset:temp_c=4", "--effect", "offset:current_a=3"],
    );
    let run = ironout(["fit", text(&log), "-v", "--add", "offset:temp_c", "--add", "offset:current_a"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    for words in [
        "offset proportional to temperature (offset:temp_c)",
        "offset proportional to current (offset:current_a)",
        "Biot–Savart",
        "µT/°C",
        "µT/A",
        "without effects",
        "held out",
        "full 3×3",
        "measured − offset − effects",
    ] {
        assert!(run.stdout.contains(words), "no {words:?} in {}", run.stdout);
    }
}

#[test]
fn a_second_log_is_good_with_the_effect_and_not_without() {
    let here = folder("effects_check");
    let log =
        simulate(&here, "log.csv", &["--seconds", "160", "--seed", "6", "--effect", "offset:temp_c=12"]);
    let (first, second) =
        (part(&here, &log, "first.csv", 0, 4000), part(&here, &log, "second.csv", 5000, 8000));
    let (with, without) = (here.join("with.json"), here.join("without.json"));
    let run = ironout(["fit", text(&first), "--add", "offset:temp_c", "-o", text(&with)]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    // What a calibration at one temperature is worth later.
    let start = part(&here, &log, "start.csv", 3000, 4000);
    let run = ironout(["fit", text(&start), "-o", text(&without)]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let good = ironout(["check", text(&second), "--cal", text(&with), "--json"]);
    assert_eq!((good.status, good.json()["verdict"].as_str()), (0, Some("good")), "{}", good.stdout);
    assert!(number(&good.json()["rms_ut"]) < 0.3, "{}", good.stdout);
    let bad = ironout(["check", text(&second), "--cal", text(&without), "--json"]);
    assert_eq!(bad.status, 1, "{}", bad.stdout);

    let applied = here.join("applied.csv");
    let run = ironout(["apply", text(&second), "--cal", text(&with), "-o", text(&applied), "--json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!((number(&run.json()["after"]["rms_ut"]) - number(&good.json()["rms_ut"])).abs() < 0.02);
    assert_eq!(run.json()["effects"][0], "offset:temp_c");

    let again = ironout(["export", text(&with), "--as", "json"]);
    let (a, b): (serde_json::Value, serde_json::Value) = (
        serde_json::from_str(&again.stdout).expect("JSON"),
        serde_json::from_str(&std::fs::read_to_string(&with).expect("text")).expect("JSON"),
    );
    assert_eq!(a, b, "a file with effects round-trips");
}

#[test]
fn what_cannot_be_added_or_applied_is_named() {
    let here = folder("effects_refused");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "7", "--effect", "offset:temp_c"]);
    let add = |log: &Path, ids: &[&str]| {
        let mut arguments = vec!["fit", text(log), "--json"];
        ids.iter().for_each(|id| arguments.extend(["--add", id]));
        ironout(arguments).error()
    };
    let word = |error: &serde_json::Value, word: &str| {
        assert!(
            error["message"].as_str().is_some_and(|message| message.contains(word)),
            "no {word:?} in {error}"
        );
    };
    let unknown = add(&log, &["wobble"]);
    word(&unknown, "unknown effect");
    word(&unknown, "ironout effects");
    let error = add(&log, &["offset:oil_c"]);
    word(&error, "temp_c, current_a, height_m");
    assert_eq!(error["column"], "oil_c");
    word(&add(&log, &["drift", "drift"]), "twice");
    word(&add(&log, &["drift", "step", "lag", "periodic", "nonlinearity"]), "at most 4");
    word(&add(&log, &["misalignment"]), "always part of the fit");

    let constant = changed(&here, &log, "constant.csv", "temp_c", |_, _| "25".into());
    for id in ["offset:temp_c", "offset:temp_c^2", "gain:temp_c", "offset:temp_c@delay"] {
        let error = add(&constant, &[id]);
        word(&error, "constant");
        assert_eq!(error["column"], "temp_c");
    }
    let nan = changed(
        &here,
        &log,
        "nan.csv",
        "temp_c",
        |row, cell| if row == 500 { "nan".into() } else { cell.into() },
    );
    word(&add(&nan, &["offset:temp_c"]), "NaN or infinite");
    let empty =
        changed(
            &here,
            &log,
            "empty.csv",
            "temp_c",
            |row, cell| if row % 400 == 0 { cell.into() } else { String::new() },
        );
    word(&add(&empty, &["gain:temp_c"]), "empty in 2992 of 3000 rows");
    let no_gyro = changed(&here, &log, "plain.csv", "gx_radps", |_, _| String::new());
    add(&no_gyro, &["lag"]);
    let run = ironout(["fit", text(&log), "--add", "drift", "--method", "constant", "--json"]);
    word(&run.error(), "--method constant");

    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&log), "--add", "offset:temp_c", "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let cold = simulate(&here, "cold.csv", &["--seconds", "60", "--seed", "7", "--without", "temp_c"]);
    for command in ["apply", "check"] {
        let error = ironout([command, text(&cold), "--cal", text(&cal), "--json"]).error();
        assert_eq!(error["column"], "temp_c");
        word(&error, "offset:temp_c");
    }
    // A few empty cells are taken between their neighbours.
    let holes =
        changed(
            &here,
            &log,
            "holes.csv",
            "temp_c",
            |row, cell| if row % 3 == 0 { String::new() } else { cell.into() },
        );
    let run = ironout(["apply", text(&holes), "--cal", text(&cal), "--json"]);
    assert!(number(&run.json()["after"]["rms_ut"]) < 0.27, "{}", run.stdout);
}

#[test]
fn an_earlier_calibration_carries_a_log_of_little_attitude() {
    let here = folder("effects_prior");
    let log = simulate(&here, "log.csv", &["--seconds", "100", "--seed", "8"]);
    let (whole, short) =
        (part(&here, &log, "whole.csv", 0, 4000), part(&here, &log, "short.csv", 4000, 4250));
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&whole), "--field", "50", "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let first: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("JSON");
    for (options, field) in [(vec![], 50.0), (vec!["--field", "40"], 40.0)] {
        let mut arguments = vec!["fit", text(&short), "--prior", text(&cal), "--json"];
        arguments.extend(&options);
        let run = ironout(arguments);
        assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
        let object = run.json();
        assert_eq!(number(&object["field_ut"]), field);
        for axis in 0..3 {
            let (was, is) = (number(&first["offset_ut"][axis]), number(&object["offset_ut"][axis]));
            let error = number(&first["std_errors"]["offset_ut"][axis]);
            // Known as before, but for what a board changes between two sessions, 0.3 % of the field.
            let known = error.hypot(0.003 * 50.0);
            assert!((is - was).abs() < 4.0 * known, "{is} after {was} ± {known}");
            assert!(number(&object["std_errors"]["offset_ut"][axis]) <= 1.05 * known, "{object}");
        }
    }
}

#[test]
fn a_coefficient_that_the_log_does_not_show_has_no_error_and_the_file_says_null() {
    let here = folder("effects_unseen");
    let options = ["--without", "ax_mps2", "--without", "ay_mps2", "--without", "az_mps2"];
    let log = simulate(&here, "log.csv", &[&["--seed", "5", "--effect", "eddy=4"], &options[..]].concat());
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&log), "--add", "lag", "-o", text(&cal), "--json"]);
    assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
    let errors = &run.json()["effects"][0]["std_errors"];
    // A pure delay leaves the magnitude alone: without an accelerometer the coupling's diagonal is open.
    assert!(errors[0].is_null() && errors[1].is_number(), "{errors}");
    let check = ironout(["check", text(&log), "--cal", text(&cal)]);
    assert_eq!(check.status, 0, "{} {}", check.stdout, check.stderr);
}

#[test]
fn in_which_order_effects_are_asked_for_does_not_matter() {
    let here = folder("effects_order");
    // The current's offset is six times the coupling, which shows beside it alone.
    let options =
        ["--seed", "12", "--noise", "0.1", "--effect", "eddy=1.5", "--effect", "offset:current_a=9"];
    let log = simulate(&here, "log.csv", &options);
    let fitted = |add: [&str; 2]| {
        let run = ironout(["fit", text(&log), "--add", add[0], "--add", add[1], "--json"]);
        assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
        run.json()
    };
    let (one, other) = (fitted(["lag", "offset:current_a"]), fitted(["offset:current_a", "lag"]));
    let coupling = |object: &serde_json::Value| {
        let effects = object["effects"].as_array().expect("a list");
        let lag = effects.iter().find(|effect| effect["id"] == "lag").expect("a lag");
        numbers(&lag["coefficients"]).len()
    };
    assert_eq!((coupling(&one), coupling(&other)), (9, 9), "{one}");
    assert_eq!(number(&one["rms_ut"]), number(&other["rms_ut"]));
}
