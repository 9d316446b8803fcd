//! A long log is searched in a thinned copy, and what was found there is fitted and judged on all its samples.
//!
//! What is worth adding takes a share of the squared error, which some thousand samples show as surely as forty thousand,
//! and a search looks at the samples some hundred times. The copy is thinned at places that wander, so that a tone above
//! the copy's own rate keeps its place in the spectrum.

use crate::base::engine::{Design, Fitted};
use crate::base::term::BadShape;
use crate::search::state::{Explanation, Greedy, Judged, MOST_SEARCHED};
use crate::search::true_field::{let_go, prefer};

impl<'a> Greedy<'_, 'a> {
    /// The search from a base model and the effects that stand in it from the beginning.
    pub fn search(&self, start: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        if self.design.samples.len() <= MOST_SEARCHED {
            return self.run(start);
        }
        let few = self.design.samples.thinned(self.catalogue.table(), MOST_SEARCHED);
        let catalogue = self.catalogue.over(&few);
        let design = Design::new(&few, self.design.residual);
        let terms: Option<Vec<_>> = start.terms.iter().map(|term| catalogue.again(term)).collect();
        let thin = match terms {
            Some(terms) => design.fit(start.model, terms, self.known)?,
            None => None,
        };
        let Some(thin) = thin else { return self.run(start) };
        let found = Greedy::new(design, &catalogue, self.known).run(thin)?;
        let near = let_go(&design, &found.fitted, self.known)?;
        self.lifted(start, &found, near.as_ref())
    }

    /// What was found in a thinned copy, on all samples; `near` is where shapes are looked at in the undisturbed field there.
    fn lifted(
        &self,
        start: Fitted<'a>,
        found: &Explanation,
        near: Option<&Fitted>,
    ) -> Result<Explanation<'a>, BadShape> {
        let base = match start.terms.is_empty() {
            true => start,
            false => self.design.fit(start.model, Vec::new(), self.known)?.unwrap_or(start),
        };
        let terms = found.fitted.terms.iter().filter_map(|term| self.catalogue.again(term)).collect();
        let fitted = match self.design.fit(found.fitted.model, terms, self.known)? {
            Some(fitted) => self.aligned(prefer(&self.design, self.settled(fitted)?, near, self.known)?)?,
            None => base.clone(),
        };
        let order: Vec<String> = found.steps.iter().filter_map(|step| step.added.clone()).collect();
        let order: Vec<String> =
            order.into_iter().filter(|id| fitted.terms.iter().any(|term| term.id == *id)).collect();
        let steps = self.falling(&base, &fitted, &order)?;
        // Squared errors are sums over samples.
        let more = base.rows / found.base.rows.max(1.0);
        let judged = |list: &[Judged]| -> Vec<Judged<'a>> {
            let lift = |one: &Judged| {
                let mut out = one.on(self.catalogue.again(&one.term)?);
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
