//! A log, and the truth behind it.

use crate::effects::HiddenEffect;
use std::io::{self, Write};

/// What only the simulator knows about a log.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Hard iron, µT.
    pub hard_iron_ut: [f64; 3],
    /// Rows of the soft-iron matrix.
    pub soft_iron: [[f64; 3]; 3],
    /// Magnitude of the field, µT.
    pub field_ut: f64,
    /// Standard deviation of the noise on each axis with the quantisation's share, µT.
    pub noise_ut: f64,
    /// The hidden effects.
    pub effects: Vec<HiddenEffect>,
    /// True field in the body frame, one a row, before any fault that removes rows.
    pub body_field_ut: Vec<[f64; 3]>,
}

/// A log: named columns of equal length. A missing cell is NaN.
#[derive(Clone, Debug)]
pub struct Log {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Values, by column.
    pub columns: Vec<Vec<f64>>,
    /// The truth behind them.
    pub truth: Truth,
}

impl Log {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Where a column stands.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|column| column == name)
    }

    /// A column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.position(name).map(|index| self.columns[index].as_slice())
    }

    /// Names and values, column by column.
    pub fn named(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.names.iter().map(String::as_str).zip(self.columns.iter().map(Vec::as_slice))
    }

    /// Writes the log as CSV: a `#` line that names the source, a header, one line a row.
    pub fn write_csv(&self, mut out: impl Write, comment: &str) -> io::Result<()> {
        for line in comment.lines() {
            writeln!(out, "# {line}")?;
        }
        writeln!(out, "{}", self.names.join(","))?;
        for row in 0..self.rows() {
            for (index, column) in self.columns.iter().enumerate() {
                let value = column[row];
                if index > 0 {
                    write!(out, ",")?;
                }
                if value.is_finite() {
                    write!(out, "{value:.5}")?;
                }
            }
            writeln!(out)?;
        }
        Ok(())
    }
}
