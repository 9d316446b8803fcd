//! Logs with two magnetometers, as ArduPilot, PX4 and a table have them: `diagnose` says which of them is disturbed.

use crate::common::{folder, ironout, text, write};
use crate::vehicles_flights::{START_US, three};
use crate::writers::dataflash::Cell::{N, T};
use crate::writers::dataflash::Dataflash;
use crate::writers::ulog::{Ulog, Value, floats};
use second_generator::{Drawn, Kind, draw};
use serde_json::Value as Json;
use std::fmt::Write;

/// What the second sensor adds to the true field, µT.
const OFFSET_UT: [f64; 3] = [-14.0, 22.0, 9.0];

/// A log with an offset that follows a column, and the readings of a second sensor, which has none.
fn drawn() -> (Drawn, Vec<[f64; 3]>) {
    let drawn = draw(Kind::PlainOffset, 8500);
    let truth = &drawn.truth;
    let (disturbance, rows) = (truth.disturbance_ut(), truth.field_body_ut.len());
    let clean = |row: usize| {
        let field = truth.field_body_ut[row];
        [0, 1, 2]
            .map(|r: usize| (0..3).map(|c| truth.matrix[r][c] * field[c]).sum::<f64>() + truth.offset_ut[r])
    };
    let other = (0..rows).map(|row| {
        // The noise of the first sensor at another time.
        let at = rows - 1 - row;
        let (read, clean) = (three(&drawn, "m", "ut", at), clean(at));
        let noise = |a: usize| read[a] - clean[a] - disturbance[at][a];
        std::array::from_fn(|a| truth.field_body_ut[row][a] + OFFSET_UT[a] + noise(a))
    });
    let other = other.collect();
    (drawn, other)
}

fn ardupilot(drawn: &Drawn, sensors: [&[[f64; 3]]; 2]) -> Vec<u8> {
    let mut file = Dataflash::new();
    file.message("MSG", &[N(1000.0), T("ArduCopter V4.5.7 (2a3dc4b7)")]);
    let zero = N(0.0);
    for (row, t) in drawn.column("t_s").expect("a time").iter().enumerate() {
        let time = N((START_US + 1e6 * t).round());
        for (number, sensor) in sensors.iter().enumerate() {
            let [mx, my, mz] = sensor[row].map(|axis| N((10.0 * axis).round()));
            let rest = [zero, zero, zero, zero, zero, zero, N(1.0), zero];
            file.message("MAG", &[&[time, N(number as f64), mx, my, mz][..], &rest].concat());
        }
    }
    file.binary
}

fn px4(drawn: &Drawn, sensors: [&[[f64; 3]]; 2]) -> Vec<u8> {
    let mut file = Ulog::new(START_US as u64);
    file.info("sys_name", "PX4");
    file.format("sensor_mag:uint64_t timestamp;uint32_t device_id;float x;float y;float z;");
    file.parameter("CAL_MAG0_ID", Value::Int(7));
    (0..2).for_each(|instance| file.subscribe(instance, u16::from(instance), "sensor_mag"));
    for (row, t) in drawn.column("t_s").expect("a time").iter().enumerate() {
        let stamp = ((START_US + 1e6 * t).round() as u64).to_le_bytes();
        for (number, sensor) in sensors.iter().enumerate() {
            let gauss = sensor[row].map(|value| value / 100.0);
            let device = (number as u32 + 7).to_le_bytes();
            file.data(number as u16, &[&stamp, &device, &floats(gauss)]);
        }
    }
    file.bytes
}

fn csv(drawn: &Drawn, [first, second]: [&[[f64; 3]]; 2]) -> String {
    let mut text = String::from("t_s,mx_ut,my_ut,mz_ut,mx_other_ut,my_other_ut,mz_other_ut\n");
    let time_s = drawn.column("t_s").expect("a time");
    for ((t, [x, y, z]), [a, b, c]) in time_s.iter().zip(first).zip(second) {
        let _ = writeln!(text, "{t:.4},{x:.3},{y:.3},{z:.3},{a:.3},{b:.3},{c:.3}");
    }
    text
}

#[test]
fn the_disturbed_sensor_is_named_in_logs_of_autopilots_and_tables() {
    let here = folder("two_sensors");
    let (drawn, other) = drawn();
    let own: Vec<[f64; 3]> = (0..other.len()).map(|row| three(&drawn, "m", "ut", row)).collect();
    for (sensors, disturbed, words) in [
        ([&own[..], &other[..]], "this", "this one is disturbed, and the other is not: own"),
        ([&other[..], &own[..]], "other", "the other is disturbed, and this one is not: own"),
    ] {
        for (name, bytes) in [
            ("two.bin", ardupilot(&drawn, sensors)),
            ("two.ulg", px4(&drawn, sensors)),
            ("two.csv", csv(&drawn, sensors).into_bytes()),
        ] {
            let log = write(&here, name, bytes);
            let start = ["diagnose", text(&log), "--instance", "0"];
            let options = if name == "two.csv" { &start[..2] } else { &start[..] };
            let json: Json = ironout(options.iter().copied().chain(["--json"])).json();
            assert_eq!(json["pair"]["disturbed"], disturbed, "{name}: {}", json["pair"]);
            // The other magnetometer is evidence, and no candidate.
            assert!(!json["candidates"].to_string().contains("_other_ut"), "{name}: {}", json["candidates"]);
            let said = ironout(options.iter().copied()).stdout;
            let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(said.contains(words), "{name}: {said}");
        }
    }
}
