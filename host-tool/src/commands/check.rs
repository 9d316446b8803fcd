//! `ironout check`: is a calibration still good for a new log?

use crate::cal_file::CalFile;
use crate::checked::heading::Headings;
use crate::checked::judge::{Checked, judge};
use crate::cli::CheckArgs;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Outcome};
use crate::output::{line, text};
use crate::source;
use crate::wrap::{WIDTH, hang};
use std::path::Path;

/// Judges the calibration, and prints the result.
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
        say(&checked, &arguments.cal);
    }
    Ok(if checked.is_good() { EXIT_OK } else { EXIT_REFUSED })
}

/// Prints the verdict and its figures. `file` is the calibration's.
fn say(checked: &Checked<'_>, file: &Path) {
    let percent = |ut: f64| ut / checked.field_ut * 100.0;
    let verdict = format!("{}: {}", checked.word.name().to_uppercase(), checked.word.explanation());
    // Through the painter: the first word is coloured.
    text(&(hang(&verdict, "", "  ", WIDTH).join("\n") + "\n"));
    for words in checked.headings.words(checked.declination_given) {
        line(&format!("  {words}"));
    }
    line("");
    line(&format!("{}: {} samples against {}", checked.log.path.display(), checked.samples, file.display()));
    line(&format!("error now             {:9.3} µT  {:6.2} %", checked.rms_ut, percent(checked.rms_ut)));
    line(&format!("error at calibration  {:9.3} µT  {:6.2} %", checked.own_ut, percent(checked.own_ut)));
    line(&format!("limit                 {:9.3} µT  {:6.2} %", checked.limit_ut, percent(checked.limit_ut)));
    if let Some(shift) = checked.known() {
        let [x, y, z] = shift.offset_ut;
        let [sx, sy, sz] = shift.offset_std_ut;
        line(&format!("offset moved by       {x:+.2} ±{sx:.2}  {y:+.2} ±{sy:.2}  {z:+.2} ±{sz:.2} µT"));
        line(&format!(
            "field changed by      {:+9.3} µT  {:+6.2} %",
            shift.field_ut,
            percent(shift.field_ut)
        ));
    }
    if let Headings::Judged(one) = &checked.headings {
        line(&one.line());
    }
    line(&format!("directions covered    {:9.0} %", checked.coverage * 100.0));
    let notices = checked.extrapolation.notices(checked.field_ut);
    notices.iter().chain(&checked.tilted).for_each(|notice| line(&format!("  outside the range: {notice}")));
}
