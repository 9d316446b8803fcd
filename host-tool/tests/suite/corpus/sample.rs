//! The simulated log, and a sample of it in one format.

use ironout_cli::input::{Log, ReadOptions, read_stream};
use ironout_simulation::{World, WorldOptions};

/// One row of the simulated log, in the units of the format.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub t: f64,
    pub m: [f64; 3],
    pub a: [f64; 3],
    pub g: [f64; 3],
    pub temp: f64,
}

/// A log in one format.
pub struct Sample {
    pub name: &'static str,
    pub bytes: Vec<u8>,
    /// The last digit of the field in this format, µT.
    pub step_ut: f64,
    /// The last digit of the accelerometer, m/s²; `None` where the format has none (or no unit for it).
    pub accel_step: Option<f64>,
    /// Whether it has time, and the gyroscope in a unit that is known.
    pub timed: bool,
    pub gyro: bool,
    /// `--ut-per-count`.
    pub scale: Option<f64>,
    /// `--instance`.
    pub instance: Option<usize>,
    /// `--map`, where the format itself leaves a question.
    pub map: &'static [&'static str],
}

impl Sample {
    pub fn new(name: &'static str, text: impl Into<Vec<u8>>, step_ut: f64) -> Sample {
        Sample {
            name,
            bytes: text.into(),
            step_ut,
            accel_step: None,
            timed: true,
            gyro: false,
            scale: None,
            instance: None,
            map: &[],
        }
    }

    pub fn accel(mut self, step: f64) -> Sample {
        self.accel_step = Some(step);
        self
    }

    pub fn gyro(mut self) -> Sample {
        self.gyro = true;
        self
    }

    pub fn untimed(mut self) -> Sample {
        self.timed = false;
        self
    }

    pub fn scale(mut self, scale: f64) -> Sample {
        self.scale = Some(scale);
        self
    }

    pub fn instance(mut self, number: usize) -> Sample {
        self.instance = Some(number);
        self
    }

    pub fn map(mut self, map: &'static [&'static str]) -> Sample {
        self.map = map;
        self
    }

    pub fn options(&self) -> ReadOptions {
        let map: Vec<String> = self.map.iter().map(|part| part.to_string()).collect();
        ReadOptions {
            map: ironout_cli::input::parse_map(&map).expect("a map"),
            ut_per_count: self.scale.map(|scale| [scale; 3]),
            instance: self.instance,
            ..ReadOptions::default()
        }
    }

    pub fn read(&self) -> Result<Log, String> {
        read_stream(self.bytes.as_slice(), self.bytes.len() as u64, &self.options())
            .map_err(|failure| format!("{}: {failure}\n{}", self.name, self.head()))
    }

    pub fn head(&self) -> String {
        String::from_utf8_lossy(&self.bytes).lines().take(6).collect::<Vec<_>>().join("\n")
    }
}

/// The rows of the simulated log: 30 s at 50 Hz.
pub fn rows() -> Vec<Row> {
    let log = World::new(WorldOptions { seed: 11, seconds: 30.0, ..WorldOptions::default() }).run();
    let column = |name: &str| log.column(name).unwrap_or_else(|| panic!("no {name}")).to_vec();
    let triple = |names: [&str; 3]| names.map(column);
    let (t, temp) = (column("t_s"), column("temp_c"));
    let (m, a, g) = (
        triple(["mx_ut", "my_ut", "mz_ut"]),
        triple(["ax_mps2", "ay_mps2", "az_mps2"]),
        triple(["gx_radps", "gy_radps", "gz_radps"]),
    );
    let of = |axes: &[Vec<f64>; 3], row: usize| [axes[0][row], axes[1][row], axes[2][row]];
    (0..log.rows())
        .map(|row| Row { t: t[row], m: of(&m, row), a: of(&a, row), g: of(&g, row), temp: temp[row] })
        .collect()
}

/// A line a row.
pub fn lines(rows: &[Row], mut line: impl FnMut(usize, &Row) -> String) -> String {
    rows.iter().enumerate().map(|(index, row)| line(index, row) + "\n").collect()
}

/// `12:34:56.789` after that many seconds.
pub fn of_day(seconds: f64) -> String {
    let ms = (seconds * 1e3).round() as u64 % 86_400_000;
    format!("{:02}:{:02}:{:02}.{:03}", ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000)
}

/// MotionCal's nine whole numbers.
pub fn nine(r: &Row, between: &str) -> String {
    let a = r.a.map(|v| v * 8192.0 / 9.80665);
    let g = r.g.map(|v| v.to_degrees() * 16.0);
    let m = r.m.map(|v| v * 10.0);
    let cells: Vec<String> = a.iter().chain(&g).chain(&m).map(|v| format!("{v:.0}")).collect();
    cells.join(between)
}
