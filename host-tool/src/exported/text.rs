//! The text of each form.

use crate::cal_file::CalFile;
use crate::cli::{ExportArgs, ExportForm};
use crate::exported::target::{self, Exported};
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use crate::reading::Reading;
use ironout_analysis::export::error::CannotExport;
use ironout_analysis::export::{c, rust};
use ironout_analysis::frame::Frame;

/// Whether the options say something to the form.
///
/// # Errors
/// The one that does not.
pub fn asked(arguments: &ExportArgs) -> Outcome<()> {
    match arguments.unused() {
        Some(option) => Err(Failure::usage(format!(
            "{option} has no effect with --as {}. Omit it",
            arguments.form.name()
        ))),
        None => Ok(()),
    }
}

/// The exported text; with a log (that of the calibration) what the target holds is fitted again on it.
///
/// # Errors
/// The target cannot hold the calibration, or a number that it needs is not given.
pub fn text(cal: &CalFile, arguments: &ExportArgs, log: Option<&Log>) -> Outcome<Exported> {
    let refuse = |error: CannotExport| {
        let failure = Failure::usage(error.to_string());
        if error == CannotExport::Singular { failure.at_column("matrix") } else { failure }
    };
    let plain = |text: String| Exported { text, held: None, cost: None };
    let frame = cal.reading.as_ref().map_or_else(|| Ok(Frame::default()), Reading::frame)?;
    match arguments.form {
        ExportForm::Json => serde_json::to_string_pretty(cal)
            .map(|text| plain(text + "\n"))
            .map_err(|error| Failure::usage(error.to_string())),
        ExportForm::Rust => Ok(plain(rust::text(&cal.extended()?, &frame, &summary(cal)))),
        ExportForm::C => c::text(&cal.extended()?, &frame, &summary(cal)).map(plain).map_err(refuse),
        _ => target::export(cal, arguments, log, &frame, &summary(cal)),
    }
}

fn summary(cal: &CalFile) -> String {
    let rms = cal.fit.rms_ut.map_or(String::new(), |rms| format!(", residual rms {rms:.3} µT"));
    format!("{} samples, method {}{rms}", cal.fit.samples_used, cal.fit.method)
}
