//! The terms that the likelihood selected, fitted to all samples one after the other, and the tests of all candidates beside them.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, Term};
use crate::evidence::select::{Begin, Selected, select};
use crate::search::candidates::Catalogue;
use crate::search::screen::screen;
use crate::search::search;
use crate::search::several::numbered;
use crate::search::state::{Confounded, Explanation, Fitter, Judged, MOST_SEARCHED};
use crate::search::true_field::prefer;
use ironout::effect::{Acts, MAX_COEFFICIENTS, Named, Searched};
use ironout::study::Residual;

/// A step is where it was found within this share of the log.
const NEAR_SHARE: f64 = 0.02;
/// A delay and a time constant are as they were found within this share of them.
const NEAR_PAST: f64 = 0.25;

/// The candidates beside a model, the searched ones at their best places.
fn candidates<'a>(
    design: &Design,
    catalogue: &Catalogue<'a>,
    fitted: &Fitted<'a>,
) -> Result<Vec<Term<'a>>, BadShape> {
    let at_rest = design.residual == Residual::Vector;
    let mut list = catalogue.plain(at_rest);
    for named in catalogue.searched() {
        let found = finite(search::best(design, fitted, catalogue, &named))?.flatten();
        list.extend(found.and_then(|found| numbered(fitted, found)));
    }
    for named in catalogue.usable_columns().flat_map(|column| catalogue.late(column)) {
        // Of a board at rest the vector shows a column's past by a delay; a low-pass beside it is hardly another shape.
        if at_rest && named.form.searched == Some(Searched::TimeConstant) {
            continue;
        }
        // A late column stands beside the prompt one, or shows through it.
        let is_prompt = |own: Named| own.is_plain() && own.is_variant_of(&named);
        if fitted.terms.iter().filter_map(Term::named).any(is_prompt) {
            list.extend(finite(search::best(design, fitted, catalogue, &named))?.flatten());
        } else if !at_rest
            // Through a low-pass any column becomes smooth, and smooth shapes imitate each other: by heredity only.
            && named.form.searched != Some(Searched::TimeConstant)
            && finite(search::acts_late(design, fitted, catalogue, &named))?.unwrap_or(false)
        {
            // A long delay leaves little of the prompt one to show through.
            list.extend(finite(search::best(design, fitted, catalogue, &named))?.flatten());
        }
    }
    list.retain(|candidate| !fitted.terms.iter().any(|term| term.id == candidate.id));
    Ok(list)
}

/// What was found, unless some shape was not finite on the way.
pub(super) fn finite<T>(found: Result<T, BadShape>) -> Result<Option<T>, BadShape> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(BadShape::NotFinite(_)) => Ok(None),
        Err(bad) => Err(bad),
    }
}

impl<'a> Fitter<'_, 'a> {
    /// The tests of all candidates beside a model, in a thinned copy of a long log; those of `known` over all samples. Gives the number of
    /// candidates too.
    fn judge(&self, fitted: &Fitted<'a>, known: &[Term<'a>]) -> Result<(Vec<Judged<'a>>, usize), BadShape> {
        let (mut judged, count) = match self.judge_thinned(fitted)? {
            Some(judged) => judged,
            None => self.judge_here(fitted)?,
        };
        let known: Vec<Term> =
            known.iter().map(|term| Term { coefficients: [0.0; MAX_COEFFICIENTS], ..term.clone() }).collect();
        for tested in finite(screen(&self.design, fitted, &known, count))?.unwrap_or_default() {
            let term = known[tested.index].clone();
            judged.retain(|one| one.term.id != term.id);
            judged.push(Judged { term, tested });
        }
        Ok((judged, count))
    }

    /// The tests of all candidates in a thinned copy of the log, their figures those of all samples. `None` where the log is short, or lacks
    /// a term of the model there.
    fn judge_thinned(&self, fitted: &Fitted<'a>) -> Result<Option<(Vec<Judged<'a>>, usize)>, BadShape> {
        if self.design.samples.len() <= MOST_SEARCHED {
            return Ok(None);
        }
        let few = self.design.samples.thinned(self.catalogue.table(), MOST_SEARCHED);
        let over = self.catalogue.over(&few);
        let thin = Fitter::new(Design::new(&few, self.design.residual), &over, self.known);
        let terms: Option<Vec<Term>> = fitted.terms.iter().map(|term| over.again(term)).collect();
        let Some(terms) = terms else { return Ok(None) };
        let held = thin.design.hold(fitted.model, terms, self.known)?;
        let (tested, count) = thin.judge_here(&held)?;
        self.dropped.borrow_mut().append(&mut thin.dropped.borrow_mut());
        let more = fitted.rows / held.rows;
        let lifted = tested.into_iter().filter_map(|one| {
            let mut own = one.on(self.catalogue.again(&one.term)?);
            own.tested.decrease *= fitted.squares / held.squares;
            own.tested.held_out = own.tested.held_out.map(|squares| squares * more);
            Some(own)
        });
        Ok(Some((lifted.collect(), count)))
    }

    fn judge_here(&self, fitted: &Fitted<'a>) -> Result<(Vec<Judged<'a>>, usize), BadShape> {
        let mut list = candidates(&self.design, self.catalogue, fitted)?;
        if self.held() {
            // Whatever turns with the board would stand in for the soft iron that is held, a coupling of nine numbers to
            // its turning too, and with little attitude a stronger field and an offset along it are the same.
            let turns = |term: &Term| {
                [Acts::Measured, Acts::Field, Acts::Turning].iter().any(|acts| term.acts(*acts))
            };
            list.retain(|candidate| !turns(candidate));
        }
        list.retain(|candidate| !self.dropped.borrow().contains(&candidate.id));
        let count = self.independent(&list);
        let tested = loop {
            match screen(&self.design, fitted, &list, count) {
                // One candidate that runs away is no reason to give up the others.
                Err(BadShape::NotFinite(id)) if list.iter().any(|one| one.id == id) => {
                    list.retain(|one| one.id != id);
                    self.dropped.borrow_mut().push(id);
                }
                tested => break tested?,
            }
        };
        let judged = tested
            .into_iter()
            .filter_map(|tested| Some(Judged { term: list.get(tested.index)?.clone(), tested }))
            .collect();
        Ok((judged, count))
    }

    /// The model with the effects that stand in it from the beginning and those that the likelihood selects.
    pub fn selected(&self, start: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        let start = self.aligned(start)?;
        let base = match start.terms.is_empty() {
            true => start.clone(),
            false => self.design.fit(start.model, Vec::new(), self.known)?.unwrap_or_else(|| start.clone()),
        };
        let begin = Begin {
            model: &start.model,
            known: self.known,
            stay: &start.terms,
            is_at_rest: self.design.residual == Residual::Vector,
        };
        let found = select(self.design.samples, self.catalogue.table(), self.catalogue.registry, &begin)
            .unwrap_or_default();
        let mut fitted = start;
        let mut order: Vec<String> = fitted.terms.iter().map(|term| term.id.clone()).collect();
        let mut confounded = Vec::new();
        for one in &found.found {
            let Some(term) = self.found_again(&fitted, one)? else { continue };
            let id = term.id.clone();
            // What does not lower the error of all samples was seen in some of them.
            let Some(next) = self.with(&fitted, &term)?.filter(|next| next.squares < fitted.squares) else {
                continue;
            };
            fitted = self.aligned(prefer(&self.design, next, None, self.known)?)?;
            if !one.rivals.is_empty() {
                let ids = std::iter::once(id.clone()).chain(one.rivals.iter().cloned()).collect();
                confounded.push(Confounded { ids });
            }
            order.push(id);
        }
        let (first, count) = self.judge(&base, &fitted.terms)?;
        let last = if order.is_empty() { first.clone() } else { self.judge(&fitted, &[])?.0 };
        let steps = self.falling(&base, &fitted, &order)?;
        Ok(Explanation {
            base,
            fitted,
            steps,
            confounded,
            first,
            last,
            withdrawn: Vec::new(),
            dropped: self.dropped.take(),
            ended_early: found.ended_early,
            count,
            chances: Vec::new(),
            shown: Vec::new(),
        })
    }

    /// A selected term over all samples. What was searched of it is searched once more where it was found, as whoever asks for the effect
    /// has it searched.
    fn found_again(&self, fitted: &Fitted<'a>, one: &Selected) -> Result<Option<Term<'a>>, BadShape> {
        let Some(named) = self.catalogue.registry.parse(&one.id) else { return Ok(None) };
        let own = self.catalogue.build(&named, one.parameter);
        let near = |term: &Term| {
            let (searched, at) = term.searched()?;
            let length_s =
                self.design.samples.time.as_ref().map_or(0.0, |time| time[time.len() - 1] - time[0]);
            let unit = match searched {
                Searched::At => NEAR_SHARE * length_s,
                Searched::Frequency => 1.0 / length_s,
                Searched::Delay | Searched::TimeConstant => NEAR_PAST * one.parameter.abs(),
            };
            Some((at - one.parameter).abs() < unit)
        };
        let again = match named.form.searched {
            Some(_) => finite(search::best(&self.design, fitted, self.catalogue, &named))?.flatten(),
            None => None,
        };
        let term = again.filter(|term| near(term) == Some(true)).or(own);
        Ok(term.and_then(|term| numbered(fitted, Term { trials: one.places, ..term })))
    }
}
