//! Logs as the command line names them: read, their notices passed on to standard error.

use crate::cal_file::CalFile;
use crate::cli::LogArgs;
use crate::failure::Outcome;
use crate::input::{self, Log, ReadOptions};
use std::path::Path;

/// Reads the log and passes its notices on.
pub fn read(arguments: &LogArgs) -> Outcome<Log> {
    read_with(arguments, None)
}

/// The same for a calibration, which knows the scale of the counts that it was fitted to.
///
/// # Errors
/// Those of reading, and a log that is read in another scale or mounting than the calibration's.
pub fn read_for(arguments: &LogArgs, cal: &CalFile, file: &Path) -> Outcome<Log> {
    let Some(reading) = &cal.reading else { return read(arguments) };
    let log = read_with(arguments, reading.ut_per_count)?;
    reading.must_fit(file, &log, &arguments.rotate)?;
    Ok(log)
}

fn read_with(arguments: &LogArgs, default_ut_per_count: Option<[f64; 3]>) -> Outcome<Log> {
    let log = input::read_log(&arguments.log, &ReadOptions { default_ut_per_count, ..arguments.options()? })?;
    for notice in &log.notices {
        eprintln!("note: {}: {notice}", arguments.log.display());
    }
    Ok(log)
}
