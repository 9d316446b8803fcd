//! The columns of a `cov` line.

use crate::effect::ColumnName;
use crate::number::read;
use heapless::Vec;

/// The most columns of one line: accelerometer and gyro.
pub const MAX_ASSIGNMENTS: usize = 6;

/// What a column becomes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Assigned {
    /// This, until it is fed again.
    Value(f64),
    /// Not known, and not tested any more.
    Forgotten,
    /// What the board itself measures, and tested.
    Own,
}

/// Columns and what they become.
pub type Assignments = Vec<(ColumnName, Assigned), MAX_ASSIGNMENTS>;

const USAGE: &str = "cov NAME=VALUE: a number, - to forget the column, or on to test one that the board measures, as in cov \
     temp_c=31.5";

/// Reads all of them, or none.
pub(super) fn assignments<'a>(words: impl Iterator<Item = &'a str>) -> Result<Assignments, &'static str> {
    let mut list = Assignments::new();
    for word in words {
        let (name, value) = word.split_once('=').ok_or(USAGE)?;
        let name = ColumnName::new(name).map_err(|_| USAGE)?;
        let value = match value {
            "-" => Assigned::Forgotten,
            "on" => Assigned::Own,
            number => {
                let value = read(number).ok_or(USAGE)?;
                // It is kept in single precision.
                Some(value).filter(|value| (*value as f32).is_finite()).ok_or(USAGE).map(Assigned::Value)?
            }
        };
        if list.iter().any(|(known, _)| *known == name) {
            return Err("a column may appear only once in a line of cov");
        }
        list.push((name, value)).map_err(|_| "a line of cov has at most six columns")?;
    }
    if list.is_empty() { Err(USAGE) } else { Ok(list) }
}
