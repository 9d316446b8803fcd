//! The contracts of the command line: keys, exit statuses, files that round-trip, exports that compile.

use crate::common::{Run, folder, ironout, write};
use std::path::{Path, PathBuf};
use std::process::Command;

const FIT_KEYS: [&str; 19] = [
    "method",
    "samples_used",
    "samples_set_aside",
    "field_ut",
    "offset_ut",
    "matrix",
    "effects",
    "std_errors",
    "rms_ut",
    "holdout_rms_ut",
    "noise_floor_ut",
    "residual_floor_ut",
    "residual_floor_least_ut",
    "heading_error_deg",
    "predicted_error_ut",
    "coverage",
    "gap_deg",
    "accepted",
    "reasons",
];

fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

fn simulate(here: &Path, name: &str, options: &[&str]) -> PathBuf {
    let log = here.join(name);
    let run = ironout(["simulate", "-o", text(&log)].iter().chain(options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    log
}

fn calibrated(here: &Path, log: &Path) -> PathBuf {
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(log), "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
    cal
}

fn truth(log: &Path, key: &str) -> Vec<f64> {
    let content = std::fs::read_to_string(log).expect("text");
    let line =
        content.lines().find_map(|line| line.strip_prefix("# ")?.strip_prefix(key)).expect("the truth");
    line.trim_start_matches([' ', '=']).split(',').filter_map(|word| word.trim().parse().ok()).collect()
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

#[test]
fn fit_prints_every_key_and_finds_the_truth() {
    let here = folder("fit_keys");
    let log = simulate(&here, "log.csv", &["--seed", "11"]);
    let run = ironout(["fit", text(&log), "--field", "50", "--json"]);
    assert_eq!(run.status, 0);
    let object = run.json();
    let mut keys: Vec<&str> = object.as_object().expect("an object").keys().map(String::as_str).collect();
    let mut expected =
        [FIT_KEYS.as_slice(), &["input", "notes", "read_as", "reason_codes", "report", "version"]].concat();
    keys.sort_unstable();
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!(object["accepted"], true);
    assert_eq!(number(&object["field_ut"]), 50.0);
    assert_eq!(object["effects"], serde_json::json!([]));
    for (axis, truth) in truth(&log, "offset_ut").into_iter().enumerate() {
        let error = number(&object["offset_ut"][axis]) - truth;
        let sigma = number(&object["std_errors"]["offset_ut"][axis]);
        assert!(error.abs() < 4.0 * sigma && sigma < 0.1, "axis {axis}: {error} ± {sigma}");
    }
    // With an accelerometer the whole matrix is known, not only a triangle of it: it undoes the true one.
    let soft: Vec<Vec<f64>> = (0..3).map(|row| truth(&log, &format!("soft_iron[{row}]"))).collect();
    for row in 0..3 {
        for column in 0..3 {
            let product: f64 = (0..3).map(|k| number(&object["matrix"][row][k]) * soft[k][column]).sum();
            assert!((product - f64::from(u8::from(row == column))).abs() < 0.02, "{row} {column}: {product}");
        }
    }
    // White noise: every way to the floor agrees.
    let (rms, floor) = (number(&object["rms_ut"]), number(&object["residual_floor_ut"]));
    assert!((rms / floor - 1.0).abs() < 0.05, "{rms} {floor}");
    assert!((number(&object["holdout_rms_ut"]) / floor - 1.0).abs() < 0.05);
    let noise = number(&object["noise_floor_ut"]);
    assert!((noise / 0.2517 - 1.0).abs() < 0.05, "{noise}");
    assert!(number(&object["coverage"]) > 0.8 && number(&object["gap_deg"]) < 60.0);
}

#[test]
fn without_an_accelerometer_the_matrix_is_triangular() {
    let here = folder("triangular");
    let without = ["ax_mps2", "ay_mps2", "az_mps2"].map(|name| ["--without", name]).concat();
    let log = simulate(&here, "log.csv", &without);
    let object = ironout(["fit", text(&log), "--json"]).json();
    for (row, column) in [(1, 0), (2, 0), (2, 1)] {
        assert_eq!(number(&object["matrix"][row][column]), 0.0);
        assert_eq!(number(&object["std_errors"]["matrix"][row][column]), 0.0);
    }
    assert!((0..3).all(|i| number(&object["matrix"][i][i]) > 0.0));
    assert!(object["heading_error_deg"].is_null(), "the dip is not known");
}

#[test]
fn at_a_place_the_field_comes_from_the_world_model_and_the_heading_error_is_known() {
    let here = folder("at");
    let log = simulate(&here, "log.csv", &[]);
    let object = ironout(["fit", text(&log), "--at", "52.52,13.40,2026-03-01", "--json"]).json();
    assert!((number(&object["field_ut"]) - 50.1).abs() < 1.0, "{object}");
    let degrees = number(&object["heading_error_deg"]);
    assert!((0.1..2.0).contains(&degrees), "{degrees}");
}

#[test]
fn a_refused_fit_prints_its_object_and_never_touches_a_good_file() {
    let here = folder("refused");
    let log = simulate(&here, "log.csv", &[]);
    let cal = calibrated(&here, &log);
    let before = std::fs::read(&cal).expect("the calibration");
    // A board that lies on the table: one direction.
    let mut rest = String::from("t_s,mx_ut,my_ut,mz_ut\n");
    for i in 0..500 {
        rest.push_str(&format!(
            "{},{},{},{}\n",
            i as f64 * 0.02,
            20.0 + (i % 3) as f64 * 0.1,
            -5 + i % 2,
            40
        ));
    }
    let rest = write(&here, "rest.csv", rest);
    let run = ironout(["fit", text(&rest), "-o", text(&cal), "--json"]);
    assert_eq!(run.status, 1);
    let object = run.json();
    assert_eq!(object["accepted"], false);
    assert!(object["offset_ut"].is_null() && object["matrix"].is_null());
    assert!(object["reasons"][0].as_str().is_some_and(|reason| reason.len() > 20), "{object}");
    assert!(run.said().contains("is unchanged"), "{}", run.stderr);
    assert_eq!(std::fs::read(&cal).expect("the calibration"), before);
    let new = here.join("new.json");
    assert_eq!(ironout(["fit", text(&rest), "-o", text(&new)]).status, 1);
    assert!(!new.exists());
    let names: Vec<_> = std::fs::read_dir(&here).expect("the folder").collect();
    assert_eq!(names.len(), 3, "no file left over: {names:?}");
}

#[test]
fn the_calibration_file_is_the_object_with_version_and_information() {
    let here = folder("cal_file");
    let log = simulate(&here, "log.csv", &[]);
    let cal = calibrated(&here, &log);
    let file: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("JSON");
    let object = ironout(["fit", text(&log), "--json"]).json();
    for key in FIT_KEYS {
        assert_eq!(file[key], object[key], "{key}");
    }
    assert_eq!(file["version"], 1);
    assert_eq!(file["information"]["matrix"].as_array().map(Vec::len), Some(9));
    // Exported as JSON it is the same file.
    let again = ironout(["export", text(&cal), "--as", "json"]);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&again.stdout).expect("JSON"), file);
}

#[test]
fn apply_lowers_the_error_and_keeps_every_column() {
    let here = folder("apply");
    let log = simulate(&here, "log.csv", &["--seed", "5"]);
    let cal = calibrated(&here, &log);
    let out = here.join("out.csv");
    let object = ironout(["apply", text(&log), "--cal", text(&cal), "-o", text(&out), "--json"]).json();
    assert!(
        number(&object["before"]["rms_percent"]) > 5.0 * number(&object["after"]["rms_percent"]),
        "{object}"
    );
    let (old, new) =
        (std::fs::read_to_string(&log).expect("text"), std::fs::read_to_string(&out).expect("text"));
    assert_eq!(old.lines().count(), new.lines().count());
    for (old, new) in old.lines().zip(new.lines()) {
        assert!(new.starts_with(old), "{new}");
    }
    let header = new.lines().find(|line| !line.starts_with('#')).expect("a header");
    assert!(header.ends_with(",cx_ut,cy_ut,cz_ut,norm_ut,residual_ut"), "{header}");
    // The corrected columns are themselves a log: with nothing left to correct.
    let map = "mx_ut=cx_ut,my_ut=cy_ut,mz_ut=cz_ut";
    let second: Vec<String> = new
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            line.split(',')
                .rev()
                .take(5)
                .collect::<Vec<_>>()
                .into_iter()
                .rev()
                .take(3)
                .collect::<Vec<_>>()
                .join(",")
        })
        .collect();
    let second = write(&here, "second.csv", second.join("\n"));
    let fitted = ironout(["fit", text(&second), "--map", map, "--json"]).json();
    for axis in 0..3 {
        assert!(number(&fitted["offset_ut"][axis]).abs() < 0.05, "{fitted}");
    }
    // Neither the log itself nor a log that was corrected before.
    assert_eq!(ironout(["apply", text(&log), "--cal", text(&cal), "-o", text(&log)]).status, 2);
    let run = ironout(["apply", text(&out), "--cal", text(&cal), "-o", text(&here.join("x.csv")), "--json"]);
    assert_eq!(run.error()["column"], "cx_ut");
}

fn shifted(log: &Path, here: &Path, shift: [f64; 3]) -> PathBuf {
    let content = std::fs::read_to_string(log).expect("text");
    let lines: Vec<String> = content
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(String::from).collect();
            if line.starts_with(|c: char| c.is_ascii_digit()) {
                for (cell, shift) in cells[1..4].iter_mut().zip(shift) {
                    *cell = format!("{:.4}", cell.parse::<f64>().expect("a number") + shift);
                }
            }
            cells.join(",")
        })
        .collect();
    write(here, "shifted.csv", lines.join("\n"))
}

#[test]
fn check_says_good_and_says_where_the_offset_went() {
    let here = folder("check");
    let log = simulate(&here, "log.csv", &["--seed", "3"]);
    let cal = calibrated(&here, &log);
    let later = simulate(&here, "later.csv", &["--seed", "3", "--seconds", "90"]);
    let run = ironout(["check", text(&later), "--cal", text(&cal), "--json"]);
    assert_eq!((run.status, run.json()["verdict"].as_str().map(String::from)), (0, Some("good".into())));

    let magnet = shifted(&later, &here, [4.0, -2.0, 1.0]);
    let run = ironout(["check", text(&magnet), "--cal", text(&cal), "--json"]);
    let object = run.json();
    assert_eq!((run.status, object["verdict"].as_str()), (1, Some("moved")), "{object}");
    for (axis, expected) in [4.0, -2.0, 1.0].into_iter().enumerate() {
        assert!((number(&object["offset_shift_ut"][axis]) - expected).abs() < 0.3, "{object}");
    }
    let other = simulate(&here, "other.csv", &["--seed", "4"]);
    assert_eq!(ironout(["check", text(&other), "--cal", text(&cal)]).status, 1);
}

#[test]
fn the_same_seed_gives_the_same_log() {
    let here = folder("seeds");
    let read = |name: &str, options: &[&str]| std::fs::read(simulate(&here, name, options)).expect("a log");
    let effect = ["--seed", "9", "--effect", "offset:temp_c=3", "--effect", "burst"];
    assert_eq!(read("a.csv", &effect), read("b.csv", &effect));
    assert_ne!(read("a.csv", &["--seed", "9"]), read("b.csv", &["--seed", "10"]));
}

#[test]
fn counts_axes_and_headers_of_others_come_to_the_same_calibration() {
    let here = folder("others");
    let log = simulate(&here, "log.csv", &["--seed", "8"]);
    let content = std::fs::read_to_string(&log).expect("text");
    let reference = ironout(["fit", text(&log), "--json"]).json();
    // 0.1 µT a count, sensor mounted with x back and y left, other names, Windows line ends, time in µs.
    let mut other = String::from("\u{feff}\"micros\",MagX,MagY,MagZ,note\r\n");
    for line in content.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let counts = [-cells[1], -cells[2], cells[3]].map(|v| (v * 10.0).round());
        other.push_str(&format!(
            "{},{},{},{},ok\r\n",
            (cells[0] * 1e6).round(),
            counts[0],
            counts[1],
            counts[2]
        ));
    }
    let other = write(&here, "other.csv", other);
    let run = ironout([
        "fit",
        text(&other),
        "--json",
        "--map",
        "t_us=micros,mx_counts=MagX,my_counts=MagY",
        "--map",
        "mz_counts=MagZ",
        "--ut-per-count",
        "0.1",
        "--rotate",
        "yaw180",
    ]);
    assert!(run.said().contains("ignored column note"), "{}", run.stderr);
    let object = run.json();
    for axis in 0..3 {
        let (a, b) = (number(&object["offset_ut"][axis]), number(&reference["offset_ut"][axis]));
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
}

fn compiles(run: &Run, name: &str, here: &Path) -> PathBuf {
    assert_eq!(run.status, 0, "{}", run.stderr);
    write(here, name, &run.stdout)
}

#[test]
fn the_c_header_compiles_without_a_warning_and_corrects() {
    let here = folder("export_c");
    let log = simulate(&here, "log.csv", &[]);
    let cal = calibrated(&here, &log);
    compiles(&ironout(["export", text(&cal), "--as", "c"]), "calibration.h", &here);
    if Command::new("cc").arg("--version").output().is_err() {
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), "SKIPPED: no C compiler here");
        return;
    }
    let file: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("JSON");
    let main = "#include <stdio.h>\n#include \"calibration.h\"\nint main(void)\n{\n    float v[3] = {10.0f, -20.0f, 30.0f};\n    \
                ironout_apply(v, v);\n    printf(\"%.5f %.5f %.5f %.3f\\n\", (double)v[0], (double)v[1], (double)v[2], \
                (double)IRONOUT_FIELD_UT);\n    return 0;\n}\n";
    let source = write(&here, "main.c", main);
    let program = here.join("main");
    let out = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-o", text(&program), text(&source)])
        .output()
        .expect("cc runs");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let printed = Command::new(&program).output().expect("the program runs").stdout;
    let printed: Vec<f64> = String::from_utf8_lossy(&printed)
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    let measured = [10.0, -20.0, 30.0];
    for row in 0..3 {
        let expected: f64 = (0..3)
            .map(|i| number(&file["matrix"][row][i]) * (measured[i] - number(&file["offset_ut"][i])))
            .sum();
        assert!((printed[row] - expected).abs() < 1e-3, "{printed:?} {expected}");
    }
}

/// What `export --as rust` wrote: compiled here against the crate.
mod exported {
    include!("../fixtures/exported.rs");
}

#[test]
fn the_rust_constants_compile_against_the_crate_and_correct() {
    let fixtures = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures"));
    let run = ironout(["export", text(&fixtures.join("cal.json")), "--as", "rust"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let included = std::fs::read_to_string(fixtures.join("exported.rs")).expect("text");
    assert_eq!(run.stdout, included, "export changed: write it anew to tests/fixtures/exported.rs");
    let file: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(fixtures.join("cal.json")).expect("text"))
            .expect("JSON");
    let measured = [10.0, -20.0, 30.0];
    let corrected = exported::CALIBRATION_F64.apply(measured);
    let single = exported::CALIBRATION.apply(measured.map(|v| v as f32));
    for row in 0..3 {
        let expected: f64 = (0..3)
            .map(|i| number(&file["matrix"][row][i]) * (measured[i] - number(&file["offset_ut"][i])))
            .sum();
        assert!((corrected[row] - expected).abs() < 1e-12);
        assert!((f64::from(single[row]) - expected).abs() < 1e-4);
    }
}

#[cfg(not(feature = "demo"))]
#[test]
fn a_program_without_the_board_says_where_the_demo_is() {
    let run = ironout(["demo", "--json"]);
    let message = run.error()["message"].to_string();
    assert!(message.contains("cargo ironout demo") && message.contains("--features demo"), "{message}");
}
