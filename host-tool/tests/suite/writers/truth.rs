//! The log that all others are made from, and what is fitted to it.

use crate::common::{folder, ironout, text};
use ironout_cli::input::{Log, ReadOptions, read_log, read_stream};
use std::path::{Path, PathBuf};

/// A simulated log in our own format.
pub struct Truth {
    pub log: Log,
    pub csv: PathBuf,
    pub here: PathBuf,
}

impl Truth {
    /// 60 s at 50 Hz in a folder of that name, strong hard and soft iron, all sensors.
    pub fn new(name: &str) -> Self {
        let here = folder(name);
        let csv = here.join("own.csv");
        let run = ironout(["simulate", "-o", text(&csv), "--seed", "11", "--seconds", "60", "--rate", "50"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        let log = read_log(&csv, &ReadOptions::default()).expect("our own log");
        assert!(log.accel_mps2.is_some() && log.gyro_radps.is_some() && log.rows == 3000);
        Truth { log, csv, here }
    }

    /// Microseconds of a row.
    pub fn micros(&self, row: usize) -> u64 {
        (self.log.time_s.as_ref().expect("a time")[row] * 1e6).round() as u64
    }

    pub fn field(&self, row: usize) -> [f64; 3] {
        self.log.field(row)
    }

    pub fn accel(&self, row: usize) -> [f64; 3] {
        let columns = self.log.accel_mps2.as_ref().expect("an accelerometer");
        [0, 1, 2].map(|axis| columns[axis][row])
    }

    pub fn gyro(&self, row: usize) -> [f64; 3] {
        let columns = self.log.gyro_radps.as_ref().expect("a gyroscope");
        [0, 1, 2].map(|axis| columns[axis][row])
    }

    pub fn covariate(&self, name: &str, row: usize) -> f64 {
        self.log.covariate(name).unwrap_or_else(|| panic!("no {name}")).values[row]
    }
}

/// Reads bytes of any format.
pub fn read(bytes: &[u8]) -> Result<Log, ironout_cli::failure::Failure> {
    read_with(bytes, &ReadOptions::default())
}

pub fn read_with(bytes: &[u8], options: &ReadOptions) -> Result<Log, ironout_cli::failure::Failure> {
    read_stream(bytes, bytes.len() as u64, options)
}

/// What the program fits.
pub fn fitted(log: &Path, options: &[&str]) -> serde_json::Value {
    let run = ironout(["fit", text(log), "--json"].iter().chain(options));
    assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
    run.json()
}

/// Offset and matrix agree: `offset_ut` in µT, `matrix` in parts.
pub fn assert_same_calibration(a: &serde_json::Value, b: &serde_json::Value, offset_ut: f64, matrix: f64) {
    for axis in 0..3 {
        let of = |value: &serde_json::Value| value["offset_ut"][axis].as_f64().expect("a number");
        assert!((of(a) - of(b)).abs() <= offset_ut, "offset {axis}: {} and {}", of(a), of(b));
        for column in 0..3 {
            let of = |value: &serde_json::Value| value["matrix"][axis][column].as_f64().expect("a number");
            assert!((of(a) - of(b)).abs() <= matrix, "matrix {axis},{column}: {} and {}", of(a), of(b));
        }
    }
}

/// Every row of two columns agrees to `tolerance`; gives how many rows had a value.
pub fn assert_column(name: &str, found: &[f64], expected: impl Fn(usize) -> f64, tolerance: f64) -> usize {
    let mut seen = 0;
    for (row, value) in found.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        assert!(
            (value - expected(row)).abs() <= tolerance,
            "{name} in row {row}: {value}, expected {}",
            expected(row)
        );
        seen += 1;
    }
    seen
}

/// Field, accelerometer, gyroscope and time are those of the truth, in every row.
pub fn assert_sensors(log: &Log, truth: &Truth, field_ut: f64, accel: f64, gyro: f64) {
    assert_eq!(log.rows, truth.log.rows);
    let time = log.time_s.as_ref().expect("a time");
    let step = |times: &[f64], row: usize| times[row] - times[0];
    let own = truth.log.time_s.as_ref().expect("a time");
    assert_column(
        "t_s",
        &(0..log.rows).map(|row| step(time, row)).collect::<Vec<_>>(),
        |row| step(own, row),
        2e-6,
    );
    for axis in 0..3 {
        assert_column("field", &log.field_ut[axis], |row| truth.field(row)[axis], field_ut);
        let column = &log.accel_mps2.as_ref().expect("an accelerometer")[axis];
        assert_eq!(assert_column("accel", column, |row| truth.accel(row)[axis], accel), log.rows);
        let column = &log.gyro_radps.as_ref().expect("a gyroscope")[axis];
        assert_eq!(assert_column("gyro", column, |row| truth.gyro(row)[axis], gyro), log.rows);
    }
}

/// The matrix product with a vector.
pub fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Whether a Python module is there; says that a check is skipped where it is not.
pub fn python_has(module: &str) -> bool {
    use std::io::Write;
    let probe = std::process::Command::new("python3").args(["-c", &format!("import {module}")]).output();
    let has = probe.is_ok_and(|output| output.status.success());
    if !has {
        let _ = writeln!(std::io::stderr(), "SKIPPED: reading back with {module}, which is not installed");
    }
    has
}

/// What a Python program prints.
pub fn python(program: &str, file: &Path) -> String {
    let output =
        std::process::Command::new("python3").args(["-c", program, text(file)]).output().expect("python3");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}
