//! The terms that the likelihood selected, or that were asked for, fitted to all samples.

use crate::base::applied::Applied;
use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::bounds::{MIN_ODDS, RAISES};
use crate::evidence::select::{Begin, Selected, Selection, select};
use crate::samples::series::Autocorrelation;
use crate::search::parameter;
use crate::search::several::numbered;
use crate::search::state::{Confounded, Explanation, Fitter, Step};
use ironout::effect::{Acts, Bends};
use ironout::study::{Model, Residual};

/// What was found, unless some shape was not finite on the way.
fn finite<T>(found: Result<T, BadShape>) -> Result<Option<T>, BadShape> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(BadShape::NotFinite(_)) => Ok(None),
        Err(bad) => Err(bad),
    }
}

impl<'a> Fitter<'_, 'a> {
    /// What the likelihood begins with at a model.
    pub(crate) fn begin<'b>(&'b self, start: &'b Fitted<'a>) -> Begin<'b> {
        let is_at_rest = self.design.residual == Residual::Vector;
        Begin { model: &start.model, known: self.known, stay: &start.terms, is_at_rest }
    }

    /// A term over all samples, with its coefficients, named beside those in the model.
    fn term_of(&self, fitted: &Fitted<'a>, one: &Selected) -> Option<Term<'a>> {
        let named = self.catalogue.registry.parse(&one.id)?;
        let own = self.catalogue.build(&named, one.parameter)?;
        numbered(fitted, Term { trials: one.trials, coefficients: one.coefficients, ..own })
    }

    /// The model with these terms more, fully refitted, and what fixes their shapes moved to where the error is least. `near` is a model that
    /// is near. Of effects that are made of the measured vector, in the form whose correction leaves less. `None` where the fit does not
    /// converge, or runs away; so strong an effect of that kind that no fit ends may stand all the same, where its correction leaves less.
    pub(crate) fn with(
        &self,
        fitted: &Fitted<'a>,
        more: Vec<Term<'a>>,
        near: Option<Model<f64>>,
    ) -> Result<Option<Fitted<'a>>, BadShape> {
        let terms: Vec<Term> = fitted.terms.iter().cloned().chain(more).collect();
        let begin = near.unwrap_or(fitted.model);
        if self.design.residual != Residual::Magnitude || !terms.iter().any(|term| term.acts(Acts::Measured))
        {
            return Ok(self.refined(begin, terms)?.filter(|next| next.converged));
        }
        let mut forms = Vec::new();
        for bends in [Bends::Reading, Bends::Field] {
            let bent = |term: &Term<'a>| match term.acts(Acts::Measured) {
                true => Term { bends, ..term.clone() },
                false => term.clone(),
            };
            let Some(next) = self.refined(begin, terms.iter().map(bent).collect())? else { continue };
            // What a correction cannot follow is no form of it.
            if let Ok(applied) = Applied::of(&self.design, &next) {
                forms.push((next, applied.residuals));
            }
        }
        let squares = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
        // Of a sensor so strong that two fields have one reading no fit ends, or no correction follows it, and yet the effect is there.
        let tells = |form: &(Fitted, Vec<f64>)| squares(&form.1) < fitted.squares;
        match forms.iter().any(tells) {
            true => forms.retain(tells),
            false => forms.retain(|form| form.0.converged),
        }
        // A sensor that bends the field and one that bends its reading are two forms of one effect, and the data tell which.
        let is_field = match forms.as_slice() {
            [(reading, left_by_reading), (field, left)] => {
                let variance = squares(left) / left.len().max(1) as f64 * Autocorrelation::of(left).time;
                let lead = squares(left_by_reading) - squares(left);
                let only_field_ends = field.converged && !reading.converged;
                lead > if only_field_ends { -MIN_ODDS } else { MIN_ODDS } * variance
            }
            _ => true,
        };
        let last = forms.pop();
        let chosen = if is_field { last } else { forms.pop() };
        Ok(chosen.map(|(form, _)| form))
    }

    /// A fit with what fixes the shapes moved to where the error is least.
    fn refined(&self, begin: Model<f64>, terms: Vec<Term<'a>>) -> Result<Option<Fitted<'a>>, BadShape> {
        let Some(next) = finite(self.design.fit(begin, terms, self.known))?.flatten() else {
            return Ok(None);
        };
        finite(parameter::refine(&self.design, next, self.catalogue, self.known))
    }

    /// The model with the terms of a selection: all at once, or, where those do not converge together, each that does beside the others.
    fn with_selected(
        &self,
        start: Fitted<'a>,
        found: &Selection,
    ) -> Result<(Fitted<'a>, Vec<String>), BadShape> {
        let mut whole = start.clone();
        let mut ids = Vec::new();
        for one in &found.found {
            if let Some(term) = self.term_of(&whole, one) {
                ids.push(term.id.clone());
                whole.terms.push(term);
            }
        }
        let more = whole.terms.split_off(start.terms.len());
        if more.is_empty() {
            return Ok((start, ids));
        }
        let all = self.with(&start, more.clone(), found.model)?;
        if let Some(all) = all.filter(|all| all.squares < start.squares) {
            return Ok((all, ids));
        }
        let (mut fitted, mut ids) = (start, Vec::new());
        for term in more {
            let id = term.id.clone();
            let next = self.with(&fitted, vec![term], None)?;
            if let Some(next) = next.filter(|next| next.squares < fitted.squares) {
                fitted = next;
                ids.push(id);
            }
        }
        Ok((fitted, ids))
    }

    /// The model with the effects that stand in it from the beginning and those that the likelihood selects.
    pub fn selected(&self, start: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        let start = self.aligned(start)?;
        let base = match start.terms.is_empty() {
            true => start.clone(),
            false => self.design.fit(start.model, Vec::new(), self.known)?.unwrap_or_else(|| start.clone()),
        };
        let begin = self.begin(&start);
        let mut found = select(self.design.samples, self.catalogue.table(), self.catalogue.registry, &begin)
            .unwrap_or_default();
        let (fitted, ids, steps) = loop {
            let (fitted, ids) = self.with_selected(start.clone(), &found)?;
            let fitted = self.aligned(fitted)?;
            let own = start.terms.iter().map(|term| &term.id);
            let order: Vec<String> = own.chain(&ids).cloned().collect();
            let steps = self.falling(&base, &fitted, &order)?;
            // What predicts held-out time worse than no effect at all explains nothing.
            if !raises(&steps) || found.found.pop().is_none() {
                break (fitted, ids, steps);
            }
            found.model = None;
        };
        let rivals = found.found.iter().filter(|one| !one.rivals.is_empty() && ids.contains(&one.id));
        let group = |one: &Selected| Confounded {
            ids: std::iter::once(one.id.clone()).chain(one.rivals.iter().cloned()).collect(),
        };
        let confounded = rivals.map(group).collect();
        Ok(Explanation {
            confounded,
            first: found.first,
            last: found.last,
            dropped: found.dropped,
            ended_early: found.ended_early,
            count: found.candidates.max(1),
            ..Explanation::plain(base, fitted, steps)
        })
    }
}

/// Whether all effects together raise the held-out error.
fn raises(steps: &[Step]) -> bool {
    let held_out = |step: Option<&Step>| step.and_then(|step| step.held_out);
    held_out(steps.first()).zip(held_out(steps.last())).is_some_and(|(first, last)| last > RAISES * first)
}
