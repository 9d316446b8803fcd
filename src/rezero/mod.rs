//! The offset measured again, with the matrix kept: from turns that need not go all round.
//!
//! A battery that was swapped moves the offset and leaves the matrix. Corrected readings `v` then lie on a sphere about the error `d` of
//! the corrected offset, and `‖v − d‖²` is one number for all of them: `‖v‖² = 2 d·v + k` is linear in `d` and `k`. An arc of the sphere
//! is enough, and its covariance says for which directions. The field's magnitude is not taken as known: it may be another place.
//!
//! With a gyro the field's rotation is known too: of two readings with the rotation `R` between them, `(1 − R) d = v′ − R v`. Small turns
//! determine `d` along the field that way, which magnitudes hardly do, and turns about one axis determine `d` across that axis.
//!
//! A *look* is the mean of the readings in which the field turned by [`LOOK_DEG`] = 6°. A board at rest gives none, so that a day on a
//! table does not outweigh a minute of turning. The last [`MAX_LOOKS`] = 64 are kept.
//!
//! | file | what |
//! |---|---|
//! | `looks.rs` | the looks, and the turn from one to the next |
//! | `turn.rs` | rotation vectors summed up from a gyro |
//! | `magnitudes.rs` | the offset from the magnitudes |
//! | `by_gyro.rs` | the offset from magnitudes and gyro |

mod by_gyro;
mod looks;
mod magnitudes;
#[cfg(test)]
mod tests;
mod turn;

pub use looks::{LOOK_DEG, MAX_LOOKS, MIN_LOOKS, Rezero};
pub use magnitudes::{GyroUse, NoOffset, OffsetChange};
