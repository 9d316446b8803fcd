//! From the bytes of a Parquet or Arrow file to a [`Log`].

use crate::failure::{Failure, Outcome};
use crate::input::columnar::caught::caught;
use crate::input::columnar::cells::{append, unreadable};
use crate::input::columns::MAX_COLUMNS;
use crate::input::log::{Log, ReadOptions};
use crate::input::memory::from_table;
use crate::input::read_as::Origin;
use crate::input::text::GridColumn;
use crate::input::words::shorten;
use arrow_array::RecordBatch;
use arrow_ipc::reader::FileReader;
use arrow_schema::{Schema, SchemaRef};
use bytes::Bytes;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::fmt::Display;
use std::io::{Cursor, Read};

/// Rows that are decoded at once.
const BATCH_ROWS: usize = 1 << 16;

/// How a file holds its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Container {
    /// Apache Parquet.
    Parquet,
    /// Arrow IPC, also called Feather version 2.
    Arrow,
}

impl Container {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Container::Parquet => "Parquet",
            Container::Arrow => "Arrow (Feather)",
        }
    }

    fn damaged(self, why: impl Display) -> Failure {
        // The crates' words for a compression that was not built.
        if why.to_string().contains("isabled feature") {
            return Failure::usage(format!(
                "this {} file has a compression that is not supported. Fix: write it with snappy, zstd, gzip or lz4",
                self.name()
            ));
        }
        Failure::usage(format!(
            "this {} file is truncated or damaged ({}). Fix: copy it again",
            self.name(),
            shorten(&why.to_string())
        ))
    }
}

type Batches = Box<dyn Iterator<Item = Result<RecordBatch, String>>>;

/// Reads the log in a file of columns. The whole file is held in memory: its index stands at its end.
///
/// # Errors
/// A damaged file, and what a text log with these columns has for errors.
pub fn read(container: Container, mut source: impl Read, options: &ReadOptions) -> Outcome<Log> {
    let mut bytes = Vec::new();
    source.read_to_end(&mut bytes).map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    let (schema, columns) =
        caught(|| content(container, bytes.into())).map_err(|why| container.damaged(why))?;
    if schema.fields().len() > MAX_COLUMNS {
        let columns = schema.fields().len();
        return Err(Failure::usage(format!(
            "{columns} columns, at most {MAX_COLUMNS} are read: is this a log?"
        )));
    }
    let left_out: Vec<String> = schema
        .fields()
        .iter()
        .filter_map(|field| Some((field.name(), unreadable(field.data_type())?)))
        .map(|(name, what)| match what {
            "of a type" => format!("column {}: its type is not supported. Fix: write it as numbers", shorten(name)),
            what => format!(
                "column {}: each cell is {what}. Fix: write its numbers as columns of their own, such as mx_ut, my_ut, mz_ut",
                shorten(name)
            ),
        })
        .collect();
    let mut log = from_table(columns, container.name(), options)
        .map_err(|failure| explained(by_row(failure), &left_out))?;
    log.notices.extend(left_out.into_iter().map(|what| format!("ignored {what}")));
    log.read_as.left_out.iter_mut().for_each(|entry| entry.first_line = None);
    log.read_as.origin = origin(&schema);
    Ok(log)
}

/// The schema, and the columns that can be read; none of them if there are too many.
fn content(container: Container, bytes: Bytes) -> Result<(SchemaRef, Vec<GridColumn>), String> {
    let (schema, batches) = match container {
        Container::Parquet => parquet(bytes),
        Container::Arrow => arrow(bytes),
    }?;
    if schema.fields().len() > MAX_COLUMNS {
        return Ok((schema, Vec::new()));
    }
    let kept = readable(&schema).into_iter();
    let mut columns: Vec<GridColumn> =
        kept.map(|index| GridColumn::new(schema.field(index).name().clone())).collect();
    for batch in batches {
        for (column, array) in columns.iter_mut().zip(batch?.columns()) {
            append(column, array);
        }
    }
    Ok((schema, columns))
}

fn readable(schema: &Schema) -> Vec<usize> {
    let fields = schema.fields().iter().enumerate();
    fields.filter(|(_, field)| unreadable(field.data_type()).is_none()).map(|(index, _)| index).collect()
}

fn parquet(bytes: Bytes) -> Result<(SchemaRef, Batches), String> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(bytes).map_err(|error| error.to_string())?;
    let schema = builder.schema().clone();
    let mask = ProjectionMask::roots(builder.parquet_schema(), readable(&schema));
    let reader = builder
        .with_projection(mask)
        .with_batch_size(BATCH_ROWS)
        .build()
        .map_err(|error| error.to_string())?;
    Ok((schema, Box::new(reader.map(|batch| batch.map_err(|error| error.to_string())))))
}

fn arrow(bytes: Bytes) -> Result<(SchemaRef, Batches), String> {
    let open = |projection| {
        FileReader::try_new(Cursor::new(bytes.clone()), projection).map_err(|error| error.to_string())
    };
    let schema = open(None)?.schema();
    let reader = open(Some(readable(&schema)))?;
    Ok((schema, Box::new(reader.map(|batch| batch.map_err(|error| error.to_string())))))
}

/// These files have rows and not lines; rows count from 1.
fn by_row(mut failure: Failure) -> Failure {
    if let Some(row) = failure.line.take().and_then(|line| line.checked_sub(1)).filter(|row| *row > 0) {
        failure.message = format!("row {row}: {}", failure.message);
    }
    failure
}

/// With the columns that are not read, in which the missing numbers may be.
fn explained(mut failure: Failure, left_out: &[String]) -> Failure {
    for what in left_out {
        failure.message.push_str(&format!("\n  not read: {what}"));
    }
    failure
}

/// Vehicle, sensor and start, if the file's metadata name them.
fn origin(schema: &Schema) -> Origin {
    let text = |key: &str| schema.metadata().get(key).cloned();
    Origin { vehicle: text("vehicle"), sensor: text("sensor"), start: text("start") }
}
