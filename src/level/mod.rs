//! A calibration for a vehicle that only turns level, from a few circles.
//!
//! Level readings lie on an ellipse in a plane. The ellipse shows the horizontal offset and the horizontal soft iron up to a common gain.
//! It does not show what lies along the vertical: that comes from a prior, the calibration in use or the identity. An error of the vertical
//! offset turns the heading of a tilted vehicle, so the calibration holds for the tilts at which this error is small enough.
//!
//! | file | what |
//! |---|---|
//! | `forces.rs` | the direction down of the vehicle from an accelerometer, apart for left and right turns |
//! | `plane.rs`, `ellipse.rs` | the plane of the readings, and one least squares of the ellipse in it, from the exact sums |
//! | `solve.rs` | the calibration, its errors, and the tilts that it holds for |
//! | `prior.rs`, `in_use.rs` | what is known before; the calibration in use, on the same turns |
//! | `refusal.rs` | why there is none |

mod ellipse;
mod forces;
mod in_use;
mod plane;
mod prior;
mod refusal;
mod solve;
#[cfg(test)]
mod tests;

pub use forces::{Down, Forces};
pub use in_use::InUse;
pub use prior::LevelPrior;
pub use refusal::{Cause, MAX_HEADING_ERROR_DEG, NotLevel};
pub use solve::{LevelFit, fit_level};
