//! Blackbox logs of Betaflight and INAV: files of the test's own writer against the CSV they were made from.

use crate::common::{ironout, text, write};
use crate::writers::blackbox::{Row, session};
use crate::writers::fuzz::fuzz;
use crate::writers::truth::{
    Truth, assert_column, assert_same_calibration, assert_sensors, fitted, read, read_with,
};
use ironout_cli::failure::Failure;
use ironout_cli::input::{Log, ReadOptions};

/// Microtesla a count of the test's sensor.
const SCALE: f64 = 0.02;
const BETAFLIGHT: &str = "Betaflight 4.5.1 (77d01ba3b) STM32F405";

fn rows(truth: &Truth) -> Vec<Row> {
    (0..truth.log.rows)
        .map(|row| {
            // From x forward, y right, z down to x forward, y left, z up.
            let counts = |values: [f64; 3], scale: f64| {
                [values[0], -values[1], -values[2]].map(|value| (value * scale).round() as i32)
            };
            let mag = counts(truth.field(row), 1.0 / SCALE);
            let gyro = counts(truth.gyro(row).map(f64::to_degrees), 1000.0);
            let acc = counts(truth.accel(row), 20480.0 / 9.806_65);
            let current = (truth.covariate("current_a", row) * 100.0).round() as i32;
            [
                3_000_000 + truth.micros(row) as i32,
                1600 - row as i32 / 100,
                current,
                mag[0],
                mag[1],
                mag[2],
                gyro[0],
                gyro[1],
                gyro[2],
                acc[0],
                acc[1],
                acc[2],
                1000 + (row % 50) as i32,
            ]
        })
        .collect()
}

fn read_scaled(bytes: &[u8]) -> Result<Log, Failure> {
    read_with(bytes, &ReadOptions { ut_per_count: Some([SCALE; 3]), ..ReadOptions::default() })
}

#[test]
fn a_log_gives_what_its_csv_gives() {
    let truth = Truth::new("blackbox");
    let own = fitted(&truth.csv, &[]);
    let rows = rows(&truth);
    // The frames of newer firmware are written as its header says.
    for firmware in
        [BETAFLIGHT, "INAV 7.1.2 (4e1e59eb) MATEKF405", "Betaflight 2025.12.2 (abcdef012) STM32H743"]
    {
        let bytes = session(firmware, &rows);
        let log = read_scaled(&bytes).unwrap_or_else(|failure| panic!("{firmware}: {failure}"));
        assert_sensors(&log, &truth, SCALE / 2.0 + 1e-9, 3e-4, 1e-5);
        let column = |name: &str| log.covariate(name).unwrap_or_else(|| panic!("no {name}")).values.clone();
        assert_column("current_a", &column("current_a"), |row| truth.covariate("current_a", row), 0.006);
        assert_column("voltage_v", &column("voltage_v"), |row| 16.0 - (row / 100) as f64 / 100.0, 1e-9);
        assert_column("motor_1", &column("motor_1"), |row| 1000.0 + (row % 50) as f64, 0.0);
        assert!(log.counts.is_some() && log.ut_per_count == Some([SCALE; 3]));
        assert_eq!(log.read_as.format, format!("blackbox, {firmware}"));
        assert_eq!(
            log.notices.iter().any(|notice| notice.contains("as the header defines")),
            firmware.contains("2025")
        );
        let path = write(&truth.here, "log.bbl", &bytes);
        let scale = SCALE.to_string();
        assert_same_calibration(&own, &fitted(&path, &["--ut-per-count", &scale]), 0.01, 2e-4);
    }
}

#[test]
fn the_scale_is_asked_for_with_what_it_can_be() {
    let truth = Truth::new("blackbox-scale");
    let bytes = session(BETAFLIGHT, &rows(&truth));
    let path = write(&truth.here, "log.bbl", &bytes);
    let run = ironout(["fit", text(&path), "--json"]);
    let error = run.error();
    let message = error["message"].as_str().expect("a message");
    for part in ["--ut-per-count 0.0333", "QMC5883L", "--ut-per-count 0.3", "implausible"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn sessions_are_told_apart() {
    let truth = Truth::new("blackbox-sessions");
    let rows = rows(&truth);
    // The rest of an erased flash before, a short flight, and a long one.
    let mut bytes = vec![0xff; 300];
    bytes.extend(session(BETAFLIGHT, &rows[..400]));
    bytes.extend(session(BETAFLIGHT, &rows[400..]));
    let log = read_scaled(&bytes).expect("two sessions");
    assert_eq!(log.rows, 2600);
    let instance = log.read_as.instance.expect("two of them");
    assert_eq!((instance.taken, instance.there.len()), (1, 2));
    let first = ReadOptions { instance: Some(0), ut_per_count: Some([SCALE; 3]), ..ReadOptions::default() };
    assert_eq!(read_with(&bytes, &first).expect("the first").rows, 400);
    let third = ReadOptions { instance: Some(2), ..ReadOptions::default() };
    assert!(read_with(&bytes, &third).expect_err("no third").message.contains("--instance 2"));
}

#[test]
fn what_is_cut_off_or_missing_is_said() {
    let truth = Truth::new("blackbox-broken");
    let mut rows = rows(&truth);
    let bytes = session(BETAFLIGHT, &rows);
    let log = read_scaled(&bytes[..bytes.len() / 2]).expect("half a log");
    assert!(log.rows > 1300 && log.rows < 1700, "{}", log.rows);
    assert!(log.notices.iter().any(|notice| notice.contains("no end mark")), "{:?}", log.notices);
    // A sensor that never answered.
    rows.iter_mut().for_each(|row| row[3..6].fill(0));
    let refused = read_scaled(&session(BETAFLIGHT, &rows)).expect_err("no magnetometer");
    for part in ["magADC[0]", "all are zero", "gyroADC[0] (3000)", "mag_hardware"] {
        assert!(refused.message.contains(part), "{refused}");
    }
    let refused = read(&bytes[..200]).expect_err("a header that ends");
    assert!(refused.message.contains("cannot be read"), "{refused}");
}

#[test]
fn broken_files_are_answered_or_refused() {
    let truth = Truth::new("blackbox-fuzz");
    let rows = rows(&truth);
    let (one, newer) =
        (session(BETAFLIGHT, &rows[..150]), session("Betaflight 2025.12.2 (abc) STM32H743", &rows[..150]));
    let accepted = fuzz("blackbox", &[&one, &newer], 4000);
    assert!(accepted > 300, "{accepted}");
}
