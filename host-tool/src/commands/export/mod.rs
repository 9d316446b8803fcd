//! `ironout export`: a calibration as Rust, C or JSON.

use crate::cal_file::CalFile;
use crate::cli::{ExportArgs, ExportForm};
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::{atomic, output};
use ironout_analysis::export::error::CannotExport;
use ironout_analysis::export::{c, rust};

/// Writes the calibration in the form asked for.
pub fn run(arguments: &ExportArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    let text = text(&cal, arguments.form).map_err(|failure| failure.in_file(&arguments.cal))?;
    let file = arguments.output.as_ref().filter(|path| !output::is_standard(path));
    match file {
        Some(path) => {
            atomic::not_over(&arguments.cal, path)?;
            atomic::write(path, |out| out.write_all(text.as_bytes()))?;
            if !json {
                output::line(&format!("wrote {}", path.display()));
            }
        }
        None if !json => output::line(text.trim_end()),
        None => {}
    }
    if json {
        let form = match arguments.form {
            ExportForm::Rust => "rust",
            ExportForm::C => "c",
            ExportForm::Json => "json",
        };
        output::line(
            &serde_json::json!({
                "as": form, "output": arguments.output.as_ref().map(|path| path.display().to_string()), "text": text,
            })
            .to_string(),
        );
    }
    Ok(EXIT_OK)
}

/// The exported text.
pub fn text(cal: &CalFile, form: ExportForm) -> Outcome<String> {
    match form {
        ExportForm::Json => serde_json::to_string_pretty(cal)
            .map(|text| text + "\n")
            .map_err(|error| Failure::usage(error.to_string())),
        ExportForm::Rust => {
            let calibration = cal.extended()?;
            Ok(rust::text(&calibration, &summary(cal)))
        }
        ExportForm::C => {
            let calibration = cal.extended()?;
            c::text(&calibration, &summary(cal)).map_err(failure)
        }
    }
}

fn failure(error: CannotExport) -> Failure {
    let failure = Failure::usage(error.to_string());
    if error == CannotExport::Singular { failure.at_column("matrix") } else { failure }
}

fn summary(cal: &CalFile) -> String {
    let rms = cal.fit.rms_ut.map_or(String::new(), |rms| format!(", residual rms {rms:.3} µT"));
    format!("{} samples, method {}{rms}", cal.fit.samples_used, cal.fit.method)
}
