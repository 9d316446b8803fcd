//! What speaks against a verdict that would reassure, and what may hide behind one that names nobody.

use crate::base::applied::Applied;
use crate::base::quality::NoiseEstimate;
use crate::base::term::{BadShape, Term};
use crate::bounds::{MIN_SHARE, UNSEEN_LEAST, UNSEEN_SLACK};
use crate::evidence::significance::Test;
use crate::outcome::view::View;
use crate::samples::faults;
use crate::search::state::held_out_rms;

/// So many effects that explain the most are looked at with what stands out beside them.
const LEADERS: usize = 3;
impl View<'_, '_> {
    /// The held-out error over the noise floor, where it is more than that many parameters and that noise's memory make of
    /// it: a model that explains the samples it has seen by chance, or structure that passes for noise.
    pub(super) fn fails_held_out(&self, left: &NoiseEstimate, applied: &Applied) -> Option<f64> {
        let fitted = &self.explanation.fitted;
        let held_out = held_out_rms(fitted)?;
        let ratio = applied.share * held_out / left.floor;
        let independent = fitted.rows / left.time.max(1.0);
        let expected = 1.0 + 2.0 * fitted.columns() as f64 / independent.max(1.0);
        let tolerated = expected + UNSEEN_SLACK * (expected - 1.0) + UNSEEN_LEAST;
        (ratio * ratio > tolerated).then_some(ratio)
    }

    /// What stands out of the base model with an effect that explains much, though not with certainty: a magnet that passed may have
    /// hidden it.
    pub(super) fn beside_leaders(&self) -> Result<Vec<(usize, usize)>, BadShape> {
        let explanation = &self.explanation;
        let mut first: Vec<&Test> = explanation.first.iter().filter(|one| one.share >= MIN_SHARE).collect();
        first.sort_by(|a, b| b.share.total_cmp(&a.share));
        for leader in first.into_iter().take(LEADERS) {
            let named = self.catalogue.registry.parse(&leader.id);
            let Some(term) = named.and_then(|named| self.catalogue.build(&named, leader.parameter)) else {
                continue;
            };
            let terms = vec![term];
            let Some(with) = self.design.fit(explanation.base.model, terms, self.known)? else { continue };
            let list: Vec<&Term> = with.terms.iter().collect();
            let found = faults::bursts(&self.design.residuals(&with.model, &list)?);
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(Vec::new())
    }
}
