//! MCAP: files that the library of the format writes, messages of the test's own writer, against the CSV they were made from.

use crate::common::write;
use crate::writers::fuzz::fuzz;
use crate::writers::ros::{File, Form, Message};
use crate::writers::truth::{
    Truth, assert_column, assert_same_calibration, assert_sensors, fitted, read, read_with,
};
use ironout_cli::input::ReadOptions;
use mcap::Compression;

const START_NS: u64 = 1_700_000_000_123_456_789;

/// x forward, y right, z down to x forward, y left, z up.
fn up(v: [f64; 3]) -> [f64; 3] {
    [v[0], -v[1], -v[2]]
}

fn flight(truth: &Truth, form: Form, compression: Option<Compression>, frame: &str) -> Vec<u8> {
    let mut file = File::new(form, compression);
    for row in 0..truth.log.rows {
        let stamp = START_NS + truth.micros(row) * 1000;
        // Recorded later than it was measured.
        let log_ns = stamp + 3_000_000 + (row as u64 % 7) * 100_000;
        let message = || Message::new(form, stamp, frame);
        let axes = |v: [f64; 3]| if frame.contains("frd") { v } else { up(v) };
        let mut imu = message().doubles(&[0.0, 0.0, 0.0, 1.0]).doubles(&[-1.0; 9]);
        for v in [truth.gyro(row), truth.accel(row)] {
            imu = imu.doubles(&axes(v)).doubles(&[0.01; 9]);
        }
        file.write("/imu/data", "Imu", log_ns, &imu.finish());
        let tesla = axes(truth.field(row)).map(|value| value * 1e-6);
        let mag = message().doubles(&tesla).doubles(&[0.0; 9]);
        file.write("/imu/mag", "MagneticField", log_ns, &mag.finish());
        if row % 10 == 0 {
            let other = message().doubles(&[1e-5, 2e-5, 3e-5]).doubles(&[0.0; 9]);
            file.write("/other/mag", "MagneticField", log_ns, &other.finish());
            let warm = message().doubles(&[20.0 + row as f64, 0.0]);
            file.write("/imu/temperature", "Temperature", log_ns, &warm.finish());
            let battery = message().floats(&[12.5, 30.0, -(row as f32), 1.0, 5.0, 5.0, 0.9]);
            file.write("/battery", "BatteryState", log_ns, &battery.finish());
            file.write("/camera", "CompressedImage", log_ns, &[7; 500]);
        }
    }
    file.finish()
}

#[test]
fn every_form_gives_what_the_csv_gives() {
    let truth = Truth::new("mcap");
    let own = fitted(&truth.csv, &[]);
    for (form, compression, frame) in [
        (Form::Little, None, "imu_link"),
        (Form::Big, Some(Compression::Zstd), "base_link_frd"),
        (Form::Ros1, Some(Compression::Lz4), "imu"),
    ] {
        let bytes = flight(&truth, form, compression, frame);
        let log = read(&bytes).unwrap_or_else(|failure| panic!("{form:?}: {failure}"));
        assert_sensors(&log, &truth, 1e-9, 0.0, 0.0);
        let column = |name: &str| log.covariate(name).unwrap_or_else(|| panic!("no {name}")).values.clone();
        // Every tenth message, the line between.
        assert_eq!(assert_column("temp_c", &column("temp_c"), |row| 20.0 + row as f64, 1e-3), 2991);
        assert_column("current_a", &column("current_a"), |row| -(row as f64), 1e-3);
        assert_column("voltage_v", &column("voltage_v"), |_| 12.5, 0.0);
        let told = log.read_as.taken_out.join("\n");
        assert_eq!(told.contains("REP 103"), frame != "base_link_frd", "{told}");
        let instance = log.read_as.instance.clone().expect("two topics");
        assert_eq!(instance.taken, 0);
        assert!(instance.there[1].1.contains("/other/mag"), "{instance:?}");
        assert_eq!(log.read_as.format, "MCAP, times of header.stamp");
        assert!(log.notices.is_empty(), "{:?}", log.notices);
        let path = write(&truth.here, "log.mcap", &bytes);
        assert_same_calibration(&own, &fitted(&path, &[]), 1e-6, 1e-7);
    }
    let second = ReadOptions { instance: Some(1), ..ReadOptions::default() };
    let bytes = flight(&truth, Form::Little, None, "imu_link");
    let log = read_with(&bytes, &second).expect("the other topic");
    assert_eq!(log.rows, 300);
    assert!(log.field_ut[1].iter().all(|value| (value + 20.0).abs() < 1e-9));
}

#[test]
fn messages_without_a_stamp_take_the_time_of_recording() {
    let mut file = File::new(Form::Little, None);
    for row in 0..100_u64 {
        let stamp = if row < 50 { 0 } else { START_NS };
        let mag = Message::new(Form::Little, stamp, "")
            .doubles(&[1e-5 * row as f64, 2e-5, 3e-5])
            .doubles(&[0.0; 9]);
        file.write("/mag", "MagneticField", START_NS + row * 20_000_000, &mag.finish());
    }
    let log = read(&file.finish()).expect("a good log");
    assert!(log.read_as.format.contains("times of recording"), "{}", log.read_as.format);
    assert_column("t_s", log.time_s.as_ref().expect("a time"), |row| row as f64 * 0.02, 1e-9);
}

#[test]
fn what_is_cut_off_or_missing_is_said() {
    let truth = Truth::new("mcap-broken");
    let bytes = flight(&truth, Form::Little, Some(Compression::Zstd), "imu_link");
    let log = read(&bytes[..bytes.len() / 2]).expect("half a log");
    assert!(log.rows > 1200 && log.rows < 1800, "{}", log.rows);
    assert!(log.notices.iter().any(|notice| notice.contains("truncated")), "{:?}", log.notices);
    let mut file = File::new(Form::Little, None);
    let imu = Message::new(Form::Little, START_NS, "imu").doubles(&[0.0; 37]);
    file.write("/imu/data", "Imu", START_NS, &imu.finish());
    let refused = read(&file.finish()).expect_err("no magnetometer");
    for part in ["MagneticField", "/imu/data sensor_msgs/msg/Imu (1)", "ros2 bag record"] {
        assert!(refused.message.contains(part), "{refused}");
    }
}

#[test]
fn broken_files_are_answered_or_refused() {
    let truth = Truth::new("mcap-fuzz");
    let cut = |bytes: Vec<u8>| bytes[..bytes.len().min(40_000)].to_vec();
    let plain = cut(flight(&truth, Form::Little, None, "imu_link"));
    let packed = cut(flight(&truth, Form::Big, Some(Compression::Zstd), "imu_link"));
    let lz4 = cut(flight(&truth, Form::Ros1, Some(Compression::Lz4), "imu_link"));
    let accepted = fuzz("MCAP", &[&plain, &packed, &lz4], 4000);
    assert!(accepted > 100, "{accepted}");
}
