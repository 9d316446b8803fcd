//! What the analysis refuses, as a failure with its place.

use crate::failure::Failure;
use ironout_analysis::Refusal;
use std::path::Path;

/// The failure for a refusal about a log.
pub fn failure(refusal: Refusal, log: &Path) -> Failure {
    match refusal {
        Refusal::BadShape(_) | Refusal::NoRoom(_) => Failure::usage(refusal.to_string()).in_file(log),
        Refusal::CannotAdd { id, column: None, why } => Failure::usage(format!("--add {id}: {why}")),
        Refusal::CannotAdd { id, column: Some(column), why } => {
            Failure::usage(format!("--add {id}: {why}")).in_file(log).at_column(column)
        }
        Refusal::TooMany { .. } => Failure::usage(format!("--add: {refusal}")),
    }
}
