//! The table as Parquet: the columns of the CSV, with types.

use crate::commands::batch::row::{Cell, Row};
use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt64Array};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use std::io::{self, Write};
use std::sync::Arc;

/// Writes the rows as Parquet.
pub(super) fn write_parquet(out: &mut dyn Write, rows: &[&Row]) -> io::Result<()> {
    let cells: Vec<Vec<(String, Cell)>> = rows.iter().map(|row| row.cells()).collect();
    // A fleet without rows has the columns too.
    let columns = Row::default().cells().into_iter().enumerate().map(|(index, (name, kind))| {
        let column: Vec<&Cell> =
            cells.iter().filter_map(|row| row.get(index)).map(|(_, cell)| cell).collect();
        (name, array(&kind, &column), true)
    });
    let batch = RecordBatch::try_from_iter_with_nullable(columns).map_err(io::Error::other)?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut file = Vec::new();
    let mut writer =
        ArrowWriter::try_new(&mut file, batch.schema(), Some(properties)).map_err(io::Error::other)?;
    writer.write(&batch).map_err(io::Error::other)?;
    writer.close().map_err(io::Error::other)?;
    out.write_all(&file)
}

/// The cells of one column, all of the kind of `kind`.
fn array(kind: &Cell, cells: &[&Cell]) -> ArrayRef {
    match kind {
        Cell::Text(_) => Arc::new(StringArray::from_iter(cells.iter().map(|cell| match cell {
            Cell::Text(text) => text.as_deref(),
            _ => None,
        }))),
        Cell::Count(_) => Arc::new(UInt64Array::from_iter(cells.iter().map(|cell| match cell {
            Cell::Count(count) => *count,
            _ => None,
        }))),
        Cell::Number(_) => Arc::new(Float64Array::from_iter(cells.iter().map(|cell| match cell {
            Cell::Number(number) => *number,
            _ => None,
        }))),
        Cell::Flag(_) => Arc::new(BooleanArray::from_iter(cells.iter().map(|cell| match cell {
            Cell::Flag(flag) => *flag,
            _ => None,
        }))),
    }
}
