//! MAVLink telemetry beside `RAW_IMU`: the other messages that hold a compass, and the batteries.

use crate::writers::mavlink::{battery, heartbeat, highres_imu, raw_imu, scaled_imu, status};
use crate::writers::truth::{Truth, assert_column, read, read_with};
use ironout_cli::input::{Log, ReadOptions};

const START_US: u64 = 1_700_000_000_000_000;
const ROWS: usize = 400;

/// Acceleration in mg, turns in mrad/s, field in milligauss.
fn whole(truth: &Truth, row: usize) -> [i16; 9] {
    let accel = truth.accel(row).map(|value| value / 9.806_65 * 1000.0);
    let gyro = truth.gyro(row).map(|value| value * 1000.0);
    let field = truth.field(row).map(|value| value * 10.0);
    let all: Vec<i16> = [accel, gyro, field].concat().iter().map(|value| value.round() as i16).collect();
    all.try_into().expect("nine")
}

fn stamps(truth: &Truth, row: usize) -> (u64, u64) {
    (START_US + truth.micros(row) + (row as u64 % 5) * 700, 7_000_000 + truth.micros(row))
}

/// The first rows, in the numbers of the log that was written; `step` of field, acceleration and turns.
fn assert_is(truth: &Truth, log: &Log, [field, accel, gyro]: [f64; 3]) {
    assert_eq!(log.rows, ROWS);
    let (own_accel, own_gyro) =
        (log.accel_mps2.as_ref().expect("acceleration"), log.gyro_radps.as_ref().expect("turns"));
    for axis in 0..3 {
        assert_column("field", &log.field_ut[axis], |row| truth.field(row)[axis], field);
        assert_column("acceleration", &own_accel[axis], |row| truth.accel(row)[axis], accel);
        assert_column("turns", &own_gyro[axis], |row| truth.gyro(row)[axis], gyro);
    }
    let time = log.time_s.as_ref().expect("a time");
    let first = time[0];
    assert_column("time", time, |row| (truth.micros(row) - truth.micros(0)) as f64 / 1e6 + first, 1.1e-3);
}

#[test]
fn scaled_messages_hold_a_compass_each() {
    let truth = Truth::new("telemetry_scaled");
    for (id, name) in [(26, "SCALED_IMU"), (116, "SCALED_IMU2"), (129, "SCALED_IMU3")] {
        for version in [1, 2] {
            let mut bytes = heartbeat(version, START_US);
            for row in 0..ROWS {
                let (stamp, boot) = stamps(&truth, row);
                bytes.extend(scaled_imu(version, stamp, boot / 1000, id, whole(&truth, row), 2345));
            }
            let log = read(&bytes).unwrap_or_else(|failure| panic!("{name}: {failure}"));
            assert_is(&truth, &log, [0.051, 0.005, 0.001]);
            let source = log.read_as.columns.iter().find(|one| one.name == "mx_ut").expect("a column");
            assert!(source.source.starts_with(&format!("{name}.")), "{}", source.source);
            // The temperature is an extension, which the first version has no room for.
            let warm = log.covariate("imu_c").map(|column| column.values[0]);
            assert_eq!(warm, (version == 2).then_some(23.45), "{name}, version {version}");
        }
    }
}

#[test]
fn a_message_of_high_resolution_is_in_gauss_and_si() {
    let truth = Truth::new("telemetry_highres");
    let mut bytes = heartbeat(2, START_US);
    for row in 0..ROWS {
        let (stamp, boot) = stamps(&truth, row);
        let gauss = truth.field(row).map(|ut| ut / 100.0);
        bytes.extend(highres_imu(2, stamp, boot, [truth.accel(row), truth.gyro(row), gauss], 31.5));
    }
    let log = read(&bytes).expect("telemetry");
    assert_is(&truth, &log, [1e-4, 1e-5, 1e-5]);
    assert!(log.covariate("imu_c").is_some_and(|column| column.values[7] == 31.5));
}

#[test]
fn compasses_of_several_messages_are_told_apart() {
    let truth = Truth::new("telemetry_several");
    let mut bytes = heartbeat(1, START_US);
    for row in 0..ROWS {
        let (stamp, boot) = stamps(&truth, row);
        let own = whole(&truth, row);
        bytes.extend(raw_imu(1, stamp, boot, own));
        // The second at half the rate, with its field the other way round; a third that is not there.
        if row % 2 == 0 {
            let mut turned = own;
            turned[6..].iter_mut().for_each(|value| *value = -*value);
            bytes.extend(scaled_imu(1, stamp, boot / 1000, 116, turned, 0));
            let mut none = own;
            none[6..].fill(0);
            bytes.extend(scaled_imu(1, stamp, boot / 1000, 129, none, 0));
        }
    }
    let log = read(&bytes).expect("telemetry");
    assert_is(&truth, &log, [0.051, 0.005, 0.001]);
    let instance = log.read_as.instance.expect("two of them");
    let there: Vec<&str> = instance.there.iter().map(|(_, words)| words.as_str()).collect();
    assert_eq!(instance.taken, 0, "{there:?}");
    assert!(there.len() == 2 && there[1].contains("SCALED_IMU2, 200 samples"), "{there:?}");
    let second = ReadOptions { instance: Some(1), ..ReadOptions::default() };
    let log = read_with(&bytes, &second).expect("the second");
    assert_eq!(log.rows, ROWS / 2);
    assert_column("field", &log.field_ut[0], |row| -truth.field(2 * row)[0], 0.051);
}

#[test]
fn batteries_are_columns_by_their_numbers_and_what_is_not_known_is_empty() {
    let truth = Truth::new("telemetry_battery");
    let amperes = |row: usize| 2.0 + row as f64 * 0.05;
    for with_status in [false, true] {
        let mut bytes = heartbeat(2, START_US);
        for row in 0..ROWS {
            let (stamp, boot) = stamps(&truth, row);
            bytes.extend(raw_imu(2, stamp, boot, whole(&truth, row)));
            // On time: both say how much flows at the time at which they were received.
            let stamp = START_US + truth.micros(row);
            bytes.extend(battery(2, stamp, 0, Some(amperes(row)), Some(21.5)));
            bytes.extend(battery(2, stamp, 1, Some(0.5 * amperes(row)), None));
            if with_status {
                bytes.extend(status(2, stamp, 16.1, amperes(row)));
            }
        }
        let log = read(&bytes).expect("telemetry");
        let column = |name: &str| log.covariate(name).unwrap_or_else(|| panic!("no {name}: {with_status}"));
        assert_column("current", &column("current_a").values, amperes, 0.006);
        assert_column("current 2", &column("current_2_a").values, |row| 0.5 * amperes(row), 0.006);
        assert_column("battery", &column("battery_c").values, |_| 21.5, 1e-9);
        assert!(log.covariate("battery_2_c").is_none(), "a temperature that nobody measured");
        // One battery that two messages tell of is one column.
        let currents = log.covariates.iter().filter(|column| column.name.ends_with("_a")).count();
        let names: Vec<&str> = log.covariates.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(currents, 2, "{names:?}");
        assert_eq!(log.covariate("voltage_v").is_some(), with_status);
    }
}
