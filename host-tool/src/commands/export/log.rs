//! The log that tells what a target costs, read as that of the calibration was.

use crate::cal_file::CalFile;
use crate::cli::{ExportArgs, LogArgs};
use crate::failure::Outcome;
use crate::input::Log;
use crate::source;

/// The log of `--log`, if it is given.
pub fn read(arguments: &ExportArgs, cal: &CalFile, json: bool) -> Outcome<Option<Log>> {
    let Some(path) = &arguments.log else { return Ok(None) };
    let log = LogArgs {
        map: arguments.map.clone(),
        rotate: cal.reading.as_ref().map_or_else(Vec::new, |reading| reading.rotate.clone()),
        ..LogArgs::of(path)
    };
    source::read_for(&log, cal, &arguments.cal, json).map(Some)
}
