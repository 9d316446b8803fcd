//! Real recordings: what the fit makes of them, and that a long rest does not disturb it.

use crate::common::{folder, ironout, recording, write};
use std::path::Path;

/// Scale of the QMC5883L at ±8 G, µT a count.
const QMC_SCALE: f64 = 0.0333;

fn fit(log: &Path, options: &[&str]) -> serde_json::Value {
    let run = ironout(
        ["fit".as_ref(), log.as_os_str(), "--json".as_ref()]
            .into_iter()
            .chain(options.iter().map(AsRef::as_ref)),
    );
    assert!(run.status <= 1, "{}", run.stderr);
    run.json()
}

fn number(object: &serde_json::Value, key: &str) -> f64 {
    object[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {object}"))
}

fn triple(value: &serde_json::Value) -> [f64; 3] {
    [0, 1, 2].map(|i| value[i].as_f64().expect("a number"))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[test]
fn the_full_sphere_of_the_hmc5883l_is_fitted_to_its_noise() {
    let Some(log) = recording("hmc5883l-mpu6050-full-sphere.csv") else { return };
    let object = fit(&log, &[]);
    assert_eq!(object["accepted"], true);
    let percent = number(&object, "rms_ut") / number(&object, "field_ut") * 100.0;
    assert!(percent <= 0.47, "{percent} %");
    assert!(number(&object, "holdout_rms_ut") >= number(&object, "residual_floor_ut"));
}

/// Rms of the corrected magnitude of `rows` (counts), over F.
fn error_over_field(rows: &[[f64; 3]], object: &serde_json::Value) -> f64 {
    let (offset, field) = (triple(&object["offset_ut"]), number(object, "field_ut"));
    let matrix = [0, 1, 2].map(|i| triple(&object["matrix"][i]));
    let squares: f64 = rows
        .iter()
        .map(|counts| {
            let v = [0, 1, 2].map(|axis| counts[axis] * QMC_SCALE - offset[axis]);
            let h = matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
            distance(h, [0.0; 3]) - field
        })
        .map(|r| r * r)
        .sum();
    (squares / rows.len() as f64).sqrt() / field
}

#[test]
fn a_rest_of_one_minute_or_ten_changes_nothing() {
    let Some(log) = recording("qmc5883l-filtered.csv") else { return };
    let text = std::fs::read_to_string(&log).expect("text");
    let rows: Vec<[f64; 4]> = text
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            [cells[0], cells[1], cells[2], cells[3]]
        })
        .collect();
    let (rest, moving): (Vec<_>, Vec<_>) = rows.iter().copied().partition(|row| row[0] < 60.0);
    assert!(rest.len() == 3000 && moving.len() > 15_000);

    let here = folder("rest");
    let log_of = |name: &str, parts: &[&[[f64; 4]]]| {
        let mut text = String::from("t_s,mx_counts,my_counts,mz_counts\n");
        for (i, [_, x, y, z]) in parts.iter().flat_map(|part| part.iter()).enumerate() {
            text.push_str(&format!("{:.2},{x},{y},{z}\n", i as f64 * 0.02));
        }
        write(&here, name, text)
    };
    let scale = ["--ut-per-count", "0.0333"];
    let alone = fit(&log_of("moving.csv", &[&moving]), &scale);
    let counts: Vec<[f64; 3]> = moving.iter().map(|row| [row[1], row[2], row[3]]).collect();
    for times in [1, 10] {
        let mut parts: Vec<&[[f64; 4]]> = vec![&rest; times];
        parts.push(&moving);
        let object = fit(&log_of("with_rest.csv", &parts), &scale);
        let error = error_over_field(&counts, &object);
        assert!(error <= 0.030, "rest × {times}: {:.2} %", error * 100.0);
        let moved =
            distance(triple(&object["offset_ut"]), triple(&alone["offset_ut"])) / number(&alone, "field_ut");
        assert!(moved <= 0.005, "rest × {times}: the offset moved by {:.2} % of F", moved * 100.0);
        println!("rest × {times}: error {:.2} %, offset moved {:.3} %", error * 100.0, moved * 100.0);
    }
}

#[test]
fn outliers_are_set_aside_and_said() {
    let Some(log) = recording("lsm9ds1-hand-outliers.csv") else { return };
    let object = fit(&log, &[]);
    let aside = number(&object, "samples_set_aside");
    assert!((5.0..50.0).contains(&aside), "{object}");
    // 6.2 % with all samples.
    let percent = number(&object, "rms_ut") / number(&object, "field_ut") * 100.0;
    assert!(percent < 5.5, "{percent} %");
}

#[test]
fn limited_and_missing_attitude_is_refused_with_what_to_do() {
    for (name, word) in [
        ("hmc5883l-mpu6050-roll-and-tilt-at-45-90.csv", "hold the sensor upside down"),
        ("cubesat-magnetorquer-mag1.csv", "plane"),
    ] {
        let Some(log) = recording(name) else { return };
        let object = fit(&log, &[]);
        assert_eq!(object["accepted"], false, "{name}");
        assert!(
            object["reasons"][0].as_str().is_some_and(|reason| reason.contains(word)),
            "{name}: {object}"
        );
    }
}

#[test]
fn a_slow_sensor_in_a_fast_log_counts_its_samples_once() {
    let Some(log) = recording("px4-quad-flight.csv") else { return };
    let object = fit(&log, &[]);
    let used = number(&object, "samples_used") + number(&object, "samples_set_aside");
    assert!(used < 9486.0 * 0.5, "{used}");
}
