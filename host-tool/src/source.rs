//! Logs as the command line names them: read, and what was decided about them said on standard error.

use crate::cal_file::CalFile;
use crate::cli::LogArgs;
use crate::failure::Outcome;
use crate::input::{self, Log, ReadOptions};
use crate::read_block;
use std::path::Path;

/// Reads the log and says how, unless `json`: then the caller gives [`read_block::json`] a place in its object.
pub fn read(arguments: &LogArgs, json: bool) -> Outcome<Log> {
    read_with(arguments, None, json)
}

/// The same for a calibration, which knows the scale of the counts that it was fitted to.
///
/// # Errors
/// Those of reading, and a log that is read in another scale or mounting than the calibration's.
pub fn read_for(arguments: &LogArgs, cal: &CalFile, file: &Path, json: bool) -> Outcome<Log> {
    let Some(reading) = &cal.reading else { return read(arguments, json) };
    let log = read_with(arguments, reading.ut_per_count, json)?;
    reading.must_fit(file, &log, &arguments.rotate)?;
    Ok(log)
}

/// Reads a log whose counts may keep their unit: without a scale they are counts of one.
pub fn read_raw(arguments: &LogArgs, json: bool) -> Outcome<Log> {
    read_with(arguments, Some([1.0; 3]), json)
}

fn read_with(arguments: &LogArgs, default_ut_per_count: Option<[f64; 3]>, json: bool) -> Outcome<Log> {
    let log = input::read_log(&arguments.log, &ReadOptions { default_ut_per_count, ..arguments.options()? })?;
    for notice in &log.notices {
        eprintln!("note: {}: {notice}", arguments.log.display());
    }
    if !json {
        eprint!("{}", read_block::text(&log));
    }
    Ok(log)
}
