//! A calibration as code of another program.

pub mod bound;
pub mod c;
pub mod error;
pub mod range;
pub mod rust;
