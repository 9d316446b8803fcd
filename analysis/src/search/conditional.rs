//! The test of each effect of a model beside all others.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::evidence::select::p_values_of;
use crate::search::shown::Shown;
use crate::search::state::{Explanation, Fitter, Withdrawn, held_out_rms};

impl<'a> Fitter<'_, 'a> {
    /// p-value of each effect of a model given all others, corrected for its search, by id.
    pub(crate) fn chances(&self, fitted: &Fitted<'a>) -> Vec<(String, f64)> {
        if fitted.terms.is_empty() {
            return Vec::new();
        }
        let (table, registry) = (self.catalogue.table(), self.catalogue.registry);
        let tests = p_values_of(self.design.samples, table, registry, &self.begin(fitted));
        let chance = |(term, p_value): (&Term, f64)| (term.id.clone(), (p_value * term.trials).min(1.0));
        fitted.terms.iter().zip(tests).map(chance).collect()
    }

    /// Tests every effect of a model, all others in it. `chances` are those of this model.
    pub(crate) fn shown(
        &self,
        fitted: &Fitted<'a>,
        chances: &[(String, f64)],
    ) -> Result<Vec<Shown>, BadShape> {
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

    /// The explanation without the effects that were `asked` for and that the log does not show (a question is no answer), nor those beside
    /// which all others predict held-out time better.
    pub(crate) fn that_hold(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
    ) -> Result<Explanation<'a>, BadShape> {
        loop {
            explanation.chances = self.chances(&explanation.fitted);
            let tested = self.shown(&explanation.fitted, &explanation.chances)?;
            let fails = |one: &Shown| if asked.contains(&one.id) { !one.is_shown() } else { one.raises() };
            let failing = tested.into_iter().filter(fails);
            let Some(worst) = failing.max_by(|a, b| a.rise().total_cmp(&b.rise())) else {
                return Ok(explanation);
            };
            let why = worst.why_not(asked.contains(&worst.id));
            if !self.withdraw(&mut explanation, Withdrawn { id: worst.id, why })? {
                return Ok(explanation);
            }
        }
    }

    /// Takes an effect out of the explanation; false where the model cannot be fitted without it.
    fn withdraw(&self, explanation: &mut Explanation<'a>, doubtful: Withdrawn) -> Result<bool, BadShape> {
        let mut terms = explanation.fitted.terms.clone();
        terms.retain(|term| term.id != doubtful.id);
        // A model that an effect has led astray does not come back by itself.
        let without = match terms.is_empty() {
            true => Some(explanation.base.clone()),
            false => self.design.fit(explanation.fitted.model, terms, self.known)?,
        };
        let Some(without) = without else { return Ok(false) };
        explanation.fitted = self.to_the_end(self.aligned(without)?)?;
        explanation.confounded.retain(|group| !group.ids.contains(&doubtful.id));
        explanation.withdrawn.push(doubtful);
        let order: Vec<String> = explanation
            .steps
            .iter()
            .filter_map(|step| step.added.clone())
            .filter(|id| explanation.fitted.terms.iter().any(|term| term.id == *id))
            .collect();
        explanation.steps = self.falling(&explanation.base, &explanation.fitted, &order)?;
        explanation.renumber();
        Ok(true)
    }
}
