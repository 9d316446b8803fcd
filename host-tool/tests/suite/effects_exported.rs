//! Effects in files and exports: what is compiled of them corrects as the tool does.

use crate::common::{folder, ironout, simulate, text, write};
use ironout::effect::Bends;
use ironout_analysis::effects::of_library;
use ironout_analysis::{Corrector, Table};
use ironout_cli::cal_file::CalFile;
use ironout_cli::input::{ReadOptions, read_log};
use std::path::Path;
use std::process::Command;

/// One entry of a calibration file.
fn entry(
    id: &str,
    column: Option<(&str, f64)>,
    parameter: Option<(&str, f64)>,
    theta: &[f64],
) -> serde_json::Value {
    let object = |pair: Option<(&str, f64)>| {
        pair.map_or_else(|| serde_json::json!({}), |(name, value)| serde_json::json!({name: value}))
    };
    serde_json::json!({
        "id": id, "name": "", "columns": column.iter().map(|(name, _)| name).collect::<Vec<_>>(), "coefficients": theta,
        "std_errors": vec![1e-3; theta.len()], "unit": "", "reference": object(column), "parameters": object(parameter),
    })
}

/// The same entry, fitted over these values of its column.
fn over(mut entry: serde_json::Value, column: &str, ends: [f64; 2]) -> serde_json::Value {
    entry["range"] = serde_json::json!({column: ends});
    entry
}

/// The same entry, bending the field and not the reading.
fn of_field(mut entry: serde_json::Value) -> serde_json::Value {
    entry["bends"] = "field".into();
    entry
}

/// Calibrations that carry every effect there is between them.
fn every_effect() -> [Vec<serde_json::Value>; 5] {
    let (temp, amps) = (Some(("temp_c", 24.0)), Some(("current_a", 1.5)));
    [
        vec![
            entry("offset:temp_c", temp, None, &[0.4, -0.3, 0.2]),
            entry("gain:current_a", amps, None, &[1e-3, 2e-3, -1e-3]),
        ],
        vec![
            entry("lag", None, None, &[4e-3, 1e-3, -2e-3, 0.0, 3e-3, 1e-3, 2e-3, -1e-3, 5e-3]),
            entry("field:height_m", Some(("height_m", 0.2)), None, &[0.02]),
            over(entry("offset:current_a^2", amps, None, &[0.02, 0.01, -0.03]), "current_a", [0.1, 4.7]),
            over(
                entry("offset:current_a@delay", amps, Some(("delay_s", 0.31)), &[0.2, 0.1, -0.3]),
                "current_a",
                [0.1, 4.75],
            ),
        ],
        vec![
            entry("drift", Some(("t_s", 20.0)), None, &[0.03, -0.02, 0.01]),
            entry("step", None, Some(("at_s", 11.01)), &[1.0, 2.0, -1.0]),
            entry(
                "periodic",
                Some(("t_s", 1.0)),
                Some(("frequency_hz", 7.3)),
                &[0.5, 0.2, 0.1, -0.3, 0.4, 0.6],
            ),
        ],
        vec![
            entry("nonlinearity", None, None, &[1e-4, -2e-4, 1e-4, 1e-6, 2e-6, -1e-6]),
            entry("cross-axis", None, None, &[1e-4, 2e-4, -1e-4, 3e-4, -2e-4, 1e-4, 2e-4]),
            entry("lag", None, None, &[0.015]),
        ],
        // Strong ones.
        vec![
            of_field(entry("nonlinearity", None, None, &[1e-3, -2e-3, 1e-3, -2e-5, 1e-5, -1e-5])),
            of_field(entry("cross-axis", None, None, &[1e-3, -5e-4, 5e-4, 1e-3, -1e-3, 5e-4, 1e-3])),
            of_field(entry("gain:current_a", amps, None, &[0.02, -0.03, 0.01])),
            entry("offset:temp_c", temp, None, &[0.4, -0.3, 0.2]),
        ],
    ]
}

/// A calibration file with these effects.
fn file_with(effects: &[serde_json::Value]) -> String {
    let fixture = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/cal.json"));
    let mut file: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(fixture).expect("text")).expect("JSON");
    file["effects"] = effects.into();
    file["matrix"] = serde_json::json!([[1.01, 0.02, -0.03], [-0.01, 0.97, 0.1], [0.02, -0.04, 1.1]]);
    file.to_string()
}

#[test]
fn the_c_header_and_the_tool_correct_alike() {
    let here = folder("effects_c");
    let log_path = simulate(&here, "log.csv", &["--seconds", "20", "--seed", "9"]);
    let log = read_log(&log_path, &ReadOptions::default()).expect("a log");
    let table = Table::from(&log);
    let rows: Vec<usize> = (0..log.rows).step_by(37).collect();
    for (group, effects) in every_effect().iter().enumerate() {
        let cal = write(&here, "cal.json", file_with(effects));
        let file = CalFile::read(&cal).expect("a calibration");
        let corrector =
            Corrector::new(file.extended().expect("effects"), &table).expect("all columns are there");
        let run = ironout(["export", text(&cal), "--as", "c"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        write(&here, "calibration.h", &run.stdout);
        // The function's parameters, in the order of its declaration.
        let declaration = run.stdout.split("static inline void ironout_apply(").nth(1).expect("a function");
        let declared: Vec<&str> = declaration.split(')').next().expect("an end").split(',').collect();
        let mut calls = String::new();
        for &row in &rows {
            let conditions = corrector.conditions(row);
            let late = effects.iter().position(|effect| effect["id"] == "offset:current_a@delay");
            let list = |v: [f64; 3]| format!("{{{:?}, {:?}, {:?}}}", v[0], v[1], v[2]);
            let values: Vec<String> = declared[1..declared.len() - 1]
                .iter()
                .map(|parameter| match parameter.split_whitespace().last().expect("a name") {
                    "turn_radps[3]" => "turn".to_string(),
                    "t_s" => format!("{:?}", log.time_s.as_ref().expect("time")[row]),
                    "current_a_late" => format!("{:?}", conditions.inputs[late.expect("late")][0]),
                    name => {
                        format!("{:?}", log.covariate(name).unwrap_or_else(|| panic!("{name}")).values[row])
                    }
                })
                .collect();
            let turn = log.gyro_radps.as_ref().expect("a gyro").each_ref().map(|axis| axis[row]);
            calls.push_str(&format!(
                "    {{ double v[3] = {}; double turn[3] = {}; (void)turn; ironout_apply(v, {}v); printf(\"%.9f %.9f %.9f\\n\", \
                 v[0], v[1], v[2]); }}\n",
                list(log.field(row)),
                list(turn),
                values.iter().map(|value| format!("{value}, ")).collect::<String>()
            ));
        }
        if Command::new("cc").arg("--version").output().is_err() {
            use std::io::Write;
            let _ = writeln!(std::io::stderr(), "SKIPPED: no C compiler here");
            return;
        }
        let main = format!(
            "#define IRONOUT_REAL double\n#include <stdio.h>\n#include \"calibration.h\"\nint main(void)\n{{\n{calls}    return 0;\n}}\n"
        );
        let source = write(&here, "main.c", main);
        let program = here.join("main");
        let flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic"];
        let out = Command::new("cc").args(flags).args(["-o", text(&program), text(&source), "-lm"]).output();
        let out = out.expect("cc runs");
        assert!(out.status.success(), "{}\n{}", String::from_utf8_lossy(&out.stderr), run.stdout);
        // In single precision too, as firmware compiles it.
        let single = write(&here, "single.c", "#include \"calibration.h\"\nint main(void) { return 0; }\n");
        let out = Command::new("cc")
            .args(flags)
            .args(["-Wno-unused-function", "-c", "-o", text(&here.join("single.o")), text(&single)])
            .output()
            .expect("cc runs");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let printed = Command::new(&program).output().expect("the program runs").stdout;
        let printed = String::from_utf8_lossy(&printed).into_owned();
        assert_eq!(printed.lines().count(), rows.len());
        for (&row, line) in rows.iter().zip(printed.lines()) {
            let there: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
            let here = corrector.correct(row).expect("corrected");
            for axis in 0..3 {
                assert!(
                    (there[axis] - here[axis]).abs() < 1e-6,
                    "group {group} row {row}: {there:?} {here:?}"
                );
            }
        }
    }
}

/// What `export --as rust` wrote: compiled here against the crate.
mod exported {
    include!("../fixtures/exported_effects.rs");
}

#[test]
fn what_bends_the_field_does_so_in_rust_too() {
    let here = folder("effects_rust_field");
    let cal = write(&here, "cal.json", file_with(&every_effect()[4]));
    let run = ironout(["export", text(&cal), "--as", "rust"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert_eq!(run.stdout.matches(").bending(Bends::Field)),").count(), 2 * 3, "{}", run.stdout);
    assert!(run.stdout.contains("Bends"), "imported");
    // In a board's record too, and back.
    let file = CalFile::read(&cal).expect("a calibration");
    let sent = of_library(&file.extended().expect("effects")).expect("the library's");
    assert_eq!(sent.effects.iter().filter(|one| one.bends == Bends::Field).count(), 3);
}

#[test]
fn the_rust_constants_with_effects_run_live_as_the_tool_corrects() {
    let here = folder("effects_rust");
    let cal = write(&here, "cal.json", file_with(&every_effect()[1]));
    let run = ironout(["export", text(&cal), "--as", "rust"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let fixture = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/exported_effects.rs"));
    let included = std::fs::read_to_string(fixture).expect("text");
    assert_eq!(run.stdout, included, "export changed: write it anew to tests/fixtures/exported_effects.rs");

    let log_path = simulate(&here, "log.csv", &["--seconds", "20", "--seed", "10"]);
    let log = read_log(&log_path, &ReadOptions::default()).expect("a log");
    let table = Table::from(&log);
    let file = CalFile::read(&cal).expect("a calibration");
    let corrector = Corrector::new(file.extended().expect("effects"), &table).expect("all columns are there");
    assert_eq!(of_library(corrector.calibration()), Some(exported::CALIBRATION_F64));
    // On the board: columns fed as they come, the late one kept in the board's own delay line, all in single precision.
    let mut live = ironout::extended::Live::new(&exported::CALIBRATION).expect("it can run");
    let slots = ["current_a", "height_m"].map(|name| live.slots(name));
    let gyro = log.gyro_radps.as_ref().expect("a gyro");
    let time = log.time_s.as_ref().expect("time");
    let (mut compared, mut worst) = (0, 0.0_f64);
    for row in 0..log.rows {
        for (slots, name) in slots.iter().zip(["current_a", "height_m"]) {
            live.set_slots(*slots, log.covariate(name).expect("the column").values[row] as f32);
        }
        live.advance(time[row]);
        let turn = gyro.each_ref().map(|axis| axis[row] as f32);
        let Ok(board) = live.apply(log.field(row).map(|v| v as f32), Some(turn)) else {
            assert!(time[row] < 0.35, "row {row}: {:?}", live.waits_for());
            continue;
        };
        let here = corrector.correct(row).expect("corrected");
        for axis in 0..3 {
            worst = worst.max((f64::from(board[axis]) - here[axis]).abs());
        }
        compared += 1;
    }
    assert!(compared > 900 && worst < 0.02, "{compared} rows, {worst} µT");
    // The board knows the range of each column that the file says, and the height's is not known.
    live.set("height_m", 1e6);
    for (current_a, outside) in [(0.1, false), (4.7, false), (4.71, true), (0.09, true)] {
        live.set("current_a", current_a);
        let now: Vec<(usize, &str)> =
            live.outside().filter(|one| one.effect != 3).map(|one| (one.effect, one.column)).collect();
        assert_eq!(now, if outside { vec![(2, "current_a")] } else { vec![] }, "{current_a}");
    }
}
