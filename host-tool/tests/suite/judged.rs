//! What is accepted holds: on top of a calibration that no longer does, with a log that is named twice, on another log, and beyond
//! the range of a column.

use crate::common::{calibrate, case, changed, folder, ironout, simulate, text, write};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The log with its magnetic field shifted, µT.
fn moved(here: &Path, log: &Path, name: &str, by_ut: [f64; 3]) -> PathBuf {
    changed(here, log, name, |place, cells| {
        for (column, by) in ["mx_ut", "my_ut", "mz_ut"].into_iter().zip(by_ut) {
            cells[place(column)] += by;
        }
    })
}

/// Error of the corrected magnitude of a log, percent of the field.
fn error_percent(log: &Path, cal: &Path) -> f64 {
    let run = ironout(["apply", text(log), "--cal", text(cal), "--json"]);
    run.json()["after"]["rms_percent"].as_f64().expect("a number")
}

#[test]
fn an_earlier_calibration_that_the_log_contradicts_is_freed_where_it_has_changed() {
    let here = folder("contradicted");
    let turned = simulate(&here, "turned.csv", &["--seed", "5", "--seconds", "80"]);
    let bench = calibrate(&here, &turned, &[]);
    let every_way = simulate(&here, "every_way.csv", &["--seed", "5", "--recording", "3", "--seconds", "60"]);
    for motion in ["sphere", "planar", "cap=0.15"] {
        let name = |what: &str| format!("{}_{what}", motion.replace(['=', '.'], "_"));
        let options = ["--seed", "5", "--recording", "2", "--seconds", "40", "--motion", motion];
        let log = simulate(&here, &name("log.csv"), &options);
        for size_ut in [0.0, 2.0, 6.0, 20.0, 50.0] {
            let by_ut = [0.6, -0.5, 0.62].map(|share| share * size_ut);
            let own = moved(&here, &log, &name("moved.csv"), by_ut);
            let cal = here.join(format!("{size_ut}_{}", name("cal.json")));
            let run = ironout(["fit", text(&own), "--prior", text(&bench), "-o", text(&cal), "--json"]);
            let object = run.json();
            let case = format!("{motion}, {size_ut} µT: {object}");
            assert_eq!(object["contradiction"].is_null(), size_ut == 0.0, "{case}");
            if [0.0, 20.0].contains(&size_ut) && motion != "cap=0.15" {
                let diagnosis = ironout(["diagnose", text(&own), "--prior", text(&bench), "--json"]).json();
                assert_eq!(diagnosis["contradiction"].is_null(), size_ut == 0.0, "{case}: {diagnosis}");
            }
            if size_ut > 0.0 {
                assert_eq!(object["contradiction"]["freed"], "offset", "{case}");
            }
            if object["accepted"] == true {
                let whole = moved(&here, &every_way, &name("whole.csv"), by_ut);
                let error = error_percent(&whole, &cal);
                assert!(error < 2.0, "{error} %, {case}");
            } else {
                // What one plane does not show may be refused, never what every direction shows.
                assert!(motion != "sphere" && size_ut > 0.0, "{case}");
            }
        }
    }
}

/// Public complaints: a board that was moved, turned level with and without a gyro, and one that rested at eight headings and was not.
#[test]
fn level_turns_and_rests_on_top_of_a_bench_calibration_give_the_offset() {
    let Some(bench) = case("bench.json") else { return };
    for (name, expected_ut, is_contradicted) in [
        ("03_prior_moved_level.csv", [32.0, -33.0, 46.0], true),
        ("03b_level_turns_no_gyro.csv", [32.0, -33.0, 46.0], true),
        ("23_eight_headings.csv", [12.0, -25.0, 31.0], false),
    ] {
        let Some(log) = case(name) else { return };
        let run = ironout(["fit", text(&log), "--prior", text(&bench), "--json"]);
        let object = run.json();
        assert_eq!(
            (run.status, object["contradiction"].is_object()),
            (0, is_contradicted),
            "{name}: {object}"
        );
        for (axis, expected) in expected_ut.into_iter().enumerate() {
            let offset = object["offset_ut"][axis].as_f64().expect("a number");
            assert!((offset - expected).abs() < 0.3, "{name}, axis {axis}: {object}");
        }
    }
}

#[test]
fn a_log_that_is_named_ten_times_counts_once() {
    let here = folder("copies");
    let log = simulate(&here, "log.csv", &["--seed", "8", "--seconds", "6", "--motion", "cap=0.1"]);
    let later = changed(&here, &log, "later.csv", |place, cells| cells[place("t_s")] += 500.0);
    let once = ironout(["fit", text(&log), "--json"]).json();
    let mut arguments = vec!["fit", "--json"];
    arguments.extend([text(&log); 5]);
    arguments.extend([text(&later); 5]);
    let run = ironout(&arguments);
    let ten = run.json();
    for key in ["samples_used", "offset_ut", "matrix", "accepted", "std_errors"] {
        assert_eq!(ten[key], once[key], "{key}: {ten}");
    }
    arguments.retain(|argument| *argument != "--json");
    arguments.push("-v");
    let words = ironout(&arguments).stdout;
    assert!(words.contains("copies of earlier readings"), "{words}");
}

#[test]
fn a_correction_far_outside_the_range_of_a_column_is_held() {
    let here = folder("held");
    let (Some(log), Some(cal)) =
        (case("25_colder_second_log.csv"), case("25_three_effects_of_one_column.json"))
    else {
        return;
    };
    let run = ironout(["apply", text(&log), "--cal", text(&cal), "--json"]);
    // 17 °C below its range it made 183 000 µT of it. Its coefficients cancel each other in their range and nowhere else.
    let error = run.error();
    let words = error["message"].as_str().expect("words");
    assert!(run.status == 2 && words.contains("twice the field"), "{error}");
    assert!(words.contains("have temp_c outside") && words.contains("Fix: "), "{error}");
    let written = ironout(["apply", text(&log), "--cal", text(&cal), "-o", text(&here.join("out.csv"))]);
    assert!(written.status == 2 && !written.stderr.contains("cannot write"), "{}", written.stderr);

    // Further out than the range is wide nothing changes any more.
    let log = simulate(&here, "log.csv", &["--seconds", "60", "--seed", "21", "--effect", "offset:temp_c=6"]);
    let cal = calibrate(&here, &log, &["--add", "offset:temp_c"]);
    let fitted: serde_json::Value = serde_json::from_slice(&std::fs::read(&cal).expect("cal")).expect("JSON");
    let [least, most] =
        [0, 1].map(|end| fitted["effects"][0]["range"]["temp_c"][end].as_f64().expect("a number"));
    let held = 2.0 * most - least;
    let corrected = |name: &str, temp_c: f64| {
        let log = changed(&here, &log, name, |place, cells| cells[place("temp_c")] = temp_c);
        ironout(["apply", text(&log), "--cal", text(&cal), "--json"]).json()["after"].clone()
    };
    assert_eq!(corrected("hot.csv", held + 40.0), corrected("end.csv", held + 0.01));
}

#[test]
fn what_goes_by_the_clock_of_one_log_is_left_out_of_another() {
    let here = folder("other_clock");
    let options = ["--seconds", "60", "--seed", "4", "--effect", "drift=8"];
    let log = simulate(&here, "log.csv", &options);
    let cal = calibrate(&here, &log, &["--add", "drift"]);
    let own = ironout(["apply", text(&log), "--cal", text(&cal)]);
    assert!(!own.said().contains("does not apply"), "{}", own.stderr);
    // The same board on another day, when nothing drifts.
    let other = simulate(&here, "other.csv", &["--seconds", "60", "--seed", "4", "--recording", "2"]);
    let run = ironout(["apply", text(&other), "--cal", text(&cal)]);
    assert!(
        run.said().contains("does not apply drift") && run.said().contains("another log"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_calibration_that_makes_a_log_worse_is_told_and_is_no_success() {
    let here = folder("worse");
    let log = simulate(&here, "log.csv", &["--seed", "9", "--seconds", "40"]);
    let cal = calibrate(&here, &log, &[]);
    let mut wrong: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&cal).expect("cal")).expect("JSON");
    for axis in 0..3 {
        let offset = wrong["offset_ut"][axis].as_f64().expect("a number");
        wrong["offset_ut"][axis] = json!(-offset);
    }
    let wrong = write(&here, "wrong.json", wrong.to_string());
    let run = ironout(["apply", text(&log), "--cal", text(&wrong)]);
    assert_eq!(run.status, 1, "{}", run.stdout);
    assert!(run.stdout.contains("WORSE") && run.stdout.contains("ironout check"), "{}", run.stdout);
    assert_eq!(ironout(["apply", text(&log), "--cal", text(&cal)]).status, 0);
}

#[test]
fn a_column_that_is_ignored_is_no_candidate() {
    let here = folder("ignored");
    let options = ["--seconds", "60", "--seed", "3", "--effect", "offset:current_a=5"];
    let log = simulate(&here, "log.csv", &options);
    let ids = |more: &[&str]| {
        let run = ironout(["diagnose", text(&log), "--json"].iter().chain(more));
        let found = run.json();
        let rows = found["candidates"].as_array().expect("a list").clone();
        rows.iter()
            .filter(|row| row["status"] != "untestable")
            .map(|row| row["id"].as_str().expect("an id").to_string())
            .collect::<Vec<_>>()
    };
    assert!(ids(&[]).iter().any(|id| id == "offset:current_a"));
    assert!(!ids(&["--ignore", "current_a"]).iter().any(|id| id.contains("current_a")));
    let error = ironout(["diagnose", text(&log), "--ignore", "curent_a", "--json"]).error();
    let words = error["message"].as_str().expect("words");
    assert!(words.contains("no such column") && words.contains("current_a"), "{words}");
    // The command that comes next leaves it out too.
    let words = ironout(["diagnose", text(&log), "--ignore", "height_m"]).stdout;
    assert!(words.contains("--add offset:current_a") && words.contains("--ignore height_m"), "{words}");
}
