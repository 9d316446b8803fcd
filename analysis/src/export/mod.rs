//! A calibration as code, or as the parameters, of another program.

pub mod ardupilot;
pub mod betaflight;
pub mod bound;
pub mod c;
pub mod error;
pub mod held;
pub mod iio;
mod measured;
pub mod px4;
pub mod range;
pub mod refit;
pub mod ros;
pub mod rotations;
pub mod rust;
pub mod words;
