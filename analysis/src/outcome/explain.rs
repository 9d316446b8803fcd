//! What explains a log: the base model, the effects that were asked for, and those that a search finds.

use crate::base::engine::{Fitted, Pass};
use crate::base::known::Known;
use crate::base::model::Base;
use crate::base::mounting;
use crate::base::quality::{Residue, attitude_error};
use crate::noise::colour::Colour;
use crate::outcome::request::{Options, Refusal};
use crate::samples::series::{rms, second_difference_sigma};
use crate::search::candidates::Catalogue;
use crate::search::screen::{Candidate, screen};
use crate::search::search;
use crate::search::state::{Explanation, Greedy};
use ironout::effect::Named;
use ironout::fit::MAX_PREDICTED_ERROR;
use ironout::study::{Model, Residual};
use std::collections::VecDeque;

/// No effect is so many times the noise that finding it makes up for a predicted error this many times too large.
const HOPELESS: f64 = 20.0;

/// The most effects that `--add` may name, as many as a calibration carries.
pub(crate) const MOST_ADDED: usize = 4;

/// An effect of `--add`; what fixes its shape is searched.
pub(crate) fn added<'a>(
    pass: &Pass,
    catalogue: &Catalogue<'a>,
    fitted: &Fitted<'a>,
    id: &str,
) -> Result<Option<Candidate<'a>>, Refusal> {
    let plain = catalogue.plain(pass.residual == Residual::Vector).into_iter().find(|piece| piece.id == id);
    if let Some(piece) = plain {
        return Ok(Some(Candidate { piece, searched: 1.0 }));
    }
    let Some(named) = catalogue.registry.parse(id).filter(|named| named.form.offered) else {
        return Ok(None);
    };
    let mut found = search::best(pass, fitted, catalogue, &named)?;
    if let Some(found) = found.as_mut().filter(|_| named.form.is_repeated()) {
        found.piece.id = id.to_string();
    }
    Ok(found)
}

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
    pass: Pass<'a>,
    catalogue: &Catalogue<'a>,
    model: Model<f64>,
    known: &Known,
    options: &Options,
    stand: Stand,
) -> Result<Explained<'a>, Refusal> {
    let Some(base) = pass.fit(model, Vec::new(), known)? else {
        return Ok(Err("the fit does not converge".into()));
    };
    // Even if all structure were explained: does the attitude carry a calibration, at the noise that is surely there?
    let residuals = pass.residuals(&base.model, &[])?;
    let sigma = second_difference_sigma(&residuals);
    // What second differences leave may itself be an effect, a tone for example, many times the noise: only the hopeless
    // is not searched.
    let best = Residue {
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
    let mut greedy = Greedy::new(pass, catalogue, known);
    greedy.base_held_out = stand.base.and_then(|base| base.holdout_rms_ut);
    let mut pure_lag = false;
    let mut start = base.clone();
    let mut searched: Vec<(String, f64)> = Vec::new();
    // One that a fit does not hold by itself may stand beside those that come after it.
    let mut waiting: VecDeque<&String> = options.add.iter().collect();
    let mut put_off: Vec<Candidate> = Vec::new();
    while let Some(id) = waiting.pop_front() {
        if start.pieces.len() >= MOST_ADDED {
            return Err(Refusal::cannot_add(id, format!("a model carries at most {MOST_ADDED} effects")));
        }
        let Some(candidate) = added(&pass, catalogue, &start, id)? else {
            if mounting::is_one(id) {
                continue;
            }
            return Err(Refusal::cannot_add(id, cannot_add(catalogue, id)));
        };
        if start.pieces.iter().any(|known| known.id == candidate.piece.id) {
            continue;
        }
        if !candidate.piece.hidden_delay().is_empty() && catalogue.has_down() {
            // Whether it is the coupling or the pure delay, the data decide.
            let alone = screen(&pass, &start, std::slice::from_ref(&candidate), 1)?;
            if !alone.tested.first().is_some_and(|tested| tested.accepted) {
                pure_lag = true;
                continue;
            }
        }
        match greedy.with(&start, &candidate.piece)? {
            Some(next) => {
                searched.push((candidate.piece.id.clone(), candidate.searched));
                start = greedy.aligned(next)?;
                put_off.clear();
            }
            None => {
                put_off.push(candidate);
                if put_off.len() <= waiting.len() {
                    waiting.push_back(id);
                    continue;
                }
                // None of those that are left stands without the others.
                searched.extend(put_off.iter().map(|one| (one.piece.id.clone(), one.searched)));
                match greedy.with_all(&start, put_off.iter().map(|one| &one.piece))? {
                    Some(next) => start = greedy.aligned(next)?,
                    None => return Ok(Err(does_not_converge(&put_off))),
                }
                break;
            }
        }
    }
    let mut explanation = if options.search && !hopeless {
        greedy.certain(greedy.search(start)?, &options.add)?
    } else {
        greedy.only(base.clone(), start)?
    };
    explanation = greedy.ended(explanation, &options.add, options.search)?;
    if !options.search {
        let places = |id: &str| searched.iter().find(|(own, _)| own == id).map_or(1.0, |(_, places)| *places);
        explanation.shown = greedy.shown(&explanation.fitted, places)?;
    }
    let first = match stand.base.and_then(Base::model) {
        Some(model) => pass.hold(model, Vec::new(), known)?,
        None => explanation.base.clone(),
    };
    explanation.base = greedy.aligned(first)?;
    if explanation.fitted.pieces.is_empty() && stand.base.is_some() {
        explanation.fitted = explanation.base.clone();
    }
    Ok(Ok((explanation, pure_lag)))
}

fn does_not_converge(list: &[Candidate]) -> String {
    let ids: Vec<&str> = list.iter().map(|one| one.piece.id.as_str()).collect();
    format!(
        "the fit with {} does not converge: this log hardly tells it from the calibration; leave it out, or record more",
        ids.join(" and ")
    )
}

pub(crate) fn cannot_add(catalogue: &Catalogue, id: &str) -> String {
    if let Some(one) = catalogue.untestable().into_iter().find(|one| one.id == id) {
        return one.why;
    }
    let mut known: Vec<String> = catalogue.plain(false).into_iter().map(|piece| piece.id).collect();
    known.extend(catalogue.searched().iter().map(Named::to_string));
    let late = catalogue.usable_columns().flat_map(|column| catalogue.late(column));
    known.extend(late.map(|named| named.to_string()));
    format!("unknown effect; this log allows {}", known.join(", "))
}
