//! A calibration as code of another program.

pub mod c;
pub mod error;
pub mod range;
pub mod rust;
