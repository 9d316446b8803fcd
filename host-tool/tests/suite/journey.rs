//! Logs in which the field itself changes: a journey, whose field is known, and a room, whose field is not.

use crate::common::{folder, ironout, text, write};
use ironout_cli::geomag::{EarthField, day};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::fmt::Write;
use std::path::PathBuf;

const RATE_HZ: f64 = 20.0;
const SECONDS: f64 = 150.0;
const NOISE_UT: f64 = 0.2;
const OFFSET_UT: [f64; 3] = [12.0, -7.0, 4.0];

/// What a row has besides what every row has: the field where it is, north, east and down, µT; a disturbance of the reading, µT; and
/// the cells of further columns.
struct Row {
    ned_ut: Vector3<f64>,
    offset_ut: Vector3<f64>,
    cells: Vec<f64>,
}

/// A board that tumbles, as CSV with these further columns.
fn log(name: &str, seed: u64, columns: &[&str], at: impl Fn(f64) -> Row) -> PathBuf {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || {
        let (a, b): (f64, f64) = (random.random(), random.random());
        NOISE_UT * (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    };
    let soft = Matrix3::new(1.06, 0.03, -0.02, 0.01, 0.95, 0.02, -0.03, 0.04, 1.01);
    let mut out = String::from("t_s,mx_ut,my_ut,mz_ut,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps");
    columns.iter().for_each(|name| write!(out, ",{name}").expect("text"));
    out.push('\n');
    let mut attitude = Rotation3::identity();
    for sample in 0..(SECONDS * RATE_HZ) as usize {
        let t = sample as f64 / RATE_HZ;
        let turn_at = |t: f64| {
            Vector3::new(
                0.9 * (0.41 * t).sin() + 0.4 * (1.3 * t).cos(),
                0.8 * (0.53 * t + 1.0).sin() + 0.3 * (1.7 * t).sin(),
                0.7 * (0.29 * t + 2.0).cos() + 0.5,
            )
        };
        let turn = turn_at(t);
        let Row { ned_ut, offset_ut, cells } = at(t);
        let field = attitude.inverse() * ned_ut;
        let m = soft * field + Vector3::from(OFFSET_UT) + offset_ut + Vector3::from_fn(|_, _| noise());
        let a = attitude.inverse() * Vector3::new(0.0, 0.0, -9.80665);
        let numbers = [m, a, turn].map(|v| format!("{:.5},{:.5},{:.5}", v.x, v.y, v.z));
        write!(out, "{t:.4},{}", numbers.join(",")).expect("text");
        cells.iter().for_each(|cell| write!(out, ",{cell:.7}").expect("text"));
        out.push('\n');
        // The gyro reads the rate of its moment; between two rows the board turns at the one in the middle.
        attitude *= Rotation3::new(turn_at(t + 0.5 / RATE_HZ) / RATE_HZ);
    }
    self::write(&folder(name), "log.csv", out)
}

fn ned(earth: EarthField) -> Vector3<f64> {
    let (dip, east) = (earth.dip_deg.to_radians(), earth.declination_deg.to_radians());
    earth.field_ut * Vector3::new(dip.cos() * east.cos(), dip.cos() * east.sin(), dip.sin())
}

/// From the Alps to the Baltic Sea, climbing; with a chip that warms up where `per_degree` is not zero.
fn journey(name: &str, tells_where: bool, per_degree: f64) -> PathBuf {
    let on = day("2026-01-01").expect("a day");
    let columns: &[&str] =
        if tells_where { &["temp_c", "lat_deg", "lon_deg", "height_m"] } else { &["temp_c"] };
    log(name, 7, columns, |t| {
        let share = t / SECONDS;
        let (north, east, up) = (47.0 + 7.0 * share, 9.0 + 2.0 * share, 400.0 + 6000.0 * share);
        let earth = EarthField::over(north, east, up, on).expect("covered");
        let temp_c = 24.0 + 6.0 * (0.05 * t).sin() + 2.0 * (0.17 * t).cos();
        let mut cells = vec![temp_c, north, east, up];
        cells.truncate(columns.len());
        Row {
            ned_ut: ned(earth),
            offset_ut: per_degree * (temp_c - 24.0) * Vector3::new(0.2, -0.3, 0.25),
            cells,
        }
    })
}

fn added(diagnosis: &serde_json::Value) -> Vec<String> {
    let steps = diagnosis["steps"].as_array().expect("steps");
    steps.iter().filter_map(|step| step["added"].as_str()).map(String::from).collect()
}

#[test]
fn travelling_is_no_effect_where_the_log_tells_where_it_was() {
    let blind = ironout(["diagnose", text(&journey("journey_blind", false, 0.0)), "--json"]).json();
    let known = journey("journey", true, 0.0);
    let run = ironout(["diagnose", text(&known), "--json"]);
    let seen = run.json();
    let first = |one: &serde_json::Value| one["steps"][0]["rms_ut"].as_f64().expect("a number");
    assert!(first(&blind) > 2.0 * NOISE_UT, "the change of field is an error: {}", blind["steps"]);
    assert_ne!(blind["verdict"], "complete", "{blind}");
    assert!((0.9..1.1).contains(&(first(&seen) / NOISE_UT)), "{}", seen["steps"]);
    assert_eq!((seen["verdict"].as_str(), added(&seen).len()), (Some("complete"), 0), "{}", seen["reasons"]);
    // Several degrees of dip too.
    assert!(seen["dip"]["rms_deg_after"].as_f64().expect("a number") < 0.5, "{}", seen["dip"]);
    assert!(
        run.said().contains("along the path") && run.said().contains("2026-01-01, assumed"),
        "{}",
        run.stderr
    );

    let cal = folder("journey_cal").join("cal.json");
    let fit = ironout(["fit", text(&known), "-o", text(&cal), "--json", "--date", "2026-01-01"]);
    assert!(fit.said().contains("2026-01-01, as given"), "{}", fit.stderr);
    let fit = fit.json();
    assert_eq!(fit["accepted"], true, "{}", fit["reasons"]);
    for (axis, offset) in OFFSET_UT.iter().enumerate() {
        let own = fit["offset_ut"][axis].as_f64().expect("a number");
        assert!((own - offset).abs() < 0.1, "axis {axis}: {own} µT, put in {offset}");
    }
    let applied = ironout(["apply", text(&known), "--cal", text(&cal), "--json"]).json();
    let (rms, own) = (applied["after"]["rms_ut"].as_f64(), fit["rms_ut"].as_f64());
    assert!((rms.expect("a number") / own.expect("a number") - 1.0).abs() < 0.01, "{applied}");
    // What a target cannot hold is held against the field of each place, too: here it holds all of the magnitude.
    let params = cal.with_file_name("px4.params");
    let export = ["export", text(&cal), "--as", "px4", "--log", text(&known), "-o", text(&params), "--json"];
    let cost = ironout(export).json()["cost"].clone();
    for figure in ["rms_ut", "held_rms_ut"] {
        let left = cost[figure].as_f64().expect("an error");
        assert!((left / own.expect("a number") - 1.0).abs() < 0.02, "{figure}: {cost}");
    }
    let check = ironout(["check", text(&known), "--cal", text(&cal), "--json"]).json();
    assert_eq!(check["verdict"], "good", "{check}");
}

#[test]
fn what_is_missing_on_a_journey_is_named() {
    let warm = ironout(["diagnose", text(&journey("journey_warm", true, 1.0)), "--json"]).json();
    assert_eq!(added(&warm), ["offset:temp_c"], "{}", warm["steps"]);
    assert_eq!(warm["verdict"], "missing", "{}", warm["reasons"]);
}

#[test]
fn a_date_that_is_none_is_refused() {
    let path = journey("journey_date", true, 0.0);
    for date in ["yesterday", "2026-13-01", "1999-01-01"] {
        let error = ironout(["fit", text(&path), "--date", date, "--json"]).error();
        assert!(error["message"].as_str().expect("words").starts_with("--date"), "{error}");
    }
}

#[test]
fn a_field_that_follows_the_place_is_said_and_no_effect_is_named() {
    let strays = |t: f64| (0.55 * t).sin() + 0.7 * (0.93 * t + 1.0).sin() + 0.5 * (0.21 * t + 2.0).sin();
    let home = Vector3::new(19.0, 1.0, 44.0);
    let room = log("room", 3, &["temp_c"], |t| Row {
        // A gradient of some µT over the way that the hand goes.
        ned_ut: home + Vector3::new(1.2 * strays(t), 0.8 * strays(t + 40.0), 1.5 * strays(t + 90.0)),
        offset_ut: Vector3::zeros(),
        cells: vec![24.0 + 3.0 * (0.04 * t).sin()],
    });
    let words = "does not depend on the orientation";
    let diagnosis = ironout(["diagnose", text(&room), "--json"]).json();
    assert_eq!(diagnosis["verdict"], "unexplained", "{diagnosis}");
    assert!(diagnosis["reasons"].to_string().contains(words), "{}", diagnosis["reasons"]);
    assert_eq!(added(&diagnosis).len(), 0, "{}", diagnosis["steps"]);
    let said = ironout(["diagnose", text(&room)]).stdout;
    assert!(said.contains("Rotate the sensor in one spot"), "{said}");

    // A disturbance of the sensor that no column tells is none of the field.
    let sensor = log("room_not", 3, &["temp_c"], |t| Row {
        ned_ut: home,
        offset_ut: Vector3::new(1.5 * strays(t), 1.0 * strays(t + 40.0), -1.5 * strays(t + 90.0)),
        cells: vec![24.0 + 3.0 * (0.04 * t).sin()],
    });
    let diagnosis = ironout(["diagnose", text(&sensor), "--json"]).json();
    assert!(!diagnosis["reasons"].to_string().contains(words), "{}", diagnosis["reasons"]);
}
