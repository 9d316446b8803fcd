//! What a log says of a calibration: still good, moved, another field, worse.

mod heading;
pub mod judge;
mod shift;
mod word;
