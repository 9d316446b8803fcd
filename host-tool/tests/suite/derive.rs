//! `--derive`: a hypothesis of one's own is a column, in the fit, in the diagnosis and in what is done with the calibration.

use crate::common::{folder, ironout, text, write};
use ironout_simulation::{World, WorldOptions};
use std::path::{Path, PathBuf};

/// A log with throttle and battery voltage in which `throttle^1.5*vbat` moves the offset; how strongly, in µT.
fn flight(here: &Path, name: &str, recording: u64, strength_ut: f64) -> PathBuf {
    let world =
        World::new(WorldOptions { seed: 21, seconds: 120.0, ..WorldOptions::default() }).recording(recording);
    let log = world.run();
    let column = |name: &str| log.column(name).expect("a column").to_vec();
    let time = column("t_s");
    let throttle: Vec<f64> =
        time.iter().map(|t| (0.45 + 0.14 * world.covariate("throttle", *t)).clamp(0.0, 1.0)).collect();
    let vbat: Vec<f64> = time.iter().map(|t| 15.2 + 0.8 * world.covariate("vbat", *t)).collect();
    let mut out = String::from("t_s,mx_ut,my_ut,mz_ut,throttle,vbat,temp_c\n");
    let axes = ["mx_ut", "my_ut", "mz_ut"].map(column);
    let temperature = column("temp_c");
    for row in 0..time.len() {
        let drive = throttle[row].powf(1.5) * vbat[row];
        let field = [0.5, -0.3, 0.8].map(|share| share * strength_ut * drive / 6.0);
        let cells: Vec<String> = [
            time[row],
            axes[0][row] + field[0],
            axes[1][row] + field[1],
            axes[2][row] + field[2],
            throttle[row],
            vbat[row],
            temperature[row],
        ]
        .iter()
        .map(|value| format!("{value:.5}"))
        .collect();
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    write(here, name, out)
}

const DRIVE: &str = "drive=throttle^1.5*vbat";

#[test]
fn a_hidden_effect_of_an_expression_is_found_named_first_and_corrected_without_being_told() {
    let here = folder("derive_flight");
    let log = flight(&here, "flight.csv", 1, 12.0);
    let found = ironout(["diagnose", text(&log), "--json", "--derive", DRIVE]).json();
    assert_eq!(found["verdict"], "missing", "{}", found["reasons"]);
    assert_eq!(found["steps"][1]["added"], "offset:drive", "{}", found["steps"]);
    assert_eq!(found["steps"].as_array().map(Vec::len), Some(2), "nothing besides: {}", found["steps"]);
    // The columns that are there explain it worse.
    let without = ironout(["diagnose", text(&log), "--json"]).json();
    let last = |object: &serde_json::Value| {
        object["steps"]
            .as_array()
            .and_then(|steps| steps.last()?["holdout_rms_ut"].as_f64())
            .expect("a number")
    };
    println!("held-out: {} with drive, {} without", last(&found), last(&without));
    assert!(last(&found) < last(&without));
    let cal = here.join("cal.json");
    let fit = ironout([
        "fit",
        text(&log),
        "--derive",
        DRIVE,
        "--derive",
        "half=throttle/2",
        "--add",
        "offset:drive",
        "-o",
        text(&cal),
    ]);
    assert_eq!(fit.status, 0, "{}{}", fit.stdout, fit.stderr);
    let kept: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("JSON");
    assert_eq!(
        kept["reading"]["derive"],
        serde_json::json!([DRIVE]),
        "what the calibration needs, and no more"
    );
    // Another flight: no flag.
    let second = flight(&here, "second.csv", 2, 12.0);
    let told = ironout(["apply", text(&second), "--cal", text(&cal), "--derive", DRIVE, "--json"]).json();
    let untold = ironout(["apply", text(&second), "--cal", text(&cal), "--json"]).json();
    assert_eq!(told, untold);
    let after = untold["after"]["rms_ut"].as_f64().expect("a number");
    let floor = found["residual_floor_ut"].as_f64().expect("a number");
    assert!(after < 1.3 * floor, "{after} against a floor of {floor}");
    let check = ironout(["check", text(&second), "--cal", text(&cal), "--json"]).json();
    assert_eq!(check["verdict"], "good", "{check}");
    // What it is computed from is not there.
    let renamed = std::fs::read_to_string(&second).expect("text").replacen("vbat", "volts", 1);
    let renamed = write(&here, "renamed.csv", renamed);
    let error = ironout(["apply", text(&renamed), "--cal", text(&cal), "--json"]).error();
    let message = error["message"].as_str().expect("words");
    assert!(
        message.contains(&format!("stored  --derive {DRIVE}")) && message.contains("there is no column vbat"),
        "{message}"
    );
    // Another meaning of the same name.
    let error =
        ironout(["apply", text(&second), "--cal", text(&cal), "--derive", "drive=throttle", "--json"])
            .error();
    assert!(error["message"].as_str().expect("words").contains("here drive=throttle"), "{error}");
    // A log that has the column.
    let with: String = std::fs::read_to_string(&second)
        .expect("text")
        .lines()
        .enumerate()
        .map(|(i, line)| {
            let cells: Vec<f64> = line.split(',').filter_map(|cell| cell.parse().ok()).collect();
            if i == 0 {
                format!("{line},drive\n")
            } else {
                format!("{line},{:.6}\n", cells[4].powf(1.5) * cells[5])
            }
        })
        .collect();
    let with =
        ironout(["apply", text(&write(&here, "with.csv", with)), "--cal", text(&cal), "--json"]).json();
    assert!((with["after"]["rms_ut"].as_f64().expect("a number") - after).abs() < 1e-3);
}

#[test]
fn wrong_expressions_name_what_is_near() {
    let here = folder("derive_wrong");
    let log = flight(&here, "flight.csv", 1, 0.0);
    for (expression, word) in [
        ("a=throtle*2", "Did you mean throttle?"),
        ("a=throttle*", "missing"),
        ("throttle=vbat", "Choose another name"),
        ("a", "NAME=EXPRESSION"),
        ("a=ln(-vbat)", "no row"),
    ] {
        for command in ["fit", "diagnose"] {
            let error = ironout([command, text(&log), "--json", "--derive", expression]).error();
            assert!(
                error["message"].as_str().is_some_and(|message| message.contains(word)),
                "{expression}: {error}"
            );
        }
    }
    let run = ironout(["fit", text(&log), "--derive", "a=ln(throttle-0.4)"]);
    assert!(run.status == 0 && run.said().contains("has no finite value in"), "{}", run.stderr);
}

/// What was fitted, whatever the columns are called in the file.
fn fitted(mut object: serde_json::Value) -> serde_json::Value {
    // How it was read, and the next commands, repeat the options.
    for key in ["read_as", "report"] {
        object.as_object_mut().expect("an object").remove(key).expect("every fit has it");
    }
    object
}

#[test]
fn a_sensor_in_another_unit_is_computed() {
    let here = folder("derive_sensor");
    let log = crate::common::simulate(&here, "log.csv", &["--seed", "4"]);
    let right = fitted(ironout(["fit", text(&log), "--json"]).json());
    let options = [
        "--map",
        "x=ax_mps2,y=ay_mps2,z=az_mps2",
        "--derive",
        "ax_mps2=x",
        "--derive",
        "ay_mps2=y*1",
        "--derive",
        "az_mps2=z+0",
    ];
    let computed = fitted(ironout(["fit", text(&log), "--json"].iter().chain(&options)).json());
    assert_eq!(computed, right);
}
