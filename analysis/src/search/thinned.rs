//! A long log is searched in a thinned copy, and what was found there is fitted and judged on all its samples.
//!
//! What is worth adding takes a share of the squared error, which some thousand samples show as surely as forty thousand,
//! and a search looks at the samples some hundred times. The copy is thinned at places that wander, so that a tone above
//! the copy's own rate keeps its place in the spectrum.

use crate::base::engine::{Fitted, Pass};
use crate::base::piece::BadShape;
use crate::search::state::{Explanation, Greedy, Judged, MOST_SEARCHED};
use crate::search::undisturbed::{let_go, prefer};

impl<'a> Greedy<'_, 'a> {
    /// The search from a base model and the effects that stand in it from the beginning.
    pub fn search(&self, start: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        if self.pass.samples.len() <= MOST_SEARCHED {
            return self.run(start);
        }
        let few = self.pass.samples.thinned(self.catalogue.table(), MOST_SEARCHED);
        let catalogue = self.catalogue.over(&few);
        let pass = Pass::new(&few, self.pass.residual);
        let pieces: Option<Vec<_>> = start.pieces.iter().map(|piece| catalogue.again(piece)).collect();
        let thin = match pieces {
            Some(pieces) => pass.fit(start.model, pieces, self.known)?,
            None => None,
        };
        let Some(thin) = thin else { return self.run(start) };
        let found = Greedy::new(pass, &catalogue, self.known).run(thin)?;
        let near = let_go(&pass, &found.fitted, self.known)?;
        self.lifted(start, &found, near.as_ref())
    }

    /// What was found in a thinned copy, on all samples; `near` is where shapes are looked at in the undisturbed field there.
    fn lifted(
        &self,
        start: Fitted<'a>,
        found: &Explanation,
        near: Option<&Fitted>,
    ) -> Result<Explanation<'a>, BadShape> {
        let base = match start.pieces.is_empty() {
            true => start,
            false => self.pass.fit(start.model, Vec::new(), self.known)?.unwrap_or(start),
        };
        let pieces = found.fitted.pieces.iter().filter_map(|piece| self.catalogue.again(piece)).collect();
        let fitted = match self.pass.fit(found.fitted.model, pieces, self.known)? {
            Some(fitted) => self.aligned(prefer(&self.pass, self.settled(fitted)?, near, self.known)?)?,
            None => base.clone(),
        };
        let order: Vec<String> = found.steps.iter().filter_map(|step| step.added.clone()).collect();
        let order: Vec<String> =
            order.into_iter().filter(|id| fitted.pieces.iter().any(|piece| piece.id == *id)).collect();
        let steps = self.falling(&base, &fitted, &order)?;
        // Squared errors are sums over samples.
        let more = base.rows / found.base.rows.max(1.0);
        let judged = |list: &[Judged]| -> Vec<Judged<'a>> {
            let lift = |one: &Judged| {
                let mut out = one.on(self.catalogue.again(&one.piece)?);
                out.tested.decrease *= more;
                out.tested.held_out = out.tested.held_out.map(|squares| squares * more);
                Some(out)
            };
            list.iter().filter_map(lift).collect()
        };
        Ok(Explanation {
            first: judged(&found.first),
            last: judged(&found.last),
            base,
            fitted,
            steps,
            confounded: found.confounded.clone(),
            families: found.families.clone(),
            withdrawn: found.withdrawn.clone(),
            dropped: found.dropped.clone(),
            ended_early: found.ended_early,
            count: found.count,
            chances: Vec::new(),
            shown: Vec::new(),
        })
    }
}
