//! Which directions the field has been seen from: equal-area bins, the largest gap, and where to turn next.
//!
//! [`CoverageMap`] judges corrected directions. While samples stream in there is no calibration yet to correct them, so a
//! [`Sketch`] remembers where they were in a coarse grid of counts, with integers only, and draws the map after the solve.

mod map;
mod side;
mod sketch;

pub use map::{BINS, Coverage, CoverageMap, SECTORS, SLICES, Seen};
pub use side::side_name;
pub use sketch::Sketch;
