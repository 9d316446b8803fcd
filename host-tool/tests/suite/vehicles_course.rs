//! Cars of another hand's generator, written as ArduPilot and PX4 log rovers, with the course of a GPS receiver.

use crate::common::{folder, ironout, text, write};
use crate::vehicles_flights::{MAX_ERRORS, START_US, errors, imu, offset_ut, three};
use crate::writers::dataflash::Cell::{N, T};
use crate::writers::dataflash::Dataflash;
use crate::writers::ulog::{Ulog, Value, floats};
use second_generator::{Drawn, Kind, draw};
use serde_json::Value as Json;
use std::path::Path;

/// Share of the hard iron that the compass of the autopilot still has.
const LEFT_OVER: f64 = 0.3;
const SPEED_MPS: f64 = 7.0;

/// Cars of the test.
const CARS: usize = 5;

/// Cars with all sensors that hide nothing.
fn cars(count: usize) -> Vec<Drawn> {
    let is_one = |drawn: &Drawn| {
        let inertial = drawn.column("ax_mps2").is_some() && drawn.column("gx_radps").is_some();
        inertial && drawn.truth.hidden.is_empty()
    };
    (7100..7400).map(|number| draw(Kind::Car, number)).filter(is_one).take(count).collect()
}

/// A vector in north, east and down.
fn to_world([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let once = cross([x, y, z], v);
    let twice = cross([x, y, z], once);
    [0, 1, 2].map(|axis| v[axis] + 2.0 * (w * once[axis] + twice[axis]))
}

/// Roll, pitch and yaw of a quaternion, degrees.
fn angles_deg([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
    let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
    let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
    [roll, pitch, yaw].map(f64::to_degrees)
}

fn quaternion(angles_deg: [f64; 3]) -> [f64; 4] {
    let [(sr, cr), (sp, cp), (sy, cy)] = angles_deg.map(|angle| (0.5 * angle).to_radians().sin_cos());
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

/// What the log says of the yaw.
#[derive(Clone, Copy, PartialEq)]
enum Yaw {
    True,
    /// That of a compass with some of its hard iron.
    OfCompass,
}

/// Roll, pitch and yaw that the autopilot logs, degrees.
fn logged_deg(drawn: &Drawn, yaw: Yaw, row: usize) -> [f64; 3] {
    let truth = &drawn.truth;
    let [roll, pitch, true_yaw] = angles_deg(truth.attitude[row]);
    if yaw == Yaw::True {
        return [roll, pitch, true_yaw];
    }
    let field: [f64; 3] =
        std::array::from_fn(|axis| truth.field_body_ut[row][axis] + LEFT_OVER * truth.offset_ut[axis]);
    let [north, east, _] = to_world(truth.attitude[row], field);
    [roll, pitch, true_yaw - east.atan2(north).to_degrees() + truth.declination_deg]
}

/// What a receiver says: speed and course, five times a second.
fn course_deg(drawn: &Drawn, row: usize) -> f64 {
    angles_deg(drawn.truth.attitude[row])[2].rem_euclid(360.0)
}

fn ardupilot(drawn: &Drawn, firmware: &str, yaw: Yaw) -> Vec<u8> {
    let mut file = Dataflash::new();
    file.message("MSG", &[N(1000.0), T(firmware)]);
    let time_s = drawn.column("t_s").expect("a time");
    let every = (drawn.truth.rate_hz / 5.0).round().max(1.0) as usize;
    for row in 0..time_s.len() {
        let (time, zero) = (N((START_US + 1e6 * time_s[row]).round()), N(0.0));
        imu(&mut file, drawn, time, row);
        if row % every == 0 {
            let head = [time, zero, N(3.0), zero, zero, N(9.0), N(0.8), zero, zero, zero];
            file.message("GPS", &[&head[..], &[N(SPEED_MPS), N(course_deg(drawn, row))]].concat());
        }
        let [roll, pitch, yaw] = logged_deg(drawn, yaw, row);
        file.message("ATT", &[time, zero, N(roll), zero, N(pitch), zero, N(yaw.rem_euclid(360.0))]);
        let [mx, my, mz] = three(drawn, "m", "ut", row).map(|axis| N((10.0 * axis).round()));
        file.message("MAG", &[time, zero, mx, my, mz, zero, zero, zero, zero, zero, zero, N(1.0), zero]);
    }
    file.binary
}

fn px4(drawn: &Drawn, vehicle_type: i32, yaw: Yaw) -> Vec<u8> {
    let mut file = Ulog::new(START_US as u64);
    file.info("sys_name", "PX4");
    file.format("sensor_mag:uint64_t timestamp;uint32_t device_id;float x;float y;float z;");
    file.format("sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;");
    file.format("vehicle_attitude:uint64_t timestamp;float[4] q;");
    file.format("vehicle_gps_position:uint64_t timestamp;float s_variance_m_s;float vel_m_s;float cog_rad;");
    file.parameter("CAL_MAG0_ID", Value::Int(1));
    file.parameter("MAV_TYPE", Value::Int(vehicle_type));
    for (id, name) in
        ["sensor_mag", "sensor_combined", "vehicle_attitude", "vehicle_gps_position"].iter().enumerate()
    {
        file.subscribe(0, id as u16, name);
    }
    let time_s = drawn.column("t_s").expect("a time");
    let every = (drawn.truth.rate_hz / 5.0).round().max(1.0) as usize;
    for row in 0..time_s.len() {
        let stamp = ((START_US + 1e6 * time_s[row]).round() as u64).to_le_bytes();
        let inertial =
            [floats(three(drawn, "g", "radps", row)), floats(three(drawn, "a", "mps2", row))].concat();
        file.data(1, &[&stamp, &inertial]);
        let q = quaternion(logged_deg(drawn, yaw, row)).map(|part| (part as f32).to_le_bytes()).concat();
        file.data(2, &[&stamp, &q]);
        if row % every == 0 {
            let said = [0.3, SPEED_MPS, course_deg(drawn, row).to_radians()];
            file.data(3, &[&stamp, &floats(said)]);
        }
        let gauss = three(drawn, "m", "ut", row).map(|value| value / 100.0);
        file.data(0, &[&stamp, &7_u32.to_le_bytes(), &floats(gauss)]);
    }
    file.bytes
}

/// The answer, and whether the course contradicts the logged yaw.
fn fitted(log: &Path) -> (Json, bool) {
    let answer = ironout(["fit", text(log), "--json", "--for", "level"]);
    let contradicts = answer
        .stderr
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .contains("differs from the GPS course");
    (answer.json(), contradicts)
}

#[test]
fn the_course_of_a_rover_replaces_a_yaw_that_follows_its_compass() {
    let here = folder("vehicles_course");
    let (mut replaced, mut accepted) = (0, 0);
    for (number, drawn) in cars(CARS).iter().enumerate() {
        for (name, bytes) in [
            (format!("rover_{number}.bin"), ardupilot(drawn, "ArduRover V4.5.7 (2a3dc4b7)", Yaw::OfCompass)),
            (format!("rover_{number}.ulg"), px4(drawn, 10, Yaw::OfCompass)),
        ] {
            let (object, contradicts) = fitted(&write(&here, &name, &bytes));
            if !contradicts {
                // Too few straight stretches.
                continue;
            }
            replaced += 1;
            if object["accepted"] == true {
                let off = errors(&object["offset_ut"], &object["std_errors"]["offset_ut"], offset_ut(drawn));
                assert!(off < MAX_ERRORS, "{name}: the offset is off by {off} standard errors: {object}");
                accepted += 1;
            }
        }
    }
    assert!(replaced >= 4 && accepted >= 4, "{replaced} {accepted}");
}

#[test]
fn a_true_yaw_is_kept_and_what_flies_has_no_course() {
    let here = folder("vehicles_course_kept");
    for (number, drawn) in cars(2).iter().enumerate() {
        for (name, bytes) in [
            (format!("true_{number}.bin"), ardupilot(drawn, "ArduRover V4.5.7 (2a3dc4b7)", Yaw::True)),
            (format!("true_{number}.ulg"), px4(drawn, 10, Yaw::True)),
            (
                format!("copter_{number}.bin"),
                ardupilot(drawn, "ArduCopter V4.5.7 (2a3dc4b7)", Yaw::OfCompass),
            ),
            (format!("copter_{number}.ulg"), px4(drawn, 2, Yaw::OfCompass)),
        ] {
            let (object, contradicts) = fitted(&write(&here, &name, &bytes));
            assert!(!contradicts, "{name}");
            let columns = object.to_string();
            assert_eq!(columns.contains("gps_course_deg"), name.starts_with("true"), "{name}: {columns}");
        }
    }
}
