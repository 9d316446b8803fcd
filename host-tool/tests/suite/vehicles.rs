//! Logs of vehicles that are not turned over: accepted for the attitudes that they show, refused where a sensor stands otherwise.

use crate::common::{case, changed, folder, ironout, recording, text};
use serde_json::Value;
use std::path::Path;

fn fitted(log: &Path, options: &[&str]) -> Value {
    let start = ["fit", text(log), "--json"];
    ironout(start.into_iter().chain(options.iter().copied())).json()
}

fn offset_ut(object: &Value) -> [f64; 3] {
    let list = object["offset_ut"].as_array().expect("an offset");
    std::array::from_fn(|axis| list[axis].as_f64().expect("a number"))
}

/// Of the simulated vehicles of the public cases.
const TRUE_OFFSET_UT: [f64; 3] = [12.0, -25.0, 30.0];

#[test]
fn a_boat_and_a_car_are_accepted_for_what_they_show() {
    for (name, most_tilt_deg, level_deg, within_ut) in [
        ("18_boat_rocking.csv", 30.0, 0.25, [0.5, 0.5, 2.5]),
        ("17_car_level.csv", 5.0, 0.3, [4.0, 4.0, 9.0]),
    ] {
        let Some(log) = case(name) else { return };
        let object = fitted(&log, &[]);
        assert_eq!(object["accepted"], true, "{name}: {object}");
        let holds_for = &object["holds_for"];
        assert!(holds_for["tilt_deg"].as_f64().expect("a tilt") <= most_tilt_deg, "{name}: {holds_for}");
        let level = holds_for["heading_errors"][0]["heading_error_deg"].as_f64().expect("an error");
        assert!(level < level_deg, "{name}: {holds_for}");
        for ((found, truth), within) in offset_ut(&object).into_iter().zip(TRUE_OFFSET_UT).zip(within_ut) {
            assert!((found - truth).abs() < within, "{name}: {found} instead of {truth}");
        }
        // For every attitude it is no calibration.
        assert_eq!(fitted(&log, &["--for", "all"])["accepted"], false, "{name}");
    }
}

#[test]
fn a_vehicle_that_is_tilted_further_than_asked_is_refused_with_its_error() {
    let Some(log) = case("17_car_level.csv") else { return };
    let object = fitted(&log, &["--for", "45"]);
    assert_eq!(object["accepted"], false, "{object}");
    let reason = object["reasons"][0].as_str().expect("a reason");
    assert!(
        reason.contains("tilts up to 45°") && reason.contains("--prior bench.json --free offset"),
        "{reason}"
    );
}

#[test]
fn the_matrix_of_the_bench_makes_a_level_log_carry_further() {
    let (Some(log), Some(bench)) = (case("17_car_level.csv"), case("bench.json")) else { return };
    let at_45 = |object: &Value| {
        object["holds_for"]["heading_errors"][3]["heading_error_deg"].as_f64().expect("an error")
    };
    let with = fitted(&log, &["--prior", text(&bench), "--free", "offset"]);
    assert_eq!(with["accepted"], true, "{with}");
    let alone = fitted(&log, &[]);
    assert!(at_45(&with) < 0.7 * at_45(&alone), "{with} {alone}");
}

#[test]
fn sensors_in_other_axes_are_not_accepted_for_a_vehicle() {
    let here = folder("vehicles_axes");
    for name in ["18_boat_rocking.csv", "17_car_level.csv"] {
        let Some(log) = case(name) else { return };
        for (what, column, factor) in [("mirrored", "mx_ut", -1.0), ("yaw", "gz_radps", -1.0)] {
            let wrong = changed(&here, &log, &format!("{what}_{name}"), |place, cells| {
                cells[place(column)] *= factor;
            });
            let object = fitted(&wrong, &[]);
            assert_eq!(object["accepted"], false, "{what} {name}: {object}");
        }
    }
}

#[test]
fn apply_says_where_a_log_is_tilted_further_than_the_calibration_is_for() {
    let here = folder("vehicles_tilted");
    let (Some(car), Some(boat)) = (case("17_car_level.csv"), case("18_boat_rocking.csv")) else { return };
    let cal = here.join("car.json");
    assert_eq!(ironout(["fit", text(&car), "-o", text(&cal)]).status, 0);
    let said =
        |log: &Path| ironout(["apply", text(log), "--cal", text(&cal), "--json"]).json()["tilted"].clone();
    assert!(said(&car).is_null());
    assert!(said(&boat).as_str().is_some_and(|words| words.contains("tilts up to 5°")), "{}", said(&boat));
    let exported = ironout(["export", text(&cal), "--as", "c"]);
    assert!(exported.stderr.contains("fitted for tilts up to 5°"), "{}", exported.stderr);
}

/// `--heading` options of so many times of a log, from its column of true headings, with this error, degrees.
fn known_headings(log: &Path, count: usize, error_deg: f64) -> Vec<String> {
    let text = std::fs::read_to_string(log).expect("a log");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place = |name: &str| header.iter().position(|own| *own == name).expect("a column");
    let (time, heading) = (place("t_s"), place("heading_deg"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let taken = (1..=count).map(|number| &rows[number * (rows.len() - 1) / (count + 1)]);
    taken
        .flat_map(|row| {
            let degrees = row[heading].parse::<f64>().expect("a heading") + error_deg;
            ["--heading".to_string(), format!("{}={degrees}", row[time])]
        })
        .collect()
}

#[test]
fn known_headings_make_a_level_log_more_exact_and_never_falsely_certain() {
    let Some(log) = case("17_car_level.csv") else { return };
    let alone = fitted(&log, &[]);
    let headings = known_headings(&log, 8, 0.0);
    let with = fitted(&log, &headings.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(with["accepted"], true, "{with}");
    let level = |object: &Value| {
        object["holds_for"]["heading_errors"][0]["heading_error_deg"].as_f64().expect("an error")
    };
    assert!(level(&with) <= 1.05 * level(&alone), "{} {}", with["holds_for"], alone["holds_for"]);
    for ((found, truth), within) in offset_ut(&with).into_iter().zip(TRUE_OFFSET_UT).zip([4.0, 4.0, 9.0]) {
        assert!((found - truth).abs() < within, "{found} instead of {truth}");
    }
    // Headings that count the other way are no headings, and change nothing.
    let reversed: Vec<String> = headings
        .iter()
        .map(|word| match word.split_once('=') {
            Some((time, degrees)) => format!("{time}={}", -degrees.parse::<f64>().expect("degrees")),
            None => word.clone(),
        })
        .collect();
    let unused = fitted(&log, &reversed.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(offset_ut(&unused), offset_ut(&alone));
    assert!(unused["reason_codes"].to_string().contains("logged-attitude-unused"), "{unused}");
    let said = ironout(["fit", text(&log), "--heading", "9999=90"]);
    assert!(said.status == 2 && said.stderr.contains("--heading needs a time within"), "{}", said.stderr);
    let usage = ironout(["fit", text(&log), "--heading", "north"]);
    assert!(usage.status == 2 && usage.stderr.contains("expected T=DEG"), "{}", usage.stderr);
}

#[test]
fn the_refusal_of_a_flight_says_first_what_to_do_with_it() {
    let Some(flight) = recording("px4-quad-flight.csv") else { return };
    for options in [&[][..], &["--for", "all"]] {
        let object = fitted(&flight, options);
        assert_eq!(object["reason_codes"][0], "vehicle", "{object}");
        let first = object["reasons"][0].as_str().expect("a reason");
        assert!(
            first.contains("--prior bench.json --free offset") && first.contains("--prior-from parameters"),
            "{first}"
        );
        let brief = ironout(["fit", text(&flight)].into_iter().chain(options.iter().copied())).stdout;
        let steps = brief.split_once("Next steps").expect("steps").1;
        assert!(steps.find("--free offset") < steps.find("ironout diagnose"), "{brief}");
    }
}
