//! Which format a log has: told by its content, never by its name.

use crate::failure::{Failure, Outcome};
#[cfg(feature = "parquet")]
use crate::input::columnar::{self, Container};
use crate::input::columns;
use crate::input::followed;
use crate::input::formats;
use crate::input::guard::MAX_LINE_BYTES;
use crate::input::lines::{Cutter, Line};
use crate::input::log::{Log, ReadOptions};
use crate::input::own::is_own;
use crate::input::packed::{self, Packing};
use crate::input::reader;
use crate::input::repair_words;
use crate::input::text;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

/// What is looked at: the longest line that a log may have, and its end.
const LOOK_BYTES: u64 = MAX_LINE_BYTES as u64 + 4096;

/// The formats that are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// This program's own CSV.
    Own,
    /// Any other text.
    Text,
    /// A recording of another program, with streams of their own.
    Recording(formats::Format),
    /// Columns of Parquet or Arrow.
    #[cfg(feature = "parquet")]
    Columnar(Container),
    /// What is not a log and is known.
    Foreign(&'static str),
}

/// The words for what a build without the feature `parquet` does not read.
#[cfg(not(feature = "parquet"))]
macro_rules! without_parquet {
    ($what:literal) => {
        concat!(
            $what,
            ", which this build of ironout does not read. Fix: install it with cargo install --path host-tool --features \
             parquet, or save the table as CSV"
        )
    };
}

const FOREIGN: &[(&[u8], &str)] = &[
    (b"PK\x03\x04", "a ZIP archive (or a spreadsheet): unpack it, or save the table as CSV"),
    (b"#ROSBAG V2.0", "a ROS 1 bag: write its topic as CSV with rostopic echo -p -b FILE TOPIC"),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file: write the columns as CSV with writematrix"),
    (b"%PDF", "a PDF"),
    (b"PARE", "an encrypted Parquet file. Fix: write it without encryption"),
    (b"FEA1", "a Feather file of version 1. Fix: write it as version 2, with pyarrow.feather.write_feather"),
    #[cfg(not(feature = "parquet"))]
    (b"PAR1", without_parquet!("a Parquet file")),
    #[cfg(not(feature = "parquet"))]
    (b"ARROW1", without_parquet!("an Arrow (Feather) file")),
];

/// Tells the format by the beginning of the file.
pub fn detect(first: &[u8], options: &ReadOptions) -> Format {
    let begins = |table: &[(&[u8], &'static str)]| {
        table.iter().find(|(magic, _)| first.starts_with(magic)).map(|(_, name)| *name)
    };
    if let Some(format) = formats::detect(first) {
        return Format::Recording(format);
    }
    if let Some(name) = begins(FOREIGN) {
        return Format::Foreign(name);
    }
    #[cfg(feature = "parquet")]
    for (mark, container) in [(&b"PAR1"[..], Container::Parquet), (&b"ARROW1"[..], Container::Arrow)] {
        if first.starts_with(mark) {
            return Format::Columnar(container);
        }
    }
    if first.starts_with(&[0xff, 0xfe]) || first.starts_with(&[0xfe, 0xff]) {
        return Format::Text;
    }
    own(first, options).unwrap_or(Format::Text)
}

/// The first line that is not a comment, and its number; `None` where it does not end, or where there is none: the strict reader says
/// best what is wrong with that.
fn first_row(first: &[u8]) -> Option<(u64, &[u8])> {
    let mut rest = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(first);
    let mut number = 0;
    while !rest.is_empty() {
        number += 1;
        let end = match memchr::memchr(b'\n', rest) {
            Some(end) => end,
            None if first.len() as u64 >= LOOK_BYTES => return None,
            None => rest.len(),
        };
        let (text, tail) = rest.split_at(end);
        let line = Line { text: text.strip_suffix(b"\r").unwrap_or(text), number, ended: true };
        if line.is_row() {
            return Some((number, line.text));
        }
        rest = tail.get(1..).unwrap_or_default();
    }
    None
}

/// Whether the first line is the header of this program's CSV: a whole magnetometer by its own names, or by names that `--map`
/// gives; no column that says which sensor a row is of; and no time under a name of somebody else's.
fn own(first: &[u8], options: &ReadOptions) -> Option<Format> {
    let Some((number, text)) = first_row(first) else { return Some(Format::Own) };
    let mut cutter = Cutter::new();
    let cells = cutter.cut(text);
    if cells > columns::MAX_COLUMNS {
        return Some(Format::Own);
    }
    let header: Vec<String> =
        (0..cells).map(|i| String::from_utf8_lossy(cutter.cell(text, i).trim_ascii()).into_owned()).collect();
    is_own(&header, options, number).then_some(Format::Own)
}

/// Reads the log at `path`; `-` is standard input. Every error names the file, and line and column where there are any.
///
/// # Errors
/// What is not a log, or one that can be read in two ways.
pub fn read_log(path: &Path, options: &ReadOptions) -> Outcome<Log> {
    let in_file = |failure: Failure| if failure.file.is_none() { failure.in_file(path) } else { failure };
    if path == Path::new("-") {
        let mut log = read_stream(std::io::stdin().lock(), 0, options).map_err(in_file)?;
        log.path = path.to_path_buf();
        return Ok(log);
    }
    let file = File::open(path).map_err(|error| Failure::io("open", path, &error))?;
    let metadata = file.metadata().map_err(|error| Failure::io("open", path, &error))?;
    if metadata.is_dir() {
        return Err(Failure::usage("this is a folder. Name a log file").in_file(path));
    }
    let mut log = read_stream(file, metadata.len(), options).map_err(in_file)?;
    log.path = path.to_path_buf();
    Ok(log)
}

/// Reads a log from any source of bytes; `size_bytes` (0: unknown) only sizes buffers and the progress bar.
///
/// # Errors
/// As [`read_log`].
pub fn read_stream(mut source: impl Read, size_bytes: u64, options: &ReadOptions) -> Outcome<Log> {
    let mut first = Vec::new();
    source
        .by_ref()
        .take(packed::MARK_BYTES)
        .read_to_end(&mut first)
        .map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    let Some(packing) = Packing::detect(&first) else {
        return read_plain(Cursor::new(first).chain(source), size_bytes, options);
    };
    let mut unpacked = packing.unpack(Cursor::new(first).chain(source))?;
    // A dynamic source: what is packed in what was packed is read no further.
    let read = read_plain(&mut unpacked as &mut dyn Read, 0, options);
    let mut log = read.map_err(|mut failure| {
        if let Some(why) = unpacked.broken() {
            failure.message = format!(
                "this {} file is truncated or damaged ({why}), and its readable part is not a log: {}. Fix: copy it again",
                packing.name(),
                failure.message
            );
        }
        failure
    })?;
    log.read_as.format = format!("{}, packed by {}", log.read_as.format, packing.name());
    log.read_as.own_csv = false;
    if let Some(why) = unpacked.broken() {
        log.notices
            .push(format!("the packed file is truncated or damaged ({why}). ironout read up to there"));
    }
    Ok(log)
}

/// Whether a file begins as one that `fit -o` writes.
fn is_calibration(first: &[u8]) -> bool {
    let text = String::from_utf8_lossy(first);
    text.trim_start().starts_with('{') && text.contains("\"offset_ut\"") && text.contains("\"matrix\"")
}

fn read_plain(mut source: impl Read, size_bytes: u64, options: &ReadOptions) -> Outcome<Log> {
    let mut first = Vec::new();
    source
        .by_ref()
        .take(LOOK_BYTES)
        .read_to_end(&mut first)
        .map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    if is_calibration(&first) {
        return Err(Failure::usage(
            "this is an ironout calibration, not a log. To use it, run: ironout apply LOG --cal CAL.json",
        ));
    }
    let format = detect(&first, options);
    let whole = Cursor::new(first).chain(source);
    let mut log = match format {
        Format::Own => reader::read_own(whole, size_bytes, options),
        Format::Text => text::read(whole, options),
        Format::Recording(format) => formats::read(format, whole, size_bytes, options),
        #[cfg(feature = "parquet")]
        Format::Columnar(container) => columnar::read(container, whole, options),
        Format::Foreign(what) => Err(Failure::usage(format!("this is not a log but {what}"))),
    }?;
    followed::rename(&mut log);
    if !options.repair.is_empty() {
        let asked: Vec<String> = options.repair.iter().map(repair_words::asked).collect();
        log.read_as.pins.push(("--repair".into(), asked.join(",")));
    }
    Ok(log)
}
