//! The test of each effect of a model beside all others.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::search::screen::each_stands;
use crate::search::shown::Shown;
use crate::search::state::{Explanation, Fitter, Step, Withdrawn, held_out_rms};

impl<'a> Fitter<'_, 'a> {
    /// Probability that chance does as well as each effect of a model, where the model stands, all others in it, its search
    /// counted; by its id.
    pub(crate) fn chances(&self, fitted: &Fitted<'a>) -> Result<Vec<(String, f64)>, BadShape> {
        let tests = each_stands(&self.design, fitted)?;
        let chance = |(term, p_value): (&Term, f64)| (term.id.clone(), (p_value * term.trials).min(1.0));
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
            if !self.withdraw(&mut explanation, Withdrawn { id: least.id, why })? {
                break;
            }
            explanation.chances = self.chances(&explanation.fitted)?;
        }
        Ok(explanation)
    }

    /// The explanation without the effects that raise the error on held-out time, each judged when it is added in its turn.
    pub(crate) fn that_predict(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
    ) -> Result<Explanation<'a>, BadShape> {
        self.put_in_order(&mut explanation, asked)?;
        while let Some(worse) = raises(&explanation, asked) {
            if !self.withdraw(&mut explanation, worse)? {
                break;
            }
            self.put_in_order(&mut explanation, asked)?;
        }
        Ok(explanation)
    }

    /// Where the held-out error rises on the way, another order of the same effects: each time the one that leaves the
    /// least. An effect may stand only beside another that was found after it.
    fn put_in_order(&self, explanation: &mut Explanation<'a>, asked: &[String]) -> Result<(), BadShape> {
        if raises(explanation, asked).is_none() {
            return Ok(());
        }
        let ids = explanation.steps.iter().filter_map(|step| step.added.clone());
        let (mut order, mut rest): (Vec<String>, Vec<String>) = ids.partition(|id| asked.contains(id));
        let all = &explanation.fitted.terms;
        let mut now = explanation.base.clone();
        let with = |now: &Fitted<'a>, id: &String| {
            let more = all.iter().filter(|term| term.id == *id);
            self.design.fit(now.model, now.terms.iter().chain(more).cloned().collect(), self.known)
        };
        for id in &order {
            now = with(&now, id)?.unwrap_or(now);
        }
        while rest.len() > 1 {
            let mut best: Option<(f64, usize, Fitted<'a>)> = None;
            for (place, id) in rest.iter().enumerate() {
                let Some(next) = with(&now, id)? else { continue };
                let Some(error) = held_out_rms(&next) else { continue };
                if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                    best = Some((error, place, next));
                }
            }
            let Some((_, place, next)) = best else { return Ok(()) };
            order.push(rest.remove(place));
            now = next;
        }
        order.extend(rest);
        let steps = self.falling(&explanation.base, &explanation.fitted, &order)?;
        let before = std::mem::replace(&mut explanation.steps, steps);
        if raises(explanation, asked).is_some() {
            explanation.steps = before;
        }
        Ok(())
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

/// What raises the held-out error by more than this is not recommended.
const RAISES: f64 = 1.05;

/// The effect that, added in its turn, raises the held-out error the most. Several of a kind count as one: a step there
/// alone predicts nothing of a time after the step back.
fn raises(explanation: &Explanation, asked: &[String]) -> Option<Withdrawn> {
    let kind = |step: &Step| step.added.as_ref().and_then(|id| id.split('#').next()).map(str::to_owned);
    let list = &explanation.steps;
    let ends = |place: usize| list.get(place + 1).is_none_or(|next| kind(next) != kind(&list[place]));
    let lasts: Vec<usize> = (0..list.len()).filter(|place| ends(*place)).collect();
    let steps = lasts.windows(2).filter_map(|pair| {
        let (first, last) = (&list[pair[0]], &list[pair[1]]);
        let id = last.added.as_ref().filter(|id| !asked.contains(id))?;
        let (before, after) = (first.held_out?, last.held_out?);
        (after > RAISES * before).then_some((after / before, before, after, id))
    });
    let (_, before, after, id) = steps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Withdrawn {
        id: id.clone(),
        why: format!("it increases the held-out error from {before:.3} to {after:.3} µT"),
    })
}
