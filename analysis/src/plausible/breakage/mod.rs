//! Numbers that a driver, a bus or a recorder broke, each kind recognised by the repair that undoes it.
//!
//! One principle for all kinds: a sensor turns, so neighbouring rows are near each other. Each candidate repair is tried, and it is
//! the diagnosis if it removes nearly all of the path length at the rows that it touches and the readings are continuous afterwards.
//! All functions are free of units: they take the numbers as the file has them.

mod codes;
mod ellipsoid;
mod find;
mod maps;
mod range;
mod repair;
mod rows;
mod series;

pub use find::find;
pub use repair::Repair;

/// A repair leaves at most this share of the path length between the rows that it touches. A repair that does not fit leaves more
/// than half; the turning of the sensor within one row is usually below a tenth.
pub const MAX_PATH_SHARE: f64 = 0.25;
/// After a repair the usual step from row to row is at most this share of half the range of an axis: otherwise rows are not
/// neighbours in time (a shuffled log, a few rows per turn), and continuity says nothing.
const MAX_STEP_SHARE: f64 = 0.25;
/// A single jump is evidence only if the repair leaves this little of it: three jumps that meet by chance have a probability of
/// `MAX_PATH_SHARE`³, so has one at this share.
const MAX_PATH_SHARE_OF_ONE: f64 = 0.015;
/// Events that make a kind of breakage: two coincide in a log of many spikes, three with the same value do not.
const MIN_EVENTS: usize = 3;
/// Rows that a log needs.
const MIN_ROWS: usize = 50;

/// What broke the numbers of a log, and what undoes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Breakage {
    /// The repair that makes neighbouring rows continuous.
    pub repair: Repair,
    /// Rows that it changes or sets aside.
    pub rows: usize,
    /// First of them, from 0.
    pub first_row: usize,
    /// Share of the path length between the rows concerned that the repair removes.
    pub explained: f64,
}
