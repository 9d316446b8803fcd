//! The snapshot as a CSV file.

use crate::frozen::row::{HEADER, Row};
use std::io;
use std::path::PathBuf;

/// The snapshot's place in the repository.
pub fn path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/diagnoses.csv"))
}

/// Reads rows that [`text`] wrote.
///
/// # Errors
/// A text that is not such a table.
pub fn rows(text: &str) -> io::Result<Vec<Row>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    if reader.headers()?.iter().ne(HEADER) {
        return Err(io::Error::other("the snapshot has other columns: write it with --accept"));
    }
    let row = |record: csv::StringRecord| {
        let cells: Vec<String> = record.iter().map(str::to_owned).collect();
        Row(cells.try_into().expect("the reader holds every record to the header's length"))
    };
    reader.records().map(|record| Ok(row(record?))).collect()
}

/// Rows as CSV.
///
/// # Errors
/// None that memory could have.
pub fn text(rows: &[Row]) -> io::Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADER)?;
    for row in rows {
        writer.write_record(&row.0)?;
    }
    String::from_utf8(writer.into_inner().map_err(io::Error::other)?).map_err(io::Error::other)
}
