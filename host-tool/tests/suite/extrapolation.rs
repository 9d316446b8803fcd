//! What a calibration says beyond what it was fitted over: effects that the log does not show, and readings outside the
//! range of a column.

use crate::common::{folder, ironout, write};
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

fn simulate(here: &Path, name: &str, options: &[&str]) -> PathBuf {
    let log = here.join(name);
    let run = ironout(["simulate", "-o", text(&log)].iter().chain(options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    log
}

/// The values of a column, and the log with another column of that name.
fn shifted(here: &Path, log: &Path, name: &str, column: &str, by: f64) -> (Vec<f64>, PathBuf) {
    let content = std::fs::read_to_string(log).expect("text");
    let mut lines = content.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header");
    let place = header.split(',').position(|word| word == column).expect("the column");
    let mut values = Vec::new();
    let rows: Vec<String> = lines
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(String::from).collect();
            let value: f64 = cells[place].parse().expect("a number");
            values.push(value);
            cells[place] = format!("{:.5}", value + by);
            cells.join(",")
        })
        .collect();
    (values, write(here, name, format!("{header}\n{}\n", rows.join("\n"))))
}

#[test]
fn an_effect_that_the_log_does_not_show_is_refused_unless_it_is_forced() {
    let here = folder("not_shown");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "3"]);
    let cal = here.join("cal.json");
    let fit = ["fit", text(&log), "--add", "offset:height_m", "-o", text(&cal), "--json"];
    let run = ironout(fit);
    let reasons = run.json()["reasons"].to_string();
    assert_eq!((run.status, &run.json()["accepted"]), (1, &json!(false)), "{}", run.stdout);
    for words in ["No evidence for offset:height_m", "held-out error", "--force-effect", "Drop it"] {
        assert!(reasons.contains(words), "no {words:?} in {reasons}");
    }
    assert!(!cal.exists());
    let run = ironout(fit.iter().chain(&["--force-effect"]));
    assert_eq!(run.status, 0, "{}", run.stdout);
    assert!(run.json()["reasons"].to_string().contains("kept because of --force-effect"), "{}", run.stdout);
    assert!(cal.exists());
    let run = ironout(["fit", text(&log), "--force-effect", "--json"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
}

#[test]
fn readings_outside_the_range_of_the_fit_are_told() {
    let here = folder("extrapolated");
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "21", "--effect", "offset:temp_c=6"]);
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&log), "--add", "offset:temp_c", "-o", text(&cal), "--json"]);
    assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
    let (values, hot) = shifted(&here, &log, "hot.csv", "temp_c", 30.0);
    let ends = [
        values.iter().copied().fold(f64::INFINITY, f64::min),
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ];
    assert_eq!(run.json()["effects"][0]["range"], json!({"temp_c": ends}));

    let inside = ironout(["apply", text(&log), "--cal", text(&cal), "--json"]).json();
    assert_eq!((&inside["outside"], &inside["range_unknown"]), (&json!([]), &json!([])));
    for command in ["apply", "check"] {
        let told = ironout([command, text(&hot), "--cal", text(&cal), "--json"]).json();
        let one = &told["outside"][0];
        assert_eq!((one["column"].as_str(), one["effect"].as_str()), (Some("temp_c"), Some("offset:temp_c")));
        assert_eq!((&one["rows"], &one["range"]), (&json!(values.len()), &json!(ends)), "{one}");
        let number = |key: &str| one[key].as_f64().unwrap_or_else(|| panic!("no {key} in {one}"));
        assert!((number("furthest") - ends[1] - 30.0).abs() < 1e-4, "{one}");
        // What the offset would change by over 30 °C less the width of the range, with what the coefficients' own errors make.
        let held = 30.0 - (ends[1] - ends[0]);
        let coefficients = run.json()["effects"][0]["coefficients"].clone();
        let per_degree: f64 =
            (0..3).map(|axis| coefficients[axis].as_f64().expect("a number").powi(2)).sum::<f64>().sqrt();
        assert!((number("error_ut") / (held * per_degree) - 1.0).abs() < 0.2, "{one}");
        assert!(number("error_at_range_ut") < 0.1, "{one}");
        let words = ironout([command, text(&hot), "--cal", text(&cal)]).stdout;
        assert!(
            words.contains("at most the width of the range") && words.contains("temp_c outside"),
            "{words}"
        );
    }

    // A file of an earlier program does not say the range.
    let content = std::fs::read_to_string(&cal).expect("text");
    let mut older: Value = serde_json::from_str(&content).expect("JSON");
    older["effects"][0].as_object_mut().expect("an object").remove("range");
    let older = write(&here, "older.json", older.to_string());
    let told = ironout(["apply", text(&hot), "--cal", text(&older), "--json"]).json();
    assert_eq!((&told["outside"], &told["range_unknown"]), (&json!([]), &json!(["offset:temp_c"])));
    assert!(
        ironout(["check", text(&hot), "--cal", text(&older)]).stdout.contains("does not state the range")
    );
    let mut wrong: Value = serde_json::from_str(&content).expect("JSON");
    wrong["effects"][0]["range"]["temp_c"] = json!([2.0, 1.0]);
    let wrong = write(&here, "wrong.json", wrong.to_string());
    let error = ironout(["apply", text(&hot), "--cal", text(&wrong), "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|words| words.contains("range of temp_c")), "{error}");
}

#[test]
fn exports_say_what_lies_outside() {
    let here = folder("exported_ranges");
    let cal = calibration_with_a_range(&here);
    let rust = ironout(["export", text(&cal), "--as", "rust"]).stdout;
    assert!(rust.contains("(\"temp_c\", 0.0, [20.0, 30.0])") && rust.contains("pub fn is_outside"), "{rust}");
    let header = here.join("calibration.h");
    let run = ironout(["export", text(&cal), "--as", "c", "-o", text(&header)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    if Command::new("cc").arg("--version").output().is_err() {
        // libtest hides what eprintln! says.
        let _ = writeln!(std::io::stderr(), "skipped: no C compiler");
        return;
    }
    let program = "#include <stdio.h>\n#include \"calibration.h\"\nint main(void) {\n    float m[3] = {1, 2, 3}, c[3], d[3];\n    \
                   ironout_apply(m, 25.0f, c);\n    printf(\"%u %u %u %u\", ironout_outside(25.0f), ironout_outside(30.0f), \
                   ironout_outside(30.5f), ironout_outside(19.0f));\n    \
                   ironout_apply(m, 40.0f, c);\n    ironout_apply(m, 90.0f, d);\n    printf(\" %d\", c[0] == d[0] && c[1] == d[1] && c[2] == d[2]);\n    return 0;\n}\n";
    let source = write(&here, "main.c", program);
    let binary = here.join("main");
    let flags =
        ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-o", text(&binary), text(&source), "-lm"];
    let out = Command::new("cc").args(flags).output().expect("cc runs");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let out = Command::new(&binary).output().expect("it runs");
    assert_eq!(String::from_utf8_lossy(&out.stdout), "0 0 1 1 1");
}

/// The project's example of a calibration with a offset proportional to temperature, fitted over 20 to 30 °C.
fn calibration_with_a_range(here: &Path) -> PathBuf {
    let fixture = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/cal.json"));
    let content = std::fs::read_to_string(fixture).expect("text");
    let mut cal: Value = serde_json::from_str(&content).expect("JSON");
    cal["effects"] = json!([{
        "id": "offset:temp_c", "name": "offset proportional to temperature", "columns": ["temp_c"], "coefficients": [0.1, 0.2, 0.3],
        "std_errors": [0.01, 0.01, 0.01], "unit": "µT/°C", "reference": {"temp_c": 25.0}, "parameters": {},
        "range": {"temp_c": [20.0, 30.0]},
    }]);
    write(here, "cal.json", cal.to_string())
}
