//! What a finished search may be certain of: an effect that took less of the error than what remains unexplained may be
//! the shadow of a cause that the log does not hold.

use crate::base::engine::Fitted;
use crate::base::quality::{NoiseEstimate, error_beyond, predicted_error, residue};
use crate::base::term::{BadShape, Term};
use crate::noise::colour::Colour;
use crate::search::screen::ACCUSED;
use crate::search::state::{Explanation, Greedy, Step, Withdrawn, errors_applied, held_out_rms};
use ironout::effect::Searched;
use ironout::fit::MAX_PREDICTED_ERROR;
use ironout::study::Residual;
use ironout::study::rule::falls;

/// An effect stays if it takes at least this many times as much off the mean square as structure remains.
const OUTWEIGHS: f64 = 1.0;
/// One of several steps beside which nothing is left is no stair of a slow change where it takes this many times as much as the
/// noise: the last stair of one that noise hides takes little.
const STANDS_OUT: f64 = 4.0;
/// Where `fit` refuses the model, and it leaves so many times the held-out error, it is not the log's.
const DOES_NOT_HOLD: f64 = 1.4;
/// ... unless all that was found lowers the held-out error to this share of it: then the log is short, and the cause there.
pub(crate) const PREDICTS: f64 = 0.45;
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

impl<'a> Greedy<'_, 'a> {
    /// The explanation without the effects that are not certain. Those that were `asked` for stay.
    pub fn certain(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
    ) -> Result<Explanation<'a>, BadShape> {
        self.put_in_order(&mut explanation, asked)?;
        while let Some(doubtful) = self.doubtful(&explanation, asked)? {
            if !self.withdraw(&mut explanation, doubtful)? {
                break;
            }
            self.put_in_order(&mut explanation, asked)?;
        }
        explanation.renumber();
        Ok(explanation)
    }

    /// The explanation with its model fitted to the end. There an effect that a search found may yet raise the error on held-out
    /// time: then it goes, too.
    pub fn ended(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
        searched: bool,
    ) -> Result<Explanation<'a>, BadShape> {
        loop {
            explanation.fitted = self.to_the_end(explanation.fitted)?;
            if let (Some(last), false) = (explanation.steps.last_mut(), explanation.fitted.terms.is_empty()) {
                (last.rms, last.held_out) = errors_applied(&self.design, &explanation.fitted)?;
            }
            if searched {
                self.put_in_order(&mut explanation, asked)?;
            }
            let Some(worse) = raises(&explanation, asked).filter(|_| searched) else { break };
            if !self.withdraw(&mut explanation, worse)? {
                break;
            }
            explanation.renumber();
        }
        Ok(explanation)
    }

    /// The explanation without what a search found and chance does as well as, beside all others, at the end; with that chance of
    /// all that stays.
    pub fn beyond_chance(
        &self,
        mut explanation: Explanation<'a>,
        asked: &[String],
    ) -> Result<Explanation<'a>, BadShape> {
        loop {
            let tries = explanation.count as f64;
            explanation.chances = self.chances(&explanation.fitted)?;
            let all = explanation.chances.iter().filter(|(id, _)| !asked.contains(id));
            let Some((id, chance)) = all.max_by(|a, b| a.1.total_cmp(&b.1)).cloned() else { break };
            if chance * tries < ACCUSED {
                break;
            }
            let why =
                format!("not significant in addition to the other effects (p = {:.1e})", chance * tries);
            if !self.withdraw(&mut explanation, Withdrawn { id, why })? {
                break;
            }
            explanation.renumber();
        }
        Ok(explanation)
    }

    /// The explanation without those of the effects that were `asked` for that the log does not show: a question is no answer.
    pub fn without_unshown(
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
            if !self.withdraw(&mut explanation, Withdrawn { id: least.id.clone(), why })? {
                break;
            }
            explanation.renumber();
            explanation.chances = self.chances(&explanation.fitted)?;
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
        explanation.fitted = self.aligned(without)?;
        explanation.confounded.retain(|group| !group.ids.contains(&doubtful.id));
        let order: Vec<String> = explanation
            .steps
            .iter()
            .filter_map(|step| step.added.clone())
            .filter(|id| *id != doubtful.id)
            .collect();
        explanation.steps = self.falling(&explanation.base, &explanation.fitted, &order)?;
        explanation.withdrawn.push(doubtful);
        Ok(true)
    }

    /// An effect that the model predicts held-out time as well without: it was found in a thinned copy of a long log, and the
    /// rest of the log knows nothing of it.
    fn idle(&self, explanation: &Explanation<'a>, asked: &[String]) -> Result<Option<Withdrawn>, BadShape> {
        let fitted = &explanation.fitted;
        let Some(with) = held_out_rms(fitted) else { return Ok(None) };
        for pair in explanation.steps.windows(2) {
            let Some(id) = pair[1].added.as_ref().filter(|id| !asked.contains(id)) else { continue };
            let lowers = pair[0].held_out.zip(pair[1].held_out);
            if lowers.is_none_or(|(before, after)| falls(Some(before * before), Some(after * after))) {
                continue;
            }
            // One of two that hide each other takes little before the other is there.
            let mut terms = fitted.terms.clone();
            terms.retain(|term| term.id != *id);
            let Some(without) = self.design.fit(fitted.model, terms, self.known)? else { continue };
            let without = held_out_rms(&without).map(|rms| rms * rms);
            if !falls(without, Some(with * with)) {
                let why = "not significant: the held-out error is as low without it";
                return Ok(Some(Withdrawn { id: id.clone(), why: why.into() }));
            }
        }
        Ok(None)
    }

    /// What an effect takes off the mean square beside all others, µT²: of two that hide each other the first takes little
    /// before the second is there.
    fn takes_beside(&self, explanation: &Explanation<'a>, id: &str) -> Result<Option<f64>, BadShape> {
        let fitted = &explanation.fitted;
        let mut terms = fitted.terms.clone();
        terms.retain(|term| term.id != *id);
        let without = self.design.fit(fitted.model, terms, self.known)?;
        Ok(without.map(|without| without.rms().powi(2) - fitted.rms().powi(2)))
    }

    /// The effect that takes the least off the error, where the log is too short for its noise and its effects: what was found then
    /// fits the log's own samples, and not those it was not fitted to.
    fn does_not_hold(
        &self,
        explanation: &Explanation<'a>,
        left: &NoiseEstimate,
        asked: &[String],
    ) -> Option<Withdrawn> {
        let fitted = &explanation.fitted;
        let held_out = held_out_rms(fitted)?;
        let times = held_out / fitted.rms();
        // As `fit` has it, which would refuse this.
        let unseen = error_beyond(held_out, fitted.rms()) / fitted.model.field_ut;
        let predicted = predicted_error(&self.design, fitted, self.known, left)?.max(unseen);
        let before = explanation.steps.first().and_then(|first| first.held_out);
        if self.design.residual != Residual::Magnitude
            || before.is_none_or(|before| held_out < PREDICTS * before)
            || times < DOES_NOT_HOLD
            || predicted < MAX_PREDICTED_ERROR
        {
            return None;
        }
        let found = explanation.steps.windows(2).filter_map(|pair| {
            let id = pair[1].added.as_ref().filter(|id| !asked.contains(id))?;
            Some((pair[0].rms.powi(2) - pair[1].rms.powi(2), id))
        });
        let (_, id) = found.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Withdrawn {
            id: id.clone(),
            why: format!(
                "the log is too short to decide: with it the predicted error is {:.1} % of the field, and the held-out \
                 error {times:.1} × the fitted one",
                100.0 * predicted
            ),
        })
    }

    fn doubtful(
        &self,
        explanation: &Explanation<'a>,
        asked: &[String],
    ) -> Result<Option<Withdrawn>, BadShape> {
        let fitted = &explanation.fitted;
        if let Some(worse) = raises(explanation, asked) {
            return Ok(Some(worse));
        }
        if let Some(idle) = self.idle(explanation, asked)? {
            return Ok(Some(idle));
        }
        let list: Vec<&Term> = fitted.terms.iter().collect();
        let residuals = self.design.residuals(&fitted.model, &list)?;
        let samples = self.design.samples;
        let left = residue(
            &residuals,
            fitted.columns(),
            samples.quantum_ut,
            samples.step_s(),
            &self.design.turning(&fitted.model),
        );
        if let Some(unheld) = self.does_not_hold(explanation, &left, asked) {
            return Ok(Some(unheld));
        }
        let remains = left.structure * left.rms * left.rms;
        let is_step = |term: &&Term| matches!(term.searched(), Some((Searched::At, _)));
        // Where all is explained there is nothing to doubt, but several steps make a stair of any slow change, and 1/f noise
        // wanders so that a step takes part of it.
        let several = fitted.terms.iter().filter(is_step).count() > 1;
        let wanders = matches!(left.colour, Colour::Flicker { .. });
        if remains <= 0.0 && !several && !wanders {
            return Ok(None);
        }
        let takes = |id: &str| {
            let own = explanation.steps.windows(2).find(|pair| pair[1].added.as_deref() == Some(id));
            own.map_or(f64::INFINITY, |pair| pair[0].rms.powi(2) - pair[1].rms.powi(2))
        };
        for term in fitted.terms.iter().filter(|term| !asked.contains(&term.id)) {
            let at = term.searched().filter(|(searched, _)| *searched == Searched::At);
            let enough = if several { STANDS_OUT } else { OUTWEIGHS };
            if remains <= 0.0 && takes(&term.id) >= enough * left.rms * left.rms {
                continue;
            }
            if let Some((_, at_s)) = at
                && !self.is_sudden(fitted, term, at_s)?
            {
                let why = "the offset changes gradually, not in a step: the cause is probably slow and was not logged";
                return Ok(Some(Withdrawn { id: term.id.clone(), why: why.into() }));
            }
        }
        if remains <= 0.0 {
            return Ok(None);
        }
        let mut least: Option<(f64, &String)> = None;
        for pair in explanation.steps.windows(2) {
            let Some(id) = pair[1].added.as_ref().filter(|id| !asked.contains(id)) else { continue };
            // A square or a past beside the linear term of the same column blames no other cause.
            let own = fitted.terms.iter().find(|term| term.id == *id && !term.is_plain());
            let beside_plain =
                |own: &Term| fitted.terms.iter().any(|term| term.is_plain() && term.is_variant_of(own));
            if own.is_some_and(beside_plain) {
                continue;
            }
            let takes = takes(id);
            if takes < OUTWEIGHS * remains
                && least.is_none_or(|(known, _)| takes < known)
                && self.takes_beside(explanation, id)?.is_none_or(|takes| takes < OUTWEIGHS * remains)
            {
                least = Some((takes, id));
            }
        }
        Ok(least.map(|(takes, id)| Withdrawn {
            id: id.clone(),
            why: format!(
                "it explains {:.0} % of the variance, but {:.0} % is not noise and nothing in the log explains it: a cause \
                 that was not logged may look like it",
                100.0 * takes / explanation.base.rms().powi(2).max(1e-300),
                100.0 * remains / explanation.base.rms().powi(2).max(1e-300),
            ),
        }))
    }
}
