//! What explains a log: the base model, the effects that were asked for, and those that a search finds.

use crate::base::engine::Design;
use crate::base::model::Base;
use crate::base::prior::Prior;
use crate::base::quality::{NoiseEstimate, attitude_error};
use crate::noise::own::Colour;
use crate::outcome::asked::{Added, asked_for};
use crate::outcome::request::{Options, Refusal};
use crate::samples::series::{rms, second_difference_sigma};
use crate::search::candidates::Catalogue;
use crate::search::state::{Explanation, Fitter};
use ironout::fit::MAX_PREDICTED_ERROR;
use ironout::study::Model;

/// No effect is so many times the noise that finding it makes up for a predicted error this many times too large.
const HOPELESS: f64 = 20.0;

/// What a study of the magnitude stands on.
#[derive(Clone, Copy)]
pub(crate) struct Stand<'b> {
    /// The base model as `fit` gives it, if the log carries one.
    pub(crate) base: Option<&'b Base>,
    /// Whether the base is held, or most of it.
    pub(crate) held: bool,
}

/// What explains a log, and whether `--add` names a pure lag; or why nothing does.
pub(crate) type Explained<'a> = Result<(Explanation<'a>, bool), String>;

/// Fits the base model from `model`, adds what `--add` names, and searches for more where the attitude can carry it or
/// the base is held.
pub(crate) fn explain<'a>(
    design: Design<'a>,
    catalogue: &Catalogue<'a>,
    model: Model<f64>,
    known: &Prior,
    options: &Options,
    stand: Stand,
) -> Result<Explained<'a>, Refusal> {
    let Some(base) = design.fit(model, Vec::new(), known)? else {
        return Ok(Err("the fit does not converge".into()));
    };
    // Even if all structure were explained: does the attitude carry a calibration, at the noise that is surely there?
    let residuals = design.residuals(&base.model, &[])?;
    let sigma = second_difference_sigma(&residuals);
    // What second differences leave may itself be an effect, a tone for example, many times the noise: only the hopeless
    // is not searched.
    let best = NoiseEstimate {
        rms: rms(&residuals),
        floor: sigma,
        floor_least: sigma,
        structure: 1.0,
        time: 1.0,
        memory: 1.0,
        colour: Colour::White,
        misfit: 0.0,
        is_noise: false,
    };
    let accepted = stand.base.is_some_and(|base| base.predicted_share() <= MAX_PREDICTED_ERROR);
    let hopeless = !(stand.held || accepted)
        && attitude_error(&base, &best).is_none_or(|error| error > HOPELESS * MAX_PREDICTED_ERROR);
    let mut fitter = Fitter::new(design, catalogue, known);
    fitter.base_held_out = stand.base.and_then(|base| base.holdout_rms_ut);
    let Added { start, pure_lag } = match asked_for(&fitter, &base, options)? {
        Ok(added) => added,
        Err(why) => return Ok(Err(why)),
    };
    let mut explanation = match options.search && !hopeless {
        true => fitter.selected(start)?,
        false => fitter.only(base.clone(), start)?,
    };
    explanation.fitted = fitter.to_the_end(explanation.fitted)?;
    if options.search {
        explanation = fitter.that_predict(explanation, &options.add)?;
        explanation.chances = fitter.chances(&explanation.fitted)?;
        explanation = fitter.without_unshown(explanation, &options.add)?;
    } else {
        explanation.shown = fitter.shown(&explanation.fitted, &options.chances)?;
        explanation.chances =
            explanation.shown.iter().map(|shown| (shown.id.clone(), shown.p_value)).collect();
    }
    let first = match stand.base.and_then(Base::model) {
        Some(model) => design.hold(model, Vec::new(), known)?,
        None => explanation.base.clone(),
    };
    explanation.base = fitter.aligned(first)?;
    if explanation.fitted.terms.is_empty() && stand.base.is_some() {
        explanation.fitted = explanation.base.clone();
    }
    Ok(Ok((explanation, pure_lag)))
}
