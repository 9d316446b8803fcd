//! `ironout diagnose`: find the missing effect.

mod advice;
mod conclusion;
mod curve;
mod found;
mod next;
mod numbers;
mod place;
mod words;

use crate::cli::DiagnoseArgs;
use crate::diagnose::outcome::Verdict;
use crate::diagnose::{Diagnosis, Options, Refusal, Table, diagnose, json};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::output;
use crate::prior::Prior;
use crate::progress::Working;
use std::path::Path;

/// Diagnoses a log; exit status 1 where the data do not support a calibration.
pub fn run(arguments: &DiagnoseArgs, as_json: bool) -> Outcome<u8> {
    let expected = arguments.field.expected()?;
    let method = arguments.field.method_with(&arguments.add, arguments.prior.as_ref())?;
    let log = arguments.log.read()?;
    let prior = arguments.prior.as_deref().map(|path| Prior::read(path, &log, &arguments.log)).transpose()?;
    // Without --field, the earlier calibration's own: its numbers are scaled to that.
    let field_ut = expected.field_ut.or_else(|| prior.as_ref().map(Prior::field_ut));
    let earlier = prior.map(|prior| prior.earlier(expected.field_ut));
    let options = Options { field_ut, method, add: arguments.add.clone(), search: true, earlier };
    let working = Working::new("studying");
    let diagnosis = diagnose(&Table::from(&log), &options).map_err(|refusal| failure(refusal, &log.path))?;
    drop(working);
    if as_json {
        output::line(&json::object(&diagnosis).to_string());
    } else {
        output::text(&words::text(&words::Told { log: &log, arguments, diagnosis: &diagnosis }));
    }
    Ok(status(&diagnosis))
}

fn status(diagnosis: &Diagnosis) -> u8 {
    if diagnosis.verdict == Verdict::Undetermined { EXIT_REFUSED } else { EXIT_OK }
}

/// The failure for a refusal.
pub fn failure(refusal: Refusal, log: &Path) -> Failure {
    match refusal {
        Refusal::BadShape(id) => {
            Failure::usage(format!("the shape of effect {id} is not finite")).in_file(log)
        }
        Refusal::CannotAdd(id, why) => Failure::usage(format!("--add {id}: {why}")),
    }
}
