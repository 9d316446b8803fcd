//! One log of the frozen set, and what is known of its truth.

use ironout_analysis::Table;
use ironout_cli::input::Log;
use std::error::Error;

/// What was hidden in a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Hidden {
    /// Nobody knows: a recording, or a log of somebody's.
    Unknown,
    /// These effects and no other; none at all where the list is empty.
    Effects(Vec<String>),
    /// These effects were put into a real recording, which may have causes of its own.
    Injected(Vec<String>),
    /// An effect whose column is not in the log: `drift` and `step` blame nobody, and `complete` is a false claim.
    ColumnMissing,
}

/// The rows of a log.
#[derive(Debug, Clone)]
pub enum Rows {
    /// Columns by name, units as in the log format.
    Columns(Vec<(String, Vec<f64>)>),
    /// A file as the program reads it.
    Read(Box<Log>),
}

impl Rows {
    /// Prints the columns as CSV.
    pub fn print(&self) -> Result<(), Box<dyn Error>> {
        let Rows::Columns(columns) = self else { return Err("this log is a file beside the project".into()) };
        let mut writer = csv::Writer::from_writer(std::io::stdout().lock());
        writer.write_record(columns.iter().map(|(name, _)| name))?;
        for row in 0..columns.first().map_or(0, |(_, values)| values.len()) {
            writer.write_record(columns.iter().map(|(_, values)| match values[row] {
                value if value.is_nan() => String::new(),
                value => value.to_string(),
            }))?;
        }
        Ok(writer.flush()?)
    }

    /// The rows as the analysis takes them; `None` without a magnetometer.
    pub fn table(&self) -> Option<Table<'_>> {
        match self {
            Rows::Columns(columns) => {
                let named = columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
                Table::from_columns(named).ok()
            }
            Rows::Read(log) => Some(Table::from(log.as_ref())),
        }
    }
}

/// A log that was made or read.
#[derive(Debug, Clone)]
pub struct Made {
    /// Its rows.
    pub rows: Rows,
    /// What was hidden.
    pub hidden: Hidden,
    /// The true field in the body frame, µT, one a row; `None` where nobody knows it.
    pub body_field_ut: Option<Vec<[f64; 3]>>,
}

/// How one log is made: it costs nothing until it is asked for.
pub struct Entry {
    /// The set that it belongs to.
    pub set: String,
    /// Its name within the set.
    pub log: String,
    /// Makes it; an error says why the program cannot read it.
    pub make: Box<dyn Fn() -> Result<Made, String> + Send + Sync>,
}

impl Entry {
    /// An entry of a set.
    pub fn new(
        set: &str,
        log: impl Into<String>,
        make: impl Fn() -> Result<Made, String> + Send + Sync + 'static,
    ) -> Entry {
        Entry { set: set.to_owned(), log: log.into(), make: Box::new(make) }
    }
}
