//! Ordinary flights of another hand's generator, written as ArduPilot and PX4 log them, with the attitude and the place.

use crate::common::{folder, ironout, text, write};
use crate::writers::dataflash::Cell::{N, T};
use crate::writers::dataflash::{Cell, Dataflash};
use crate::writers::ulog::{Ulog, Value, floats};
use second_generator::{Drawn, Kind, draw};
use serde_json::Value as Json;
use std::path::Path;

/// Errors of a parameter beyond so many standard errors are false certainty.
pub const MAX_ERRORS: f64 = 4.0;
pub const START_US: f64 = 5e6;
/// What the autopilot had added to its readings, mG.
const ADDED_MG: [f64; 3] = [-120.0, 333.0, 51.0];

/// Flights whose log has a place: without and with an offset proportional to the current.
fn flights() -> [Drawn; 2] {
    let of = |disturbed: bool| {
        (7000..7100)
            .map(|number| draw(Kind::Flight, number))
            .find(|drawn| {
                let hidden = drawn.truth.hidden.iter().any(|hidden| hidden.id == "offset:current_a");
                let inertial = drawn.column("ax_mps2").is_some() && drawn.column("gx_radps").is_some();
                inertial && hidden == disturbed && drawn.column("lat_deg").is_some()
            })
            .expect("one of a hundred flights")
    };
    [of(false), of(true)]
}

/// The true offset at the mean of the current.
pub fn offset_ut(drawn: &Drawn) -> [f64; 3] {
    let disturbances = drawn.truth.disturbance_ut();
    let n = disturbances.len() as f64;
    [0, 1, 2].map(|axis| drawn.truth.offset_ut[axis] + disturbances.iter().map(|d| d[axis]).sum::<f64>() / n)
}

/// The true offset per ampere.
fn motor_ut_per_a(drawn: &Drawn) -> [f64; 3] {
    let disturbances = drawn.truth.disturbance_ut();
    let current = drawn.column("current_a").expect("a flight logs its current");
    let mean = current.iter().sum::<f64>() / current.len() as f64;
    let variance: f64 = current.iter().map(|value| (value - mean).powi(2)).sum();
    [0, 1, 2].map(|axis| {
        disturbances.iter().zip(current).map(|(d, value)| d[axis] * (value - mean)).sum::<f64>() / variance
    })
}

pub fn three(drawn: &Drawn, first: &str, unit: &str, row: usize) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| drawn.column(&format!("{first}{axis}_{unit}")).expect("a sensor")[row])
}

fn attitude(drawn: &Drawn, row: usize) -> [f64; 4] {
    ["q_w", "q_x", "q_y", "q_z"].map(|name| drawn.column(name).expect("an attitude")[row])
}

/// How ArduPilot says the attitude.
#[derive(Clone, Copy, PartialEq)]
enum Says {
    /// `XKQ`, a quaternion of either sign.
    Filter,
    /// `ATT`, degrees.
    Angles,
}

/// The `IMU` message of a row.
pub fn imu(file: &mut Dataflash, drawn: &Drawn, time: Cell<'static>, row: usize) {
    let [gx, gy, gz] = three(drawn, "g", "radps", row).map(N);
    let [ax, ay, az] = three(drawn, "a", "mps2", row).map(N);
    let zero = N(0.0);
    let rest = [zero, zero, N(35.5), N(1.0), N(1.0), N(1000.0), N(1000.0)];
    file.message("IMU", &[&[time, zero, gx, gy, gz, ax, ay, az][..], &rest].concat());
}

fn ardupilot(drawn: &Drawn, says: Says) -> Vec<u8> {
    let mut file = Dataflash::new();
    file.message("MSG", &[N(1000.0), T("ArduCopter V4.5.7 (2a3dc4b7)")]);
    for (letter, offset) in ["X", "Y", "Z"].iter().zip(ADDED_MG) {
        file.message("PARM", &[N(2000.0), T(&format!("COMPASS_OFS_{letter}")), N(offset), N(0.0)]);
    }
    let time_s = drawn.column("t_s").expect("a time");
    for row in 0..time_s.len() {
        let (time, zero) = (N((START_US + 1e6 * time_s[row]).round()), N(0.0));
        imu(&mut file, drawn, time, row);
        let current = N(drawn.column("current_a").expect("a current")[row]);
        file.message("BAT", &[time, zero, N(16.0), N(16.0), current, zero, zero, zero, N(21.5), zero]);
        if row % 10 == 0 {
            let at = ["lat_deg", "lon_deg"].map(|name| N(drawn.column(name).expect("a place")[row]));
            let head = [time, zero, N(3.0), zero, zero, N(9.0), N(0.8)];
            file.message("GPS", &[&head[..], &at, &[zero, zero, zero]].concat());
        }
        let [w, x, y, z] = attitude(drawn, row);
        match says {
            Says::Filter => {
                // Two cores; the sign of a quaternion says nothing.
                let sign = if row % 7 < 3 { 1.0 } else { -1.0 };
                let [w, x, y, z] = [w, x, y, z].map(|value| N(sign * value));
                file.message("XKQ", &[time, zero, w, x, y, z]);
                file.message("XKQ", &[time, N(1.0), N(1.0), zero, zero, zero]);
            }
            Says::Angles => {
                let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)).to_degrees();
                let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin().to_degrees();
                let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)).to_degrees();
                file.message("ATT", &[time, zero, N(roll), zero, N(pitch), zero, N(yaw.rem_euclid(360.0))]);
            }
        }
        let field = three(drawn, "m", "ut", row);
        let [mx, my, mz] = [0, 1, 2].map(|axis| N((10.0 * field[axis] + ADDED_MG[axis]).round()));
        let [ox, oy, oz] = ADDED_MG.map(N);
        file.message("MAG", &[time, zero, mx, my, mz, ox, oy, oz, zero, zero, zero, N(1.0), zero]);
    }
    file.binary
}

fn px4(drawn: &Drawn) -> Vec<u8> {
    let mut file = Ulog::new(START_US as u64);
    file.info("sys_name", "PX4");
    file.format("sensor_mag:uint64_t timestamp;uint32_t device_id;float x;float y;float z;");
    file.format("sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;");
    file.format("battery_status:uint64_t timestamp;float voltage_v;float current_a;");
    file.format("vehicle_attitude:uint64_t timestamp;float[4] q;");
    file.format(
        "sensor_gps:uint64_t timestamp;double latitude_deg;double longitude_deg;double altitude_msl_m;",
    );
    file.parameter("CAL_MAG0_ID", Value::Int(1));
    for (id, name) in ["sensor_mag", "sensor_combined", "battery_status", "vehicle_attitude", "sensor_gps"]
        .iter()
        .enumerate()
    {
        file.subscribe(0, id as u16, name);
    }
    let time_s = drawn.column("t_s").expect("a time");
    for row in 0..time_s.len() {
        let stamp = ((START_US + 1e6 * time_s[row]).round() as u64).to_le_bytes();
        file.data(
            1,
            &[&stamp, &floats(three(drawn, "g", "radps", row)), &floats(three(drawn, "a", "mps2", row))],
        );
        let current = drawn.column("current_a").expect("a current")[row] as f32;
        file.data(2, &[&stamp, &16.2_f32.to_le_bytes(), &current.to_le_bytes()]);
        let q: Vec<u8> =
            attitude(drawn, row).iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        file.data(3, &[&stamp, &q]);
        if row % 10 == 0 {
            let at =
                ["lat_deg", "lon_deg"].map(|name| drawn.column(name).expect("a place")[row].to_le_bytes());
            file.data(4, &[&stamp, &at[0], &at[1], &0.0_f64.to_le_bytes()]);
        }
        let gauss = three(drawn, "m", "ut", row).map(|value| value / 100.0);
        file.data(0, &[&stamp, &7_u32.to_le_bytes(), &floats(gauss)]);
    }
    file.bytes
}

pub fn fitted(log: &Path, drawn: &Drawn, more: &[&str]) -> Json {
    let add: &[&str] = if drawn.truth.hidden.is_empty() { &[] } else { &["--add", "offset:current_a"] };
    let start = ["fit", text(log), "--json", "--date", "2025-07-01"];
    ironout(start.iter().chain(add).chain(more).copied()).json()
}

/// The largest of three errors over what is predicted of them.
pub fn errors(found: &Json, predicted: &Json, truth: [f64; 3]) -> f64 {
    (0..3)
        .map(|axis| {
            let value = |list: &Json| list[axis].as_f64().expect("a number");
            (value(found) - truth[axis]).abs() / value(predicted)
        })
        .fold(0.0, f64::max)
}

fn assert_within_its_errors(what: &str, object: &Json, drawn: &Drawn) {
    let off = errors(&object["offset_ut"], &object["std_errors"]["offset_ut"], offset_ut(drawn));
    assert!(off < MAX_ERRORS, "{what}: the offset is off by {off} standard errors: {object}");
    if !drawn.truth.hidden.is_empty() {
        let effect = &object["effects"][0];
        let off = errors(&effect["coefficients"], &effect["std_errors"], motor_ut_per_a(drawn));
        assert!(off < MAX_ERRORS, "{what}: the motor vector is off by {off} standard errors: {effect}");
    }
}

#[test]
fn parameters_come_back_from_flights_of_ardupilot_and_px4() {
    let here = folder("vehicles_flights");
    for (number, drawn) in flights().iter().enumerate() {
        for (name, bytes) in [
            (format!("filter_{number}.bin"), ardupilot(drawn, Says::Filter)),
            (format!("angles_{number}.bin"), ardupilot(drawn, Says::Angles)),
            (format!("px4_{number}.ulg"), px4(drawn)),
        ] {
            let log = write(&here, &name, &bytes);
            let object = fitted(&log, drawn, &[]);
            assert_eq!(object["accepted"], true, "{name}: {object}");
            assert!(!object["reasons"].to_string().contains("attitude is not used"), "{name}: {object}");
            assert_within_its_errors(&name, &object, drawn);
            // The world magnetic model's field of the place, within the rocks of a place.
            let field = object["field_ut"].as_f64().expect("a field");
            assert!(
                (field / drawn.truth.field_ut - 1.0).abs() < 0.02,
                "{name}: {field} {}",
                drawn.truth.field_ut
            );
        }
    }
}

/// The product of two quaternions.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The flight with another attitude at each row.
fn with_attitude(drawn: &Drawn, of: impl Fn(usize) -> [f64; 4]) -> Drawn {
    let mut changed = drawn.clone();
    for (name, values) in &mut changed.columns {
        if let Some(place) = ["q_w", "q_x", "q_y", "q_z"].iter().position(|own| own == name) {
            *values = (0..values.len()).map(|row| of(row)[place]).collect();
        }
    }
    changed
}

#[test]
fn a_wrong_attitude_gives_no_false_certainty() {
    let here = folder("vehicles_attitudes");
    let [plain, disturbed] = flights();
    let rows = plain.columns[0].1.len();
    let late = (0.2 * plain.truth.rate_hz).round() as usize;
    let inverse = |[w, x, y, z]: [f64; 4]| [w, -x, -y, -z];
    let (half_roll, right) = (2.0_f64.to_radians(), std::f64::consts::FRAC_1_SQRT_2);
    let changed = [
        ("late", with_attitude(&plain, |row| attitude(&plain, row.saturating_sub(late))), None),
        (
            "rolled",
            with_attitude(&plain, |row| {
                product(attitude(&plain, row), [half_roll.cos(), half_roll.sin(), 0.0, 0.0])
            }),
            None,
        ),
        // Of a controller whose x axis is the vehicle's down, of another convention, and of another flight.
        (
            "mounted",
            with_attitude(&plain, |row| product(attitude(&plain, row), [right, 0.0, right, 0.0])),
            Some("from the accelerometer's"),
        ),
        ("inverse", with_attitude(&plain, |row| inverse(attitude(&plain, row))), Some("rotates differently")),
        (
            "backwards",
            with_attitude(&plain, |row| attitude(&plain, rows - 1 - row)),
            Some("rotates differently"),
        ),
    ];
    for (what, drawn, said) in changed {
        let log = write(&here, &format!("{what}.csv"), drawn.csv());
        let object = fitted(&log, &drawn, &["--for", "level"]);
        let reasons = object["reasons"].to_string();
        match said {
            Some(words) => assert!(
                reasons.contains("attitude is not used") && reasons.contains(words),
                "{what}: {reasons}"
            ),
            None => assert!(!reasons.contains("attitude is not used"), "{what}: {reasons}"),
        }
        if object["accepted"] == true {
            assert_within_its_errors(what, &object, &drawn);
        }
    }
    // With an effect that nobody named, the offset is that at the mean of its column.
    let log = write(&here, "unnamed.csv", disturbed.csv());
    let start = ["fit", text(&log), "--json", "--date", "2025-07-01", "--for", "level"];
    let object = ironout(start).json();
    if object["accepted"] == true {
        let off = errors(&object["offset_ut"], &object["std_errors"]["offset_ut"], offset_ut(&disturbed));
        assert!(off < MAX_ERRORS, "{off}: {object}");
    }
}

#[test]
fn another_log_and_the_autopilots_own_calibration_are_priors() {
    let here = folder("vehicles_priors");
    let [plain, _] = flights();
    let log = write(&here, "flight.bin", ardupilot(&plain, Says::Angles));
    let alone = fitted(&log, &plain, &[]);
    let twice = fitted(&log, &plain, &["--prior-from", text(&log)]);
    let error =
        |object: &Json, axis: usize| object["std_errors"]["offset_ut"][axis].as_f64().expect("an error");
    for axis in 0..3 {
        assert!(error(&twice, axis) < error(&alone, axis), "{axis}: {twice} {alone}");
    }
    assert_within_its_errors("twice", &twice, &plain);
    let csv = write(&here, "flight.csv", plain.csv());
    let refused = ironout(["fit", text(&csv), "--prior-from", "parameters"]);
    assert_eq!(refused.status, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("no compass calibration of an autopilot"), "{}", refused.stderr);
}
