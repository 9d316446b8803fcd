//! The study that a board carries with it: while it is turned, and its motors run, it tests effects on its own samples.
//!
//! [`Learner`] streams: a row of derivatives a sample, added to packed normal matrices in four blocks of time. [`Inquiry`] asks it,
//! in small steps: what the base model leaves, which effect is missing, which explain the same, by the rule of
//! [`study::rule`](crate::study::rule). [`Learner::add`] takes an effect into a calibration, [`Learner::remove`] out again.
//!
//! Single precision throughout, at a fixed point (the calibration in use, or what a session has found so far): the residual is
//! relative to the field, a column is held against its first value, and a matrix is scaled to unit columns before it is solved.

mod blocks;
mod candidate;
mod columns;
mod cross;
mod expansion_point;
mod finding;
mod forget;
mod gain;
mod inquiry;
mod jump;
mod late;
mod lateness;
mod layout;
mod learner;
mod marks;
mod memory;
mod point;
mod solve;
mod sums;
mod test;
#[cfg(test)]
mod tests;
mod turning;
#[cfg(test)]
mod years;

pub use candidate::{Candidate, Found};
pub use columns::MAX_TESTED;
pub use finding::{Finding, InUse, Outcome, Status, Verdict};
pub use gain::{NotShown, has_id};
pub use inquiry::Inquiry;
pub use late::Motion;
pub use learner::{Fed, Learner};
