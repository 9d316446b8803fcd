//! The test of each effect of a model beside all others.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::residual::spectrum::Verdict;
use crate::search::screen::each_stands;
use crate::search::shown::Shown;
use crate::search::state::{Explanation, Greedy, Withdrawn, held_out_rms};

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

    /// The explanation without those of the effects that were `asked` for that the log does not show: a question is no answer.
    pub(crate) fn without_unshown(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
    ) -> Result<Explanation<'a>, BadShape> {
        while explanation.fitted.terms.iter().any(|term| asked.contains(&term.id)) {
            let tested = self.shown(&explanation.fitted, &explanation.chances)?;
            let tested = tested.into_iter().filter(|one| asked.contains(&one.id));
            let unshown = tested.filter(|one| !one.is_shown());
            let Some(least) = unshown.max_by(|a, b| a.p_value.total_cmp(&b.p_value)) else { break };
            let mut terms = explanation.fitted.terms.clone();
            terms.retain(|term| term.id != least.id);
            let without = match terms.is_empty() {
                true => Some(explanation.base.clone()),
                false => self.design.fit(explanation.fitted.model, terms, self.known)?,
            };
            let Some(without) = without else { break };
            explanation.fitted = self.to_the_end(self.aligned(without)?)?;
            let order = explanation.steps.iter().filter_map(|step| step.added.clone());
            let order: Vec<String> = order.filter(|id| *id != least.id).collect();
            explanation.steps = self.falling(&explanation.base, &explanation.fitted, &order)?;
            let rms =
                |rms: Option<f64>| rms.map_or("unknown".into(), |rms| format!("{rms:.3} {}", least.unit));
            let why = format!(
                "requested, but not significant in this log (p = {2}; held-out error {0} with it, {1} without)",
                rms(least.with),
                rms(least.without),
                if least.p_value < 0.01 {
                    format!("{:.0e}", least.p_value)
                } else {
                    format!("{:.2}", least.p_value)
                }
            );
            explanation.withdrawn.push(Withdrawn { id: least.id, why });
            explanation.chances = self.chances(&explanation.fitted)?;
        }
        Ok(explanation)
    }
}
