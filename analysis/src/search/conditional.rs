//! The test of each effect of a model beside all others.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::residual::spectrum::Verdict;
use crate::search::screen::each_stands;
use crate::search::shown::Shown;
use crate::search::state::{Greedy, held_out_rms};

impl<'a> Greedy<'_, 'a> {
    /// Probability that chance does as well as each effect of a model, where the model stands, all others in it, its search
    /// counted; by its id.
    pub(crate) fn chances(&self, fitted: &Fitted<'a>) -> Result<Vec<(String, f64)>, BadShape> {
        let tests = each_stands(&self.design, fitted, 0..fitted.terms.len())?;
        let chance = |(term, test): (&Term, Option<Verdict>)| {
            let p_value = test.map_or(1.0, |test| test.p_value);
            (term.id.clone(), (p_value * term.trials).min(1.0))
        };
        Ok(fitted.terms.iter().zip(tests).map(chance).collect())
    }

    /// Tests every effect of a model where the model stands. `chances` are those of this model, where they are known.
    pub(crate) fn shown(
        &self,
        fitted: &Fitted<'a>,
        chances: &[(String, f64)],
    ) -> Result<Vec<Shown>, BadShape> {
        let known = |term: &Term| chances.iter().any(|(id, _)| *id == term.id);
        let worked_out;
        let chances = if fitted.terms.iter().all(known) {
            chances
        } else {
            worked_out = self.chances(fitted)?;
            &worked_out
        };
        let with = held_out_rms(fitted);
        let mut list = Vec::new();
        for index in 0..fitted.terms.len() {
            let mut terms = fitted.terms.clone();
            let id = terms.remove(index).id;
            let without = self.design.fit(fitted.model, terms, self.known)?;
            let chance = chances.iter().find(|(other, _)| *other == id);
            list.push(Shown {
                p_value: chance.map_or(1.0, |(_, p_value)| *p_value),
                id,
                without: without.as_ref().and_then(held_out_rms),
                with,
                unit: "µT",
            });
        }
        Ok(list)
    }
}
