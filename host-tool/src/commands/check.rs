//! `ironout check`: is a calibration still good for a new log?

use crate::cal_file::CalFile;
use crate::checked::heading::Headings;
use crate::checked::judge::{Checked, judge};
use crate::cli::CheckArgs;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Outcome};
use crate::field_unit::{fixed, signed, symbol, vector_with_errors};
use crate::output::{line, text};
use crate::source;
use crate::wrap::{WIDTH, hang};
use ironout_analysis::base::heading::HeadingError;
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
    let unit = symbol();
    for (label, ut) in [
        ("error now", checked.rms_ut),
        ("error at calibration", checked.cal.fit.rms_ut.unwrap_or(0.0)),
        ("limit", checked.limit_ut),
    ] {
        line(&format!("{label:<20}  {:>9} {unit}  {:6.2} %", fixed(Some(ut), 3), percent(ut)));
    }
    if let Some(shift) = checked.known() {
        line(&format!("offset moved by       {}", vector_with_errors(shift.offset_ut, shift.offset_std_ut)));
        line(&format!(
            "field changed by      {:>9} {unit}  {:+6.2} %",
            signed(shift.field_ut, 3),
            percent(shift.field_ut)
        ));
    }
    if let Headings::Judged(one) = &checked.headings {
        let HeadingError { rms_deg, mean_deg, spread_deg, .. } = one.error;
        line(&format!(
            "heading off by        {rms_deg:9.2} ° rms   mean {mean_deg:+.2}°, standard deviation {spread_deg:.2}°; limit \
             {:.1}°",
            one.limit_deg
        ));
    }
    line(&format!("directions covered    {:9.0} %", checked.coverage * 100.0));
    let notices = checked.extrapolation.notices(checked.field_ut);
    notices.iter().chain(&checked.tilted).for_each(|notice| line(&format!("  outside the range: {notice}")));
}
