//! Keyword arguments, as the options of the command line that they are.

use ironout_analysis::outcome::request::Purpose;
use ironout_cli::cli::{FieldArgs, Free, MethodArg, purpose};
use ironout_cli::failure::{Failure, Outcome};
use ironout_cli::page::ReadAsked;
use serde_json::Value;

/// Options of a fit.
#[derive(Clone)]
pub struct Asked {
    pub field: FieldArgs,
    pub add: Vec<String>,
    pub force_effect: bool,
    /// File of an earlier calibration.
    pub prior: Option<String>,
    /// What of it is fitted again.
    pub free: Option<Free>,
    /// The attitudes that the calibration is to be for.
    pub purpose: Option<Purpose>,
}

fn wrong(what: &str) -> Failure {
    Failure::usage(what.to_string())
}

/// How a log is read.
pub fn reading(text: &str) -> Outcome<ReadAsked> {
    serde_json::from_str(text).map_err(|error| wrong(&error.to_string()))
}

/// Options of a fit or a diagnosis.
pub fn asked(text: &str) -> Outcome<Asked> {
    let value: Value = serde_json::from_str(text).map_err(|error| wrong(&error.to_string()))?;
    let method = match value["method"].as_str() {
        None | Some("adjusted") => MethodArg::Adjusted,
        Some("trace") => MethodArg::Trace,
        Some("constant") => MethodArg::Constant,
        Some(other) => {
            return Err(wrong(&format!(
                "method {other:?}: expected \"adjusted\", \"trace\" or \"constant\""
            )));
        }
    };
    let add = value["add"].as_array().into_iter().flatten().filter_map(|id| Some(id.as_str()?.to_string()));
    let (field, at) = (value["field_ut"].as_f64(), value["at"].as_str().map(String::from));
    if field.is_some() && at.is_some() {
        return Err(wrong("field_ut and at both give the magnitude of the field. Fix: give one of them"));
    }
    let prior = value["prior"].as_str().map(String::from);
    let free = match value["free"].as_str() {
        None => None,
        Some("offset") if prior.is_some() => Some(Free::Offset),
        Some("offset") => return Err(wrong("free needs a prior, whose matrix is kept. Fix: give prior")),
        Some(other) => return Err(wrong(&format!("free {other:?}: expected \"offset\""))),
    };
    let purpose = value["for"]
        .as_str()
        .map(purpose)
        .transpose()
        .map_err(|error| wrong(&format!("attitudes: {error}")))?;
    Ok(Asked {
        field: FieldArgs { field, at, method },
        add: add.collect(),
        force_effect: value["force_effect"].as_bool() == Some(true),
        prior,
        free,
        purpose,
    })
}
