//! The whole diagnosis of one log.

use super::at_rest::at_rest;
use super::base;
use super::candidates::Catalogue;
use super::engine::{BadShape, Earlier, Fitted, Known, Pass, Piece};
use super::greedy::{Explanation, Greedy, held_out_rms};
use super::lower_order::as_logged;
use super::outcome::{CandidateRow, Diagnosis, Status, Verdict};
use super::quality::{Residue, attitude_error};
use super::samples::Samples;
use super::screen::{Candidate, screen};
use super::series::{rms, second_difference_sigma};
use super::table::Table;
use super::traces::Traces;
use super::view::View;
use crate::ground::{Alignment, Base, Counted, Ground, with_room};
use ironout::fit::{MAX_PREDICTED_ERROR, Method};
use ironout::study::{Model, Residual};

/// No effect is so many times the noise that finding it makes up for a predicted error this many times too large.
const HOPELESS: f64 = 20.0;

/// Fewer samples are no study.
const FEWEST: usize = 30;

/// The most effects that `--add` may name, as many as a calibration carries.
pub(super) const MOST_ADDED: usize = 4;

/// What to diagnose, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The field to scale to, µT; the log's own mean where absent.
    pub field_ut: Option<f64>,
    /// The method of the base model. A model with effects is fitted all at once, by Levenberg–Marquardt.
    pub method: Method,
    /// Effects that stand in the model from the beginning.
    pub add: Vec<String>,
    /// Whether to search for more.
    pub search: bool,
    /// An earlier calibration.
    pub earlier: Option<Earlier>,
}

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// The shape of this effect is not finite.
    BadShape(String),
    /// `--add` names an effect that is not known, or that this log does not allow: its id, and why.
    CannotAdd(String, String),
}

impl From<BadShape> for Refusal {
    fn from(BadShape(id): BadShape) -> Self {
        Refusal::BadShape(id)
    }
}

/// The diagnosis of a log.
pub fn diagnose(table: &Table, options: &Options) -> Result<Diagnosis, Refusal> {
    with_room(|| study(&Ground::of(table, options.method, options.field_ut), options))
}

/// The diagnosis of a log whose samples are sorted out, with [`crate::ground::with_room`] to work in.
pub fn study(ground: &Ground, options: &Options) -> Result<Diagnosis, Refusal> {
    let counted = &ground.counted;
    let mut diagnosis = of_kind(ground, options)?;
    diagnosis.data_faults.clone_from(&counted.faults);
    diagnosis.samples_used = counted.studied();
    diagnosis.samples_set_aside = counted.set_aside();
    diagnosis.base =
        ground.base.as_ref().ok().filter(|_| !counted.rests && options.earlier.is_none()).cloned();
    Ok(diagnosis)
}

fn of_kind(ground: &Ground, options: &Options) -> Result<Diagnosis, Refusal> {
    let Counted { table, samples, .. } = &ground.counted;
    if samples.len() < FEWEST {
        let why = match ground.counted.at_rest {
            0 => format!("fewer than {FEWEST} different samples"),
            rest => {
                format!("{} samples in motion are too few ({rest} are of a resting board)", samples.len())
            }
        };
        return Ok(undetermined(table, samples, why));
    }
    if ground.counted.rests {
        return at_rest(table, samples, options);
    }
    if ground.counted.axes != [true; 3] {
        let why = "an axis is a copy of another, so there is no ellipsoid: repair the driver".into();
        return Ok(undetermined(table, samples, why));
    }
    let known = Known { earlier: options.earlier.clone(), ..Known::default() };
    let Some((model, _)) = base::start(samples, options.field_ut) else {
        return Ok(undetermined(table, samples, "no sphere or ellipsoid fits the samples".into()));
    };
    // On top of an earlier calibration the base is fitted with it, which sums alone cannot.
    let base = ground.base.as_ref().ok().filter(|_| options.earlier.is_none());
    let mut diagnosis = magnitude(table, samples, model, &known, options, Stand { base, held: false })?;
    if diagnosis.verdict == Verdict::Undetermined && options.earlier.is_none() {
        // Only where the attitude is at fault: full attitude with a large residual is something else.
        let field = diagnosis.calibration.map_or(f64::NAN, |calibration| calibration.field_ut);
        let open = diagnosis.predicted_error_ut.is_none_or(|error| error > MAX_PREDICTED_ERROR * field);
        if open && let Some(lower) = as_logged(table, samples, options)? {
            diagnosis = lower;
        } else {
            accuse_nobody(&mut diagnosis);
        }
    }
    Ok(diagnosis)
}

/// Where the base is not determined nothing that stands on it may be claimed.
fn accuse_nobody(diagnosis: &mut Diagnosis) {
    diagnosis.steps.truncate(1);
    diagnosis.effects.clear();
    diagnosis.axis_order = None;
    for row in diagnosis.candidates.iter_mut().filter(|row| row.status != Status::Untestable) {
        row.status = Status::Untestable;
        row.why = "the data do not support a calibration, so this cannot be told".into();
        row.p_value = None;
        row.holdout_rms_ut = None;
        row.confounded_with.clear();
    }
}

pub(super) fn undetermined(table: &Table, samples: &Samples, why: String) -> Diagnosis {
    let catalogue = Catalogue::new(samples, table);
    Diagnosis {
        verdict: Verdict::Undetermined,
        reasons: vec![why],
        residual: Residual::Magnitude.name(),
        steps: Vec::new(),
        noise_floor_ut: None,
        residual_floor_ut: None,
        candidates: untestable(&catalogue),
        data_faults: Vec::new(),
        dip: None,
        heading: None,
        shows: Vec::new(),
        effects: Vec::new(),
        calibration: None,
        std_errors: None,
        alignment: Alignment::None,
        axis_order: None,
        information: None,
        converged: true,
        base: None,
        predicted_error_ut: None,
        samples_used: 0,
        samples_set_aside: 0,
        prior: String::new(),
        lower_order: false,
        traces: Traces::default(),
    }
}

pub(super) fn untestable(catalogue: &Catalogue) -> Vec<CandidateRow> {
    catalogue
        .untestable()
        .into_iter()
        .map(|one| CandidateRow {
            residual: if ["misalignment", "axis-order", "lag"].contains(&one.id.as_str()) {
                "dip"
            } else {
                "magnitude"
            },
            id: one.id,
            name: one.name,
            status: Status::Untestable,
            holdout_rms_ut: None,
            p_value: None,
            confounded_with: Vec::new(),
            why: one.why,
            angle_deg: None,
        })
        .collect()
}

/// The pieces of `--add`, in their order; searched parameters are searched.
pub(super) fn added<'a>(
    pass: &Pass,
    catalogue: &Catalogue<'a>,
    fitted: &Fitted<'a>,
    id: &str,
) -> Result<Option<Piece<'a>>, Refusal> {
    let plain = catalogue.plain(pass.residual == Residual::Vector).into_iter().find(|piece| piece.id == id);
    if plain.is_some() {
        return Ok(plain);
    }
    let found = match id {
        "step" => super::search::step(pass, fitted, catalogue)?,
        "periodic" => super::search::periodic(pass, fitted, catalogue)?,
        _ => match id.strip_prefix("offset:").and_then(|rest| rest.strip_suffix("@delay")) {
            Some(column) => match catalogue.usable(column) {
                Some(index) => super::search::delay(pass, fitted, catalogue, index)?,
                None => None,
            },
            None => None,
        },
    };
    Ok(found.map(|candidate| candidate.piece))
}

/// What a study of the magnitude stands on.
#[derive(Clone, Copy)]
pub(super) struct Stand<'b> {
    /// The base model as `fit` gives it, if the log carries one.
    pub(super) base: Option<&'b Base>,
    /// Whether the base is held, or most of it.
    pub(super) held: bool,
}

/// What explains a log, and whether `--add` names a pure lag; or why nothing does.
pub(super) type Explained<'a> = Result<(Explanation<'a>, bool), String>;

fn magnitude(
    table: &Table,
    samples: &Samples,
    model: Model<f64>,
    known: &Known,
    options: &Options,
    stand: Stand,
) -> Result<Diagnosis, Refusal> {
    let catalogue = Catalogue::new(samples, table);
    let pass = Pass { samples, residual: Residual::Magnitude };
    let (explanation, pure_lag) = match explain(pass, &catalogue, model, known, options, stand)? {
        Ok(explained) => explained,
        Err(why) => return Ok(undetermined(table, samples, why)),
    };
    let base = stand.base;
    View { table, samples, catalogue: &catalogue, pass, known, explanation, lower_order: None, base }
        .finish(pure_lag)
}

/// Fits the base model from `model`, adds what `--add` names, and searches for more where the attitude can carry it or
/// the base is held.
pub(super) fn explain<'a>(
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
    let best = Residue { rms: rms(&residuals), floor: sigma, structure: 1.0, time: 1.0 };
    let accepted = stand.base.is_some_and(|base| base.predicted_share() <= MAX_PREDICTED_ERROR);
    let hopeless = !(stand.held || accepted)
        && attitude_error(&base, &best).is_none_or(|error| error > HOPELESS * MAX_PREDICTED_ERROR);
    let greedy = Greedy { pass, catalogue, known };
    let mut pure_lag = false;
    let mut start = base.clone();
    for id in &options.add {
        if start.pieces.len() >= MOST_ADDED {
            return Err(Refusal::CannotAdd(
                id.clone(),
                format!("a model carries at most {MOST_ADDED} effects"),
            ));
        }
        let piece = added(&pass, catalogue, &start, id)?;
        let Some(piece) = piece else {
            if id == "misalignment" || id == "axis-order" {
                continue;
            }
            return Err(Refusal::CannotAdd(id.clone(), cannot_add(catalogue, id)));
        };
        if start.pieces.iter().any(|known| known.id == piece.id) {
            continue;
        }
        if id == "lag" && catalogue.has_down() {
            // Which of the two lags it is, the data decide.
            let alone = screen(&pass, &start, &[Candidate { piece: piece.clone(), searched: 1.0 }], 1)?;
            if !alone.tested.first().is_some_and(|tested| tested.accepted) {
                pure_lag = true;
                continue;
            }
        }
        match greedy.with(&start, &piece)? {
            Some(next) => start = greedy.aligned(next)?,
            None => {
                let why = format!(
                    "the fit with {id} does not converge: this log hardly tells it from the calibration; leave it out, or record more"
                );
                return Ok(Err(why));
            }
        }
    }
    let mut explanation = if options.search && !hopeless {
        greedy.certain(greedy.run(start)?, &options.add)?
    } else {
        greedy.only(base.clone(), start)?
    };
    explanation.fitted = greedy.to_the_end(explanation.fitted)?;
    if let (Some(last), false) = (explanation.steps.last_mut(), explanation.fitted.pieces.is_empty()) {
        (last.rms, last.held_out) = (explanation.fitted.rms(), held_out_rms(&explanation.fitted));
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

pub(super) fn cannot_add(catalogue: &Catalogue, id: &str) -> String {
    if let Some(one) = catalogue.untestable().into_iter().find(|one| one.id == id) {
        return one.why;
    }
    let mut known: Vec<String> = catalogue.plain(false).into_iter().map(|piece| piece.id).collect();
    known.extend(["step", "periodic"].map(String::from));
    known.extend(catalogue.usable_columns().map(|(_, name)| format!("offset:{name}@delay")));
    format!("unknown effect; this log allows {}", known.join(", "))
}
