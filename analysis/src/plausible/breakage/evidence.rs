//! What a diagnosis of broken numbers rests on.

use super::repair::Repair;

/// A repair leaves at most this share of the path length between the rows that it touches. A repair that does not fit leaves more
/// than half; the turning of the sensor within one row is usually below a tenth.
pub const MAX_PATH_SHARE: f64 = 0.25;
/// After a repair the usual step from row to row is at most this share of half the range of an axis: otherwise rows are not
/// neighbours in time (a shuffled log, a few rows per turn), and continuity says nothing.
pub const MAX_STEP_SHARE: f64 = 0.25;
/// Events that make a kind of breakage: two coincide in a log of many spikes, three with the same value do not.
pub const MIN_EVENTS: usize = 3;
/// Rows that a log needs.
pub const MIN_ROWS: usize = 50;

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
