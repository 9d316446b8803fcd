//! One likelihood in the middle: a linearised Gaussian model of a log, one score, and a search by it.
//!
//! `docs/method.md` derives model and score. The rooms of one thread: [`log`] (samples and columns, and effects over them) → [`design`] (residual and columns at the closest point) → [`crate::noise`] (wander and white noise) → [`fit`] →
//! [`screen`] and [`candidates`] → [`search`] → [`significance`] → [`select`]. Thresholds stand in [`crate::bounds`].

pub mod candidates;
pub mod closest;
pub mod design;
pub mod fast_tones;
pub mod fit;
pub mod held_out;
pub mod hidden;
pub mod log;
pub mod screen;
pub mod search;
pub mod select;
pub mod significance;
pub mod solve;
#[cfg(test)]
mod tests;
pub mod wander;
