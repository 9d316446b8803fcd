//! Which column of the streamed sums is what.

use super::columns::MAX_TESTED;
use super::point::BASE;

/// Where the drift's columns begin; those of a tested column follow, three each.
pub(super) const DRIFT: usize = BASE;
/// Effects that stream: drift and the tested columns.
pub(super) const EFFECTS: usize = 1 + MAX_TESTED;
/// Columns that stream: base, drift, three for each tested column.
pub(super) const STREAMED: usize = BASE + 3 + 3 * MAX_TESTED;
/// Entries of their triangle.
pub(super) const ENTRIES: usize = STREAMED * (STREAMED + 1) / 2;
/// The unit of time of the drift's columns, ms.
pub(super) const DRIFT_UNIT_MS: f32 = 64_000.0;
/// Where a step's columns stand, behind those that stream.
pub(super) const STEP: usize = STREAMED;
