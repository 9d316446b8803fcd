//! Whether the columns of a log can be what they are read as: units, axes and clock, told from each other.
//!
//! Each check gives what it measured, and nothing where the log cannot tell. None knows a calibration.

pub mod breakage;
pub mod causes;
pub mod clock;
pub mod coarse;
pub mod copies;
pub mod directions;
pub mod field;
pub mod follow;
pub mod gravity;
pub mod heading;
pub mod orders;
pub mod orientation;
pub mod turning;
