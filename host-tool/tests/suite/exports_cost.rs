//! What a target does not hold of a calibration is said, and with the log what that costs; what cannot be written is refused.

use crate::common::target::*;
use crate::common::{folder, ironout, simulate, text, write};
use ironout_cli::cal_file::CalFile;
use serde_json::{Value, json};
use std::collections::BTreeMap;

#[test]
fn what_is_lost_is_said_and_with_the_log_what_it_costs() {
    let here = folder("exports_cost");
    let log = simulate(
        &here,
        "log.csv",
        &["--seconds", "40", "--seed", "3", "--effect", "offset:current_a=6", "--effect", "offset:temp_c=4"],
    );
    let cal = here.join("cal.json");
    let fit = ["fit", text(&log), "-o", text(&cal), "--add", "offset:current_a", "--add", "offset:temp_c"];
    assert_eq!(ironout(fit).status, 0);
    let truth = Truth::of(&cal, &log);
    let field_ut = CalFile::read(&cal).expect("a calibration").fit.field_ut.expect("a field");
    let with = |form: &str, more: &[&str]| {
        let run = ironout(["export", text(&cal), "--as", form, "--json"].iter().chain(more));
        assert_eq!(run.status, 0, "{}", run.stderr);
        run.json()
    };
    let rms = |p: &BTreeMap<String, f64>| {
        let squares: f64 = (0..truth.raw.rows)
            .map(|row| {
                (norm(ardupilot_corrects(p, "", truth.raw.field(row), &truth, row)) - field_ut).powi(2)
            })
            .sum();
        (squares / truth.raw.rows as f64).sqrt()
    };
    // ArduPilot has no temperature: without the log that is said, with it the rest is fitted anew.
    let blind = with("ardupilot", &[]);
    assert!(blind["cost"].is_null() && blind["fitted_anew"] == false, "{blind}");
    assert!(blind["not_held"].to_string().contains("offset:temp_c"), "{blind}");
    assert!(
        blind["text"].as_str().is_some_and(|text| text.contains("To print the error of these parameters"))
    );
    let seen = with("ardupilot", &["--log", text(&log)]);
    let cost = &seen["cost"];
    let (whole, held) = (cost["rms_ut"].as_f64().expect("rms"), cost["held_rms_ut"].as_f64().expect("rms"));
    assert!(seen["fitted_anew"] == true && held > 2.0 * whole, "{cost}");
    let [before, after] = [&blind, &seen].map(|one| ardupilot(one["text"].as_str().expect("a file")));
    // The error that is printed is that of the file, and no better one is near it.
    assert!((rms(&after) - held).abs() < 2e-3 * held, "{} against {held}", rms(&after));
    assert!(rms(&after) < rms(&before), "{} against {}", rms(&after), rms(&before));
    for (name, step) in
        [("COMPASS_OFS_X", 2.0), ("COMPASS_DIA_Y", 0.004), ("COMPASS_ODI_Z", 0.004), ("COMPASS_MOT_Y", 0.5)]
    {
        for sign in [-1.0, 1.0] {
            let mut moved = after.clone();
            *moved.get_mut(name).expect(name) += sign * step;
            assert!(rms(&moved) > rms(&after), "{name} by {}", sign * step);
        }
    }
    // The less a target holds, the more it costs; and what holds the magnitude loses nothing of it.
    let costs = ["px4", "ardupilot", "betaflight"].map(|form| {
        let scale: &[&str] = if form == "betaflight" { &["--ut-per-count", "0.1"] } else { &[] };
        let run = with(form, &[&["--log", text(&log)], scale].concat());
        run["cost"]["held_rms_ut"].as_f64().expect("an error")
    });
    assert!((costs[0] - whole).abs() < 1e-6 && costs[1] > whole && costs[2] > costs[1], "{costs:?}");
    let heading = &with("px4", &["--log", text(&log)])["cost"]["heading"];
    let between = heading["between_deg"].as_f64().expect("an angle");
    assert!(between > 0.5, "the rotation that is lost shows in the heading: {heading}");
    assert!(heading["held_error_deg"].as_f64() > heading["error_deg"].as_f64(), "{heading}");
}

#[test]
fn what_cannot_be_written_is_refused_with_the_remedy() {
    let here = folder("exports_refused");
    let plain = cal(&here, &SYMMETRIC, &[], reading(&[]));
    let message = |options: &[&str]| {
        let run = ironout(["export", text(&plain), "--json"].iter().chain(options));
        run.error()["message"].as_str().expect("text").to_string()
    };
    assert!(message(&["--as", "px4", "--number", "4"]).contains("from 0 to 3"));
    assert!(message(&["--as", "ardupilot", "--number", "0"]).contains("from 1 to 3"));
    assert!(message(&["--as", "rust", "--number", "1"]).contains("--number has no effect with --as rust"));
    assert!(message(&["--as", "ros", "--device-id", "1"]).contains("Omit it"));
    assert!(message(&["--as", "ros", "--euler"]).contains("--euler has no effect"));
    assert!(message(&["--as", "iio"]).contains("--ut-per-count"));
    assert!(message(&["--as", "iio", "--ut-per-count", "-1"]).contains("positive"));
    assert!(message(&["--as", "px4", "--log", "nothing.csv"]).contains("no such file"));
    let short = log(&here);
    assert!(message(&["--as", "px4", "--log", text(&short)]).contains("too few samples"));
    let mirrored = cal(&here, &SYMMETRIC, &[], reading(&["mag:-x,y,z"]));
    let error = ironout(["export", text(&mirrored), "--as", "px4", "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|text| text.contains("mirror")), "{error}");
    let needs =
        cal(&here, &SYMMETRIC, &[offset("offset:load_a", "load_a", 1.0, [0.1; 3], [0.0, 2.0])], reading(&[]));
    let run = ironout(["export", text(&needs), "--as", "px4", "--log", text(&short), "--json"]);
    assert_eq!(run.error()["column"], "load_a");
}

#[test]
fn of_two_currents_the_one_that_moves_more_is_held() {
    let here = folder("exports_two");
    let log = log(&here);
    let effects = [
        offset("offset:motor_a", "motor_a", 4.0, [0.01, 0.02, 0.0], [0.0, 12.0]),
        offset("offset:current_a", "current_a", 9.0, [0.31, -0.12, 0.07], [0.0, 30.0]),
        json!({
            "id": "gain:temp_c", "name": "", "columns": ["temp_c"], "coefficients": [1e-4, 2e-4, -1e-4],
            "std_errors": [1e-5, 1e-5, 1e-5], "unit": "", "reference": {"temp_c": 25.0}, "parameters": {},
        }),
    ];
    let cal = cal(&here, &SYMMETRIC, &effects, reading(&[]));
    let file = exported(&cal, "px4", &[]);
    assert!(file.contains("the effect offset:motor_a: PX4 supports one current or throttle"), "{file}");
    assert!(file.contains("the effect gain:temp_c: PX4 has no parameter for it"), "{file}");
    let p = px4(&file);
    assert!((p["CAL_MAG0_XCOMP"] + 3.1).abs() < 1e-6, "{p:?}");
    // Without those two it is the calibration.
    let less = write(&here, "less.json", {
        let mut value: Value =
            serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("JSON");
        value["effects"] = json!([effects[1]]);
        value.to_string()
    });
    let truth = Truth::of(&less, &log);
    truth.assert_same("two currents", 2e-6, |row, raw| px4_corrects(&p, 0, raw, &truth, row));
}
