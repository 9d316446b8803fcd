//! Judges a calibration by a later log: still good, moved, another field, worse.

pub(crate) mod heading;
pub mod judge;
mod shift;
mod word;
