//! What explains a log: the base model, the effects that were asked for, and those that a search finds.

use crate::base::engine::Design;
use crate::base::model::Base;
use crate::base::prior::Prior;
use crate::base::term::Term;
use crate::outcome::asked::{Added, asked_for};
use crate::outcome::request::{Options, Refusal};
use crate::search::candidates::Catalogue;
use crate::search::state::{Explanation, Fitter};
use ironout::study::Model;

/// What explains a log, and whether `--add` names a pure lag; or why nothing does.
pub(crate) type Explained<'a> = Result<(Explanation<'a>, bool), String>;

/// Fits the base model from `model`, adds what `--add` names, and searches for more. `fit` is the base model as `fit` gives it, if the log
/// carries one.
pub(crate) fn explain<'a>(
    design: Design<'a>,
    catalogue: &Catalogue<'a>,
    model: Model<f64>,
    known: &Prior,
    options: &Options,
    fit: Option<&Base>,
) -> Result<Explained<'a>, Refusal> {
    let Some(base) = design.fit(model, Vec::new(), known)? else {
        return Ok(Err("the fit does not converge".into()));
    };
    let mut fitter = Fitter::new(design, catalogue, known);
    fitter.base_held_out = fit.and_then(|base| base.holdout_rms_ut);
    let Added { start, pure_lag } = match asked_for(&fitter, &base, options)? {
        Ok(added) => added,
        Err(why) => return Ok(Err(why)),
    };
    let mut explanation = match options.search {
        true => fitter.selected(start)?,
        false => fitter.only(base.clone(), start)?,
    };
    explanation.fitted = fitter.to_the_end(explanation.fitted)?;
    if options.search {
        explanation = fitter.that_hold(explanation, &options.add)?;
    } else {
        let known = |term: &Term| options.chances.iter().any(|(id, _)| *id == term.id);
        explanation.chances = match explanation.fitted.terms.iter().all(known) {
            true => options.chances.clone(),
            false => fitter.chances(&explanation.fitted),
        };
        explanation.shown = fitter.shown(&explanation.fitted, &explanation.chances)?;
    }
    let first = match fit.and_then(Base::model) {
        Some(model) => design.hold(model, Vec::new(), known)?,
        None => explanation.base.clone(),
    };
    explanation.base = fitter.aligned(first)?;
    if explanation.fitted.terms.is_empty() && fit.is_some() {
        explanation.fitted = explanation.base.clone();
    }
    Ok(Ok((explanation, pure_lag)))
}
