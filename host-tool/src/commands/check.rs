//! `ironout check`: is a calibration still good for a new log?

use crate::cal_file::CalFile;
use crate::checked::judge::judge;
use crate::cli::CheckArgs;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Outcome};
use crate::output::line;
use crate::source;

/// Judges the calibration, and says so.
pub fn run(arguments: &CheckArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    cal.extended().map_err(|failure| failure.in_file(&arguments.cal))?;
    let log = source::read_for(&arguments.log, &cal, &arguments.cal, json)?;
    let mut notes = Vec::new();
    let checked = judge(&cal, &log, arguments.declination, &mut notes);
    notes.iter().for_each(|note| eprintln!("note: {}: {note}", log.path.display()));
    let checked = checked?;
    if json {
        line(&checked.json().to_string());
    } else {
        checked.say(&arguments.cal);
    }
    Ok(if checked.is_good() { EXIT_OK } else { EXIT_REFUSED })
}
