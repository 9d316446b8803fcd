//! `ironout check`: is a calibration still good for a new log?

mod heading;
pub mod run;
mod shift;
mod word;
