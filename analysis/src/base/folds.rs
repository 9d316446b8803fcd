//! The blocks of time that are left out in turn, for a model with steps.

use crate::base::engine::Design;
use crate::base::term::{BLOCKS, Term};
use ironout::effect::Searched;

/// A bound between blocks must lie at least this share of a stretch from its ends.
const INSIDE: f64 = 0.25;

impl Design<'_> {
    /// Bounds of the blocks of time for the held-out error. Between two steps the offset is one that no other part of the
    /// log knows: a block that holds all of such a stretch asks for what cannot be foretold, so it is cut in two there.
    pub fn folds(&self, terms: &[&Term]) -> Vec<usize> {
        let n = self.samples.len();
        let mut bounds = self.samples.bounds(BLOCKS);
        let Some(time) = &self.samples.time else { return bounds };
        let at = |term: &&Term| match term.searched() {
            Some((Searched::At, at_s)) => Some(time.partition_point(|t| *t < at_s)),
            _ => None,
        };
        let mut ends: Vec<usize> = terms.iter().filter_map(at).chain([0, n]).collect();
        ends.sort_unstable();
        for stretch in ends.windows(2) {
            let (from, to) = (stretch[0], stretch[1]);
            let margin = (INSIDE * (to - from) as f64) as usize;
            if !bounds.iter().any(|bound| (from + margin..=to - margin).contains(bound)) {
                bounds.push(from.midpoint(to));
            }
        }
        bounds.sort_unstable();
        bounds.dedup();
        bounds
    }
}
