//! The answer comes first, in a screen; one line with `-q`, everything with `-v`; and the program helps who types something wrong.

use crate::common::{calibrate, folder, ironout, simulate, text, write};
use std::process::Command;

/// Lines of the first screen.
const MOST_LINES: usize = 25;

#[test]
fn fit_and_diagnose_answer_in_a_screen_with_the_verdict_first() {
    let here = folder("answer_first");
    for (name, effects, verdicts) in [
        ("clean", &[][..], ["ACCEPTED", "COMPLETE:"]),
        ("current", &["--effect", "offset:current_a=2"], ["ACCEPTED", "FOUND:"]),
        ("ramp", &["--effect", "offset:temp_c=3", "--ramp"], ["", "CONFOUNDED:"]),
        ("level", &["--motion", "planar"], ["ACCEPTED for tilts up to 5°", "UNDETERMINED:"]),
        ("rest", &["--motion", "rest"], ["REFUSED", ""]),
    ] {
        let options = ["--seconds", "100", "--seed", "17"];
        let log = simulate(&here, &format!("{name}.csv"), &[&options[..], effects].concat());
        for (command, verdict) in ["fit", "diagnose"].into_iter().zip(verdicts) {
            let brief = ironout([command, text(&log)]);
            let lines: Vec<&str> = brief.stdout.lines().chain(brief.stderr.lines()).collect();
            assert!(lines.len() <= MOST_LINES, "{name} {command}: {} lines\n{}", lines.len(), brief.stdout);
            assert!(brief.stdout.starts_with(verdict), "{name} {command}:\n{}", brief.stdout);
            assert!(brief.stdout.contains("Next steps"), "{name} {command}:\n{}", brief.stdout);
            let full = ironout([command, text(&log), "-v"]);
            let in_full = full.stdout.lines().chain(full.stderr.lines()).count();
            assert!(in_full > lines.len(), "{name} {command}:\n{}", full.stdout);
            let quiet = ironout([command, text(&log), "-q"]);
            assert_eq!((quiet.stdout.lines().count(), quiet.stderr.as_str()), (1, ""), "{}", quiet.stdout);
            assert_eq!((brief.status, full.status), (quiet.status, quiet.status), "{name} {command}");
            // Nothing is said ten times.
            for line in full.stdout.lines().filter(|line| line.split_whitespace().count() > 6) {
                let tail: String = line.chars().skip(30).collect();
                let same = full.stdout.lines().filter(|other| other.ends_with(&tail)).count();
                assert!(tail.chars().count() < 40 || same < 4, "{name} {command}: {same} times: {line}");
            }
        }
    }
}

#[test]
fn the_next_steps_can_be_pasted() {
    let here = folder("answer_pasted");
    let log =
        simulate(&here, "log.csv", &["--seconds", "100", "--seed", "17", "--effect", "offset:current_a=2"]);
    for command in ["fit", "diagnose"] {
        let answer = ironout([command, text(&log)]).stdout;
        let steps: Vec<&str> = answer.lines().filter(|line| line.starts_with("    ironout ")).collect();
        assert!(!steps.is_empty(), "{answer}");
        for step in steps.into_iter().filter(|step| !step.contains("second.csv")) {
            let words: Vec<&str> = step.split_whitespace().skip(1).filter(|word| *word != "-o").collect();
            let run = ironout(words.into_iter().filter(|word| !word.ends_with("cal.json")));
            assert_eq!(run.status, 0, "{step}: {}{}", run.stdout, run.stderr);
        }
    }
}

#[test]
fn fields_are_printed_in_the_unit_that_was_asked_for() {
    let here = folder("answer_unit");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "1"]);
    let error = |unit: &str, symbol: &str| {
        let run = ironout(["fit", text(&log), "--unit", unit]);
        let line =
            run.stdout.lines().find(|line| line.trim_start().starts_with("noise floor")).expect("a floor");
        let mut words = line.split_whitespace().skip(2);
        let value: f64 = words.next().and_then(|word| word.parse().ok()).expect("a number");
        assert_eq!(words.next(), Some(symbol), "{line}");
        value
    };
    let ut = error("ut", "µT");
    for (unit, symbol, factor) in [("nt", "nT", 1000.0), ("mg", "mG", 10.0), ("g", "G", 0.01)] {
        assert!((error(unit, symbol) / factor / ut - 1.0).abs() < 0.05, "{unit}");
    }
    let json = |unit: &str| ironout(["fit", text(&log), "--json", "--unit", unit]).json()["rms_ut"].clone();
    assert_eq!(json("ut"), json("nt"), "JSON keeps the unit of its keys");
    let wrong = ironout(["fit", text(&log), "--units", "nt"]);
    assert!(wrong.status == 2 && !wrong.stderr.contains("-- --units"), "{}", wrong.stderr);
}

#[test]
fn colour_is_for_terminals_only() {
    let here = folder("answer_colour");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "1"]);
    let run = |force: bool, no_color: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ironout"));
        command.args(["fit", text(&log)]).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        if force {
            command.env("CLICOLOR_FORCE", "1");
        }
        if no_color {
            command.env("NO_COLOR", "1");
        }
        String::from_utf8(command.output().expect("a run").stdout).expect("text")
    };
    let plain = run(false, false);
    assert!(!plain.contains('\u{1b}'), "{plain}");
    let painted = run(true, false);
    assert!(painted.contains('\u{1b}'), "{painted}");
    assert!(!run(false, true).contains('\u{1b}'));
}

#[test]
fn a_name_that_is_nearly_right_is_recognised() {
    let here = folder("answer_meant");
    let log = simulate(&here, "flight.csv", &["--seconds", "60", "--seed", "1"]);
    let said = |words: &[&str]| {
        let run = ironout(words);
        assert_eq!(run.status, 2, "{words:?}: {}{}", run.stdout, run.stderr);
        run.said()
    };
    let effect = said(&["fit", text(&log), "--add", "current"]);
    assert!(
        effect.contains("Did you mean offset:current_a") && effect.contains("ironout effects"),
        "{effect}"
    );
    let column = said(&["fit", text(&log), "--add", "offset:curent_a"]);
    assert!(column.contains("Did you mean current_a?"), "{column}");
    let column = said(&["fit", text(&log), "--ignore", "tmp_c"]);
    assert!(column.contains("Did you mean temp_c?"), "{column}");
    let file = said(&["fit", text(&here.join("fligth.csv"))]);
    assert!(file.contains("Did you mean flight.csv?"), "{file}");
    let command = said(&["diagnos", text(&log)]);
    assert!(command.contains("diagnose"), "{command}");
}

#[test]
fn a_log_in_the_place_of_a_calibration_is_recognised_and_the_other_way_round() {
    let here = folder("answer_swapped");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "1"]);
    let cal = calibrate(&here, &log, &[]);
    let run = ironout(["apply", text(&cal), "--cal", text(&log)]);
    assert!(run.status == 2 && run.said().contains("Did you swap LOG and CAL?"), "{}", run.stderr);
    let run = ironout(["diagnose", text(&cal)]);
    assert!(run.status == 2 && run.said().contains("ironout calibration, not a log"), "{}", run.stderr);
    // A JSON log is still one.
    let json = write(&here, "rows.json", "[{\"mx_ut\":1,\"my_ut\":2,\"mz_ut\":3}]\n");
    assert!(!ironout(["fit", text(&json)]).said().contains("ironout calibration"));
}

#[test]
fn the_effects_of_a_log_are_listed_with_what_is_missing() {
    let here = folder("answer_effects");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "1", "--without", "temp_c"]);
    let run = ironout(["effects", text(&log)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    for part in ["offset:current_a", "gain:current_a", "nonlinearity", "Not testable", "temp_c"] {
        assert!(run.stdout.contains(part), "no {part} in\n{}", run.stdout);
    }
    // Each that is listed can be added.
    let object = ironout(["effects", text(&log), "--json"]).json();
    let columns = object["columns"].as_array().expect("columns");
    let ids: Vec<&str> = columns
        .iter()
        .flat_map(|one| one["effects"].as_array().expect("ids"))
        .filter_map(|id| id.as_str())
        .collect();
    assert!(ids.len() >= 4, "{object}");
    for id in ids {
        let run = ironout(["fit", text(&log), "--add", id, "-q"]);
        assert_ne!(run.status, 2, "{id}: {}", run.stderr);
    }
}

#[test]
fn shells_and_manuals_know_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = ironout(["completions", shell]).stdout;
        assert!(script.contains("diagnose") && script.contains("effects"), "{shell}");
    }
    assert!(ironout(["man"]).stdout.contains(".TH ironout"));
    let folder = folder("answer_man");
    assert_eq!(ironout(["man", text(&folder)]).status, 0);
    for page in ["ironout.1", "ironout-fit.1", "ironout-diagnose.1", "ironout-effects.1"] {
        let page = std::fs::read_to_string(folder.join(page)).expect("a page");
        assert!(page.contains(".SH"), "{page}");
    }
}
