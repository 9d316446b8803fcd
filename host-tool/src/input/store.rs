//! One column while a log is read.

use crate::failure::{Failure, Outcome};
use crate::input::columns::{Column, Role};
use crate::input::number;
use crate::input::words::shorten;

/// The values of one column, and what was wrong with them.
pub struct Store {
    /// Name and role.
    pub column: Column,
    /// The header as it stands in the file.
    pub header: String,
    /// One value a row; empty once the column is text or was never wanted.
    pub values: Vec<f64>,
    /// Empty cells.
    pub empty: usize,
    /// NaN and infinities written out.
    pub not_finite: usize,
    /// The first text in a column that may be text: line and cell.
    pub text: Option<(u64, String)>,
}

impl Store {
    /// An empty column with room for `rows`.
    pub fn new(column: Column, header: String, rows: usize) -> Self {
        let rows = if column.role == Role::Unnamed { 0 } else { rows };
        Store { column, header, values: Vec::with_capacity(rows), empty: 0, not_finite: 0, text: None }
    }

    /// Takes one cell. `strict` columns (time, magnetometer) accept finite numbers only.
    pub fn push(&mut self, cell: &[u8], strict: bool, line: u64) -> Outcome<()> {
        if self.text.is_some() || self.column.role == Role::Unnamed {
            return Ok(());
        }
        let value = match number::parse(cell) {
            Some(value) if value.is_finite() => value,
            _ if strict => return Err(self.objection(cell, line)),
            Some(value) => {
                self.not_finite += 1;
                value
            }
            None if cell.trim_ascii().is_empty() => {
                self.empty += 1;
                f64::NAN
            }
            None => {
                self.text = Some((line, shorten(&String::from_utf8_lossy(cell))));
                self.values = Vec::new();
                return Ok(());
            }
        };
        self.values.push(value);
        Ok(())
    }

    /// Takes a whole column; NaN is an empty cell.
    pub fn fill(&mut self, values: Vec<f64>, strict: bool) -> Outcome<()> {
        if self.column.role == Role::Unnamed {
            return Ok(());
        }
        if strict && let Some(row) = values.iter().position(|value| !value.is_finite()) {
            // The first row stands below the header.
            let cell = if values[row].is_nan() { String::new() } else { values[row].to_string() };
            return Err(self.objection(cell.as_bytes(), row as u64 + 2));
        }
        self.empty = values.iter().filter(|value| value.is_nan()).count();
        self.not_finite = values.iter().filter(|value| value.is_infinite()).count();
        self.values = values;
        Ok(())
    }

    fn objection(&self, cell: &[u8], line: u64) -> Failure {
        let text = shorten(&String::from_utf8_lossy(cell.trim_ascii()));
        let what = match self.column.role {
            Role::Time => "time",
            _ => "the magnetometer",
        };
        let message = if text.is_empty() {
            format!(
                "the cell is empty, but {what} needs a number in every row. Remove the row, or repeat the last reading"
            )
        } else if number::parse(cell).is_some() {
            format!("\"{text}\" is not a finite number, but {what} needs one in every row. Remove the row")
        } else {
            format!("\"{text}\" is not a number. Correct the cell or remove the row")
        };
        Failure::usage(message).at_line(line).at_column(self.header.clone())
    }
}
