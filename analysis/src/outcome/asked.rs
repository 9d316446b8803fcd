//! The effects that `--add` asks for, put into the model.

use crate::base::engine::{Design, Fitted};
use crate::base::mounting;
use crate::base::term::Term;
use crate::outcome::request::{Options, Refusal};
use crate::search::candidates::Catalogue;
use crate::search::screen::screen;
use crate::search::search;
use crate::search::state::{Fitter, MOST_SEARCHED};
use crate::similar;
use ironout::effect::Named;
use ironout::study::Residual;
use std::collections::VecDeque;

/// The most effects that `--add` may name, as many as a calibration carries.
pub(crate) const MOST_ADDED: usize = 4;

/// An effect of `--add`; what fixes its shape is searched.
pub(crate) fn added<'a>(
    design: &Design,
    catalogue: &Catalogue<'a>,
    fitted: &Fitted<'a>,
    id: &str,
) -> Result<Option<Term<'a>>, Refusal> {
    let plain = catalogue.plain(design.residual == Residual::Vector).into_iter().find(|term| term.id == id);
    if let Some(term) = plain {
        return Ok(Some(term));
    }
    let Some(named) = catalogue.registry.parse(id) else {
        return Ok(None);
    };
    if !named.form.offered {
        // What no search offers is added all the same, where nothing of it is searched for.
        return Ok(catalogue.build(&named, 0.0).filter(|_| named.form.searched.is_none()));
    }
    let mut found = search::best(design, fitted, catalogue, &named)?;
    if let Some(found) = found.as_mut().filter(|_| named.form.is_repeated()) {
        found.id = id.to_string();
    }
    Ok(found)
}

/// Whether it may be a coupling or a pure delay, which the data decide.
fn is_coupling(id: &str, options: &Options) -> bool {
    let named = options.registry.parse(id);
    named.is_some_and(|named| !named.family.delay_coefficients(named.form).is_empty())
}

/// A model with the effects that were asked for.
pub(crate) struct Added<'a> {
    /// It.
    pub(crate) start: Fitted<'a>,
    /// Whether a pure lag was asked for.
    pub(crate) pure_lag: bool,
}

/// Adds what `--add` names to the base model; or why that cannot be fitted. In a long log the way there is gone in a thinned
/// copy, as a search goes it, and only its end on all samples.
pub(crate) fn asked_for<'a>(
    fitter: &Fitter<'_, 'a>,
    base: &Fitted<'a>,
    options: &Options,
) -> Result<Result<Added<'a>, String>, Refusal> {
    let (samples, catalogue) = (fitter.design.samples, fitter.catalogue);
    if samples.len() <= MOST_SEARCHED || options.add.is_empty() {
        return one_by_one(fitter, base, options);
    }
    // Whether it is a coupling or a pure delay every sample has a say in, beside all others.
    let (couplings, others): (Vec<String>, Vec<String>) =
        options.add.iter().cloned().partition(|id| is_coupling(id, options));
    if !couplings.is_empty() {
        let asked = |add| Options { add, ..options.clone() };
        let beside = match others.is_empty() {
            true => None,
            false => asked_for(fitter, base, &asked(others))?.ok(),
        };
        return match beside {
            Some(Added { start, .. }) => one_by_one(fitter, &start, &asked(couplings)),
            None => one_by_one(fitter, base, options),
        };
    }
    let few = samples.thinned(catalogue.table(), MOST_SEARCHED);
    let over = catalogue.over(&few);
    let design = Design::new(&few, fitter.design.residual);
    let Some(thin) = design.fit(base.model, Vec::new(), fitter.known)? else {
        return one_by_one(fitter, base, options);
    };
    let found = match one_by_one(&Fitter::new(design, &over, fitter.known), &thin, options)? {
        Ok(found) => found,
        Err(why) => return Ok(Err(why)),
    };
    let Added { start, pure_lag } = found;
    // None of them may be lost on the way.
    let terms: Option<Vec<Term>> = start.terms.iter().map(|term| catalogue.again(term)).collect();
    let Some(terms) = terms else { return one_by_one(fitter, base, options) };
    let lifted = match fitter.design.fit(start.model, terms, fitter.known)? {
        Some(fitted) => Some(fitter.settled(fitted)?).filter(|fitted| fitted.converged),
        None => None,
    };
    Ok(match lifted {
        Some(fitted) => Ok(Added { start: fitter.aligned(fitted)?, pure_lag }),
        None => Err(does_not_converge(start.terms.iter().map(|term| term.id.as_str()))),
    })
}

/// Adds what `--add` names, one after the other.
fn one_by_one<'a>(
    fitter: &Fitter<'_, 'a>,
    base: &Fitted<'a>,
    options: &Options,
) -> Result<Result<Added<'a>, String>, Refusal> {
    let (design, catalogue) = (&fitter.design, fitter.catalogue);
    let mut pure_lag = false;
    let mut start = base.clone();
    // One that a fit does not hold by itself may stand beside those that come after it.
    let mut waiting: VecDeque<&String> = options.add.iter().collect();
    // Which of the two a coupling is shows only beside the others.
    waiting.make_contiguous().sort_by_key(|id| is_coupling(id, options));
    let mut put_off: Vec<Term> = Vec::new();
    while let Some(id) = waiting.pop_front() {
        if start.terms.len() >= MOST_ADDED {
            return Err(Refusal::cannot_add(id, format!("a calibration holds at most {MOST_ADDED} effects")));
        }
        let Some(candidate) = added(design, catalogue, &start, id)? else {
            if mounting::is_one(id) {
                continue;
            }
            return Err(Refusal::cannot_add(id, cannot_add(catalogue, id)));
        };
        if start.terms.iter().any(|known| known.id == candidate.id) {
            continue;
        }
        if !candidate.hidden_delay().is_empty() && catalogue.has_down() {
            // Whether it is the coupling or the pure delay, the data decide.
            let alone = screen(design, &start, std::slice::from_ref(&candidate), 1)?;
            if !alone.first().is_some_and(|tested| tested.accepted) {
                pure_lag = true;
                continue;
            }
        }
        match fitter.with(&start, &candidate)? {
            Some(next) => {
                start = fitter.aligned(next)?;
                put_off.clear();
            }
            None => {
                put_off.push(candidate);
                if put_off.len() <= waiting.len() {
                    waiting.push_back(id);
                    continue;
                }
                // None of those that are left stands without the others.
                match fitter.with_all(&start, put_off.iter())? {
                    Some(next) => start = fitter.aligned(next)?,
                    None => {
                        return Ok(Err(does_not_converge(put_off.iter().map(|one| one.id.as_str()))));
                    }
                }
                break;
            }
        }
    }
    Ok(Ok(Added { start, pure_lag }))
}

fn does_not_converge<'i>(ids: impl Iterator<Item = &'i str>) -> String {
    let ids: Vec<&str> = ids.collect();
    format!(
        "the fit with {} does not converge: in this log the effect and the calibration are nearly collinear. Fix: drop it, \
         or record more",
        ids.join(" and ")
    )
}

pub(crate) fn cannot_add(catalogue: &Catalogue, id: &str) -> String {
    if let Some(one) = catalogue.untestable().into_iter().find(|one| one.id == id) {
        return one.why;
    }
    let mut known: Vec<String> = catalogue.plain(false).into_iter().map(|term| term.id).collect();
    known.extend(catalogue.searched().iter().map(Named::to_string));
    let late = catalogue.usable_columns().flat_map(|column| catalogue.late(column));
    known.extend(late.map(|named| named.to_string()));
    similar::unknown_effect(id, &known)
}
