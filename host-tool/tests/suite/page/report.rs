//! Reports of logs.

use crate::common::{folder, ironout, simulate, text, write};
use crate::page::browser::{number, scenario, turn, words};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The words of a text, its numbers to twelve digits.
fn rounded(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-._".contains(c)));
    let word = |word: &str| word.parse::<f64>().map_or_else(|_| word.into(), |value| format!("{value:.11e}"));
    words.map(word).collect()
}

#[test]
fn a_report_shows_the_error_fall_when_the_missing_effect_is_switched_on() {
    let Some(_turn) = turn("a report") else { return };
    let here = folder("page-report");
    let log =
        simulate(&here, "log.csv", &["--seed", "17", "--seconds", "120", "--effect", "offset:current_a=3"]);
    let file = here.join("report.html");
    let run = ironout(["report", text(&log), "-o", text(&file), "--json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    // What was found is on, in the page and in what the command says of it.
    assert_eq!(run.json()["fit"]["effects"][0]["id"], "offset:current_a");
    let fitted = ironout(["fit", text(&log), "--json"]).json();
    let seen = scenario("report", json!({"file": file, "effect": "offset:current_a"}));
    // The command line's own digits.
    assert!((number(&seen["base"]) - number(&fitted["rms_ut"])).abs() <= 5.01e-4, "{seen}");
    // The floor of the model that has the effect: without it, the noise is told from what is left.
    let (base, now, floor) = (number(&seen["base"]), number(&seen["now"]), number(&seen["floorNow"]));
    assert!(base > 2.0 * floor && now < 1.15 * floor, "{seen}");
    // What is missing is not called noise before it is switched on, nor after it was switched off.
    assert!((number(&seen["floor"]) - floor).abs() < 0.05 * floor, "{seen}");
    assert!(words(&seen["sentence"]).starts_with("FOUND"), "{seen}");
    for key in ["sentenceOff", "sentenceAgain"] {
        assert!(words(&seen[key]).contains("times the noise floor"), "{seen}");
    }
    assert!(words(&seen["sentenceNow"]).contains("the noise floor of this log"), "{seen}");
    assert_eq!((&seen["on"], number(&seen["found"])), (&json!(true), now));
    let with = ironout(["fit", text(&log), "--add", "offset:current_a", "--json"]).json();
    assert!((now - number(&with["rms_ut"])).abs() <= 5.01e-4, "{now} {}", with["rms_ut"]);
    assert_eq!((&seen["turned"], &seen["checked"]), (&json!(true), &json!(true)));
    assert_eq!(seen["steps"].as_array().map(Vec::len), Some(2), "{seen}");
    assert_eq!(seen["download"], "calibration.h");
    assert!(words(&seen["exported"]).contains("current_a"), "{seen}");
    // Each target has its button, and the page writes what the command line does.
    let targets = seen["targets"].as_object().expect("targets");
    assert_eq!(targets.len(), 8, "{targets:?}");
    for (form, part) in [
        ("json", "offset_ut"),
        ("c", "offset"),
        ("rust", "current_a"),
        ("px4", "CAL_MAG0_XOFF"),
        ("ardupilot", "COMPASS_OFS_X"),
        ("betaflight", "mag_calibration"),
        ("ros", "bias"),
        ("iio", "in_magn"),
    ] {
        assert!(words(&targets[form][1]).contains(part), "{form}: {}", targets[form]);
    }
    let with_cal = here.join("with.json");
    let fit = ironout(["fit", text(&log), "--add", "offset:current_a", "-o", text(&with_cal)]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let header = ironout(["export", text(&with_cal), "--as", "c"]);
    // The page begins at the result of a search, `fit --add` at the plain model. They agree to twelve digits.
    assert_eq!(rounded(words(&targets["c"][1])), rounded(&header.stdout));
    for (key, parts) in [
        (
            "numbers",
            &[
                "offset proportional to current (offset:current_a)",
                "Size:",
                "standard error, µT/A",
                "offset, µT",
                "noise floor",
            ][..],
        ),
        ("gaps", &["of all directions were seen", "largest gap"]),
        (
            "licences",
            &[
                "three.js",
                "uPlot",
                "MIT",
                "Permission is hereby granted",
                "nalgebra (Apache-2.0): page, program",
            ],
        ),
    ] {
        for part in parts {
            assert!(words(&seen[key]).contains(part), "{key} without {part}: {}", seen[key]);
        }
    }
    assert!(!words(&seen["open"]).is_empty(), "{seen}");
    for (key, names) in [
        ("choices", &["current_a", "temp_c", "time"][..]),
        (
            "plots",
            &[
                "plot-magnitude",
                "plot-residual",
                "plot-dip",
                "plot-heading",
                "plot-column",
                "plot-dots",
                "plot-spectrum",
                "plot-histogram",
            ],
        ),
        ("onPaper", &["sentence", "figures", "stairs", "Residual", "Spectrum", "Samples by direction"]),
    ] {
        let all = seen[key].as_array().expect("a list");
        assert!(
            names.iter().all(|name| all.iter().any(|one| words(one).contains(name))),
            "{key}: {}",
            seen[key]
        );
    }
    // Eight plots and the sphere, and no canvas, button or export beside them.
    assert_eq!(seen["onPaper"].as_array().map(Vec::len), Some(12), "{}", seen["onPaper"]);
    let figures = seen["figures"].as_object().expect("figures");
    for (name, word) in [
        ("residual.svg", "residual, µT"),
        ("dots.svg", "current_a, A"),
        ("spectrum.svg", "frequency, Hz"),
        ("histogram.svg", "share of samples"),
        ("directions.svg", "front"),
    ] {
        let drawn = &figures[name];
        assert_eq!((&drawn["root"], &drawn["broken"]), (&json!("svg"), &json!(false)), "{name}: {drawn}");
        assert!(number(&drawn["marks"]) >= 2.0 && words(&drawn["words"]).contains(word), "{name}: {drawn}");
    }
    assert_eq!(seen["dark"], "dark");
    assert!(number(&seen["pages"]) >= 2.0, "{seen}");
}

#[test]
fn two_calibrations_and_two_logs_stand_side_by_side() {
    let Some(_turn) = turn("side by side") else { return };
    let here = folder("page-beside");
    let make = |name: &str, options: &[&str]| simulate(&here, name, options);
    let log = make("log.csv", &["--seed", "23", "--seconds", "40", "--effect", "stuck"]);
    let later = make("later.csv", &["--seed", "23", "--seconds", "40", "--recording", "2"]);
    let other = make("other.csv", &["--seed", "24", "--seconds", "40"]);
    let cal = |name: &str, log: &Path| {
        let path = here.join(name);
        let fit = ironout(["fit", text(log), "-o", text(&path)]);
        assert_eq!(fit.status, 0, "{}", fit.stderr);
        path
    };
    // One of the same board, one of another: only the second one is wrong for this log.
    let (good, wrong) = (cal("good.json", &later), cal("wrong.json", &other));
    let file = here.join("report.html");
    let options = ["--cal", text(&good), "--cal", text(&wrong), "--compare", text(&later), "-o", text(&file)];
    let run = ironout(["report", text(&log), "--no-search"].iter().chain(&options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    let seen = scenario("beside", json!({"file": file}));
    let rows = seen["rows"].as_array().expect("rows");
    let row = |name: &str| {
        let row =
            rows.iter().find(|row| words(&row[0]) == name).unwrap_or_else(|| panic!("no {name}: {rows:?}"));
        row.as_array().expect("cells").iter().skip(1).map(|cell| words(cell).to_string()).collect::<Vec<_>>()
    };
    assert_eq!(rows[0].as_array().map(Vec::len), Some(5), "{rows:?}");
    let errors = row("error of the corrected magnitude");
    let shown: Vec<f64> =
        errors.iter().map(|text| text.trim_end_matches(" µT").parse().expect("a number")).collect();
    let own = |log: &Path| number(&ironout(["fit", text(log), "--json"]).json()["rms_ut"]);
    assert!((shown[0] - own(&log)).abs() < 5.01e-4 && (shown[3] - own(&later)).abs() < 5.01e-4, "{shown:?}");
    assert!(shown[1] < 1.3 * shown[0] && shown[2] > 10.0 * shown[0], "{shown:?}");
    let offsets = row("offset x, µT");
    let of = |path: &Path| {
        let text = std::fs::read_to_string(path).expect("a calibration");
        let cal: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        format!("{:.3}", number(&cal["offset_ut"][0]))
    };
    assert_eq!((offsets[1].clone(), offsets[2].clone()), (of(&good), of(&wrong)), "{offsets:?}");
    for name in ["good.json", "wrong.json", "later.csv"] {
        assert!(
            seen["legends"].as_array().expect("legends").iter().any(|one| words(one).contains(name)),
            "{seen}"
        );
    }
    assert!(words(&seen["faults"]).contains("stuck"), "{seen}");
    assert!(number(&seen["shaded"][0]["to"]) > number(&seen["shaded"][0]["from"]), "{seen}");
    assert!(seen["links"].as_array().expect("links").contains(&json!("Side by side")), "{seen}");
}

/// Names of columns that would be markup or code, where a page took them for it; such as stay as they are when a log is read.
pub const HOSTILE: [&str; 4] =
    ["<img/src=x/onerror=injected=1>", "<script>injected=1</script>", "__proto__", "'-alert(1)-'"];

/// A log with them, and with such a name.
pub fn hostile(here: &Path) -> PathBuf {
    let log = simulate(here, "plain.csv", &["--seed", "3", "--seconds", "20"]);
    let content = std::fs::read_to_string(&log).expect("the log");
    let lines = content.lines().filter(|line| !line.starts_with('#'));
    let hostile: String = lines
        .enumerate()
        .map(|(row, line)| match row {
            0 => format!("{line},{}\n", HOSTILE.map(|name| format!("\"{name}\"")).join(",")),
            _ => format!("{line},{row},{},{},{}\n", row % 7, row % 11, row % 13),
        })
        .collect();
    write(
        here,
        "a<b onclick=alert(1)>.csv",
        format!("# </script><script>window.injected=1</script>\n{hostile}"),
    )
}

/// Nothing of them is markup, and all of them are to be read.
pub fn assert_text(seen: &serde_json::Value) {
    assert_eq!((&seen["injected"], &seen["marked"]), (&json!([]), &json!(false)), "{seen}");
    assert_eq!(seen["seen"], json!(HOSTILE));
    for name in HOSTILE {
        assert!(seen["columns"].as_array().is_some_and(|all| all.contains(&name.into())), "{name}: {seen}");
    }
}

#[test]
fn names_in_a_log_are_never_markup() {
    let Some(_turn) = turn("a hostile log") else { return };
    let here = folder("page-hostile");
    let log = hostile(&here);
    let file = here.join("report.html");
    let run = ironout(["report", text(&log), "-o", text(&file), "--no-search"]);
    assert!(run.status < 2, "{}", run.stderr);
    assert_text(&scenario("hostile", json!({"file": file, "names": HOSTILE})));
}

#[test]
fn a_long_log_stays_small() {
    let here = folder("page-long");
    let log = simulate(&here, "log.csv", &["--seed", "5", "--seconds", "1000", "--rate", "100"]);
    let file = here.join("report.html");
    let run = ironout(["report", text(&log), "-o", text(&file)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let bytes = std::fs::metadata(&file).expect("a report").len();
    assert!(bytes < 6_200_000, "{bytes}");
    // The module is most of it.
    assert!(ironout_web::module_bytes() <= 3_000_000, "{}", ironout_web::module_bytes());
}

#[test]
fn each_plot_is_a_file_of_its_own() {
    let here = folder("page-plots");
    let log =
        simulate(&here, "log.csv", &["--seed", "17", "--seconds", "30", "--effect", "offset:current_a=3"]);
    let plots = here.join("plots");
    let options = ["--add", "offset:current_a", "--no-search", "--plots", text(&plots)];
    let run = ironout(["report", text(&log)].iter().chain(&options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    let names: Vec<String> = std::fs::read_dir(&plots)
        .expect("a folder")
        .map(|entry| entry.expect("a file").file_name().into_string().expect("text"))
        .collect();
    for part in ["magnitude", "error", "dip", "heading", "current-a", "spectrum", "histogram", "sphere-xy"] {
        let name =
            names.iter().find(|name| name.contains(part)).unwrap_or_else(|| panic!("no {part}: {names:?}"));
        let svg = std::fs::read_to_string(plots.join(name)).expect("text");
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.len() > 2000, "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
}
