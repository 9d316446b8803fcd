//! What was decided about a table, before its numbers are taken.

use crate::input::read_as::Instance;
use crate::input::text::program::Program;
use crate::input::unit::Unit;

/// One column that is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// Its index in the table.
    pub column: usize,
    /// Its name in the log that the program works with.
    pub name: String,
    /// The unit in the file; `None` for counts and for what is read as it is.
    pub unit: Option<Unit>,
}

/// All that was decided.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Choice {
    /// The columns, in the log's order.
    pub taken: Vec<Taken>,
    /// The rows of the sensor that was chosen.
    pub rows: Vec<usize>,
    /// Where there are several magnetometers.
    pub instance: Option<Instance>,
    /// Whether the instance has to be named to read the same again.
    pub pin_instance: bool,
    /// The program whose table it is.
    pub program: Option<Program>,
    /// Columns whose sum is in the field, and taken out of it.
    pub added: Vec<[usize; 3]>,
    /// Decisions that the names did not make, and why they were made.
    pub reasons: Vec<String>,
    /// Columns that are known and are neither sensors nor causes.
    pub set_aside: Vec<usize>,
    /// What is not read, and why.
    pub not_read: Vec<String>,
}

impl Choice {
    /// Whether a column is read already.
    pub fn has(&self, column: usize) -> bool {
        self.taken.iter().any(|taken| taken.column == column)
    }

    /// Whether a name is taken already.
    pub fn has_name(&self, name: &str) -> bool {
        self.taken.iter().any(|taken| taken.name == name)
    }

    /// Takes three columns by the names of a sensor.
    pub fn take(&mut self, columns: [usize; 3], names: [&str; 3], unit: Option<&Unit>) {
        for (column, name) in columns.into_iter().zip(names) {
            self.taken.push(Taken { column, name: name.to_string(), unit: unit.cloned() });
        }
    }
}

/// The names of a log in microtesla.
pub const FIELD_UT: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
/// The names of a log in counts.
pub const FIELD_COUNTS: [&str; 3] = ["mx_counts", "my_counts", "mz_counts"];
/// The accelerometer's.
pub const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
/// The gyroscope's.
pub const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];
