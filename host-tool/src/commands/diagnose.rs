//! `ironout diagnose`: find the missing effect.

use super::later;
use crate::cli::DiagnoseArgs;
use crate::failure::Outcome;

/// Not built yet.
pub fn run(_: &DiagnoseArgs, _json: bool) -> Outcome<u8> {
    later::not_built("diagnose")
}
