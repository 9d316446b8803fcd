//! How a log was read: what a reader decided, for the *read as* block and for CAL.json.

use serde::{Deserialize, Serialize};

/// One column of the log, and where it is from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ReadColumn {
    /// Its name in the log that the program works with: `mx_ut`, `ax_mps2`, `motor_a`, …
    pub name: String,
    /// What it is called in the file: a header, `sensor_mag.x`, `MAG.MagX`, `column 3`.
    pub source: String,
    /// The unit there, as in `G`; empty where it has none.
    pub unit: String,
}

/// Which of several sensors was taken.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Instance {
    /// The number of the sensor that was taken, as `--instance` takes it.
    pub taken: usize,
    /// What there is: the number, and what is known of the sensor (its id, its samples).
    pub there: Vec<(usize, String)>,
}

/// Where a log is from, if the file says so.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Origin {
    /// Identifier of the vehicle.
    pub vehicle: Option<String>,
    /// Identifier of the magnetometer.
    pub sensor: Option<String>,
    /// Start of the log, as the file writes it (ISO 8601).
    pub start: Option<String>,
}

/// Rows that are not in the log.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LeftOut {
    /// How many.
    pub rows: usize,
    /// The first line they stood on; `None` in formats without lines.
    pub first_line: Option<u64>,
    /// Why, in words: `no number in the field's columns`.
    pub why: String,
}

/// What was decided while a log was read. Nothing of it is silent: the program prints it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ReadAs {
    /// The format, in words: `CSV`, `table of numbers, semicolons, decimal comma`, `PX4 ULog`.
    pub format: String,
    /// The columns, in the log's order; a vector's three stand one after the other.
    pub columns: Vec<ReadColumn>,
    /// What was undone: an autopilot's calibration, a scale.
    pub taken_out: Vec<String>,
    /// Where the file has several magnetometers.
    pub instance: Option<Instance>,
    /// Whether the axes of two sensors disagree and the magnetometer's may be the wrong ones.
    #[serde(default)]
    pub axes_in_doubt: bool,
    /// Rows left out, and why.
    pub left_out: Vec<LeftOut>,
    /// The options that pin this reading, each an option and its value: `("--map", "mx_ut=MagX")`.
    pub pins: Vec<(String, String)>,
    /// Decisions that no name made, and why: `column 1 is in ms, the only unit that fits`.
    pub reasons: Vec<String>,
    /// Columns that are there and not read, and why.
    pub not_read: Vec<String>,
    /// The repairs that another log of this sensor needs too, as `--repair` takes them.
    #[serde(default)]
    pub repairs: Vec<String>,
    /// Where the log is from.
    #[serde(default)]
    pub origin: Origin,
    /// Whether the file is this program's own CSV, whose lines can be copied as they are.
    pub own_csv: bool,
}
