//! The whole diagnosis of one log.

use super::at_rest::at_rest;
use super::candidates::Catalogue;
use super::engine::{BadShape, Earlier, Fitted, Known, Pass, Piece};
use super::faults::{self, DataFault, Faults};
use super::greedy::Greedy;
use super::outcome::{CandidateRow, Diagnosis, Status, StepRow, Verdict};
use super::quality::{Residue, attitude_error};
use super::samples::Samples;
use super::screen::{Candidate, screen};
use super::series::{rms, second_difference_sigma};
use super::table::Table;
use super::traces::Traces;
use super::view::View;
use super::{base, rest};
use ironout::fit::{MAX_PREDICTED_ERROR, MIN_THICKNESS};
use ironout::study::{Model, PhysicalPrior, Residual};

/// A log is taken as of a calibrated sensor if the raw magnitude spreads by at most this share of its mean ...
const CALIBRATED_SPREAD: f64 = 0.15;
/// ... and its offset is then known to this share of the field.
const CALIBRATED_OFFSET: f64 = 0.05;

/// No effect is so many times the noise that finding it makes up for a predicted error this many times too large.
const HOPELESS: f64 = 20.0;

/// The most effects that `--add` may name, as many as a calibration carries.
pub(super) const MOST_ADDED: usize = 4;

/// What to diagnose, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The field to scale to, µT; the log's own mean where absent.
    pub field_ut: Option<f64>,
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

/// The stack of a study: normal matrices of 64 columns are 33 KB each, and pass by value.
const STACK_BYTES: usize = 64 << 20;

/// The diagnosis of a log.
pub fn diagnose(table: &Table, options: &Options) -> Result<Diagnosis, Refusal> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        match thread.spawn_scoped(scope, || study(table, options)) {
            Ok(running) => match running.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            },
            // No thread to be had: the caller's own stack may do.
            Err(_) => study(table, options),
        }
    })
}

fn study(table: &Table, options: &Options) -> Result<Diagnosis, Refusal> {
    let Faults { list, mut set_aside, axes } = faults::find(table);
    let mut data_faults = list;
    let samples = Samples::take(table, &set_aside, axes);
    if samples.len() < 30 {
        return Ok(undetermined(table, &samples, data_faults, "fewer than 30 different samples".into()));
    }
    if rest::at_rest(&samples) {
        return at_rest(table, &samples, data_faults, options);
    }
    if axes != [true; 3] {
        let why = "an axis is a copy of another, so there is no ellipsoid: repair the driver".into();
        return Ok(undetermined(table, &samples, data_faults, why));
    }
    let known = Known { physical: PhysicalPrior::default(), earlier: options.earlier.clone() };
    let found = bursts(&samples, table, &set_aside, axes, &known, options)?;
    let mut samples = samples;
    for (from, to) in &found {
        let (first, last) = (samples.row[*from], samples.row[*to]);
        set_aside[first..=last].fill(true);
        data_faults.push(faults::burst_fault(table, &samples, (*from, *to)));
    }
    if !found.is_empty() {
        samples = Samples::take(table, &set_aside, axes);
    }
    merge_bursts(&mut data_faults);
    let Some((model, _)) = base::start(&samples, options.field_ut) else {
        return Ok(undetermined(
            table,
            &samples,
            data_faults,
            "no sphere or ellipsoid fits the samples".into(),
        ));
    };
    let set_aside = set_aside.iter().filter(|aside| **aside).count();
    let mut diagnosis = magnitude(table, &samples, model, &known, options, data_faults.clone(), false)?;
    if diagnosis.verdict == Verdict::Undetermined && options.earlier.is_none() {
        // Only where the attitude is at fault: full attitude with a large residual is something else.
        let field = diagnosis.calibration.map_or(f64::NAN, |calibration| calibration.field_ut);
        let open = diagnosis.predicted_error_ut.is_none_or(|error| error > MAX_PREDICTED_ERROR * field);
        if open && let Some(lower) = as_logged(table, &samples, options, data_faults)? {
            diagnosis = lower;
        } else {
            accuse_nobody(&mut diagnosis);
        }
    }
    diagnosis.samples_set_aside = set_aside;
    Ok(diagnosis)
}

/// Bursts show in the residual of the base model. They bend a fit that holds them, so it is made without what stands out
/// of it, until that is the same as before.
fn bursts(
    samples: &Samples,
    table: &Table,
    set_aside: &[bool],
    axes: [bool; 3],
    known: &Known,
    options: &Options,
) -> Result<Vec<(usize, usize)>, BadShape> {
    let all = Pass { samples, residual: Residual::Magnitude };
    let mut kept = samples.clone();
    let mut outliers = vec![false; samples.len()];
    let mut found = Vec::new();
    for _ in 0..5 {
        let pass = Pass { samples: &kept, residual: Residual::Magnitude };
        let Some((model, _)) = base::start(&kept, options.field_ut) else { break };
        let Some(fitted) = pass.fit(model, Vec::new(), known)? else { break };
        let residuals = all.residuals(&fitted.model, &[])?;
        found = faults::bursts(&residuals);
        let now = faults::outliers(&residuals);
        let share = now.iter().filter(|out| **out).count();
        // So much is no outlier but structure; without any nothing can change.
        if now == outliers || share == 0 || share * 5 > samples.len() {
            break;
        }
        let mut aside = set_aside.to_vec();
        for (row, _) in samples.row.iter().zip(&now).filter(|(_, out)| **out) {
            aside[*row] = true;
        }
        kept = Samples::take(table, &aside, axes);
        outliers = now;
    }
    let share: usize = found.iter().map(|(from, to)| to - from + 1).sum();
    let much = share as f64 > faults::BURST_SHARE * samples.len() as f64;
    Ok(if much || faults::have_company(samples, &found) { Vec::new() } else { found })
}

/// Attitude that does not carry nine parameters, in a log whose raw magnitude is nearly constant: the sensor was
/// calibrated before, so its own scale and offset are kept and only effects are looked for. `None` where that does not
/// hold, or explains nothing.
fn as_logged(
    table: &Table,
    samples: &Samples,
    options: &Options,
    data_faults: Vec<DataFault>,
) -> Result<Option<Diagnosis>, Refusal> {
    let lengths: Vec<f64> = samples
        .readings
        .iter()
        .map(|reading| reading.measured_ut.iter().map(|value| value * value).sum::<f64>().sqrt())
        .collect();
    let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
    let off: Vec<f64> = lengths.iter().map(|length| length - mean).collect();
    if rms(&off) > CALIBRATED_SPREAD * mean || base::thickness(samples) < f64::from(MIN_THICKNESS) {
        return Ok(None);
    }
    let physical = PhysicalPrior { offset_fields: CALIBRATED_OFFSET, ..PhysicalPrior::sphere() };
    let known = Known { physical, earlier: None };
    let field = options.field_ut.unwrap_or(mean);
    let matrix = base::NO_ROTATION.map(|row| row.map(|value| value * field / mean));
    let Some(model) = Model::new([0.0; 3], matrix, field, base::NO_ROTATION, 0.0) else { return Ok(None) };
    let mut found = magnitude(table, samples, model, &known, options, data_faults, true)?;
    let error = |step: Option<&StepRow>| step.and_then(|step| step.holdout_rms_ut);
    let falls = error(found.steps.first()).zip(error(found.steps.last())).is_some_and(|(a, b)| b < 0.9 * a);
    if found.verdict == Verdict::Undetermined || !falls {
        return Ok(None);
    }
    // What was held fixed was not measured: effects only.
    found.calibration = None;
    found.information = None;
    found.predicted_error_ut = None;
    found.reasons.push(
        "the attitude does not carry a calibration; the sensor is taken as calibrated before, and only effects were \
         looked for"
            .into(),
    );
    Ok(Some(found))
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

/// Bursts that touch are one.
fn merge_bursts(list: &mut Vec<DataFault>) {
    let mut merged: Vec<DataFault> = Vec::new();
    let bursts = list.iter().filter(|fault| fault.kind == faults::FaultKind::Burst).cloned();
    let mut sorted: Vec<DataFault> = bursts.collect();
    sorted.sort_by(|a, b| a.from_s.unwrap_or(0.0).total_cmp(&b.from_s.unwrap_or(0.0)));
    for fault in sorted {
        match merged.last_mut() {
            Some(last) if fault.from_s.zip(last.to_s).is_some_and(|(from, to)| from <= to + 0.3) => {
                last.to_s = fault.to_s.zip(last.to_s).map(|(a, b)| a.max(b));
                last.samples += fault.samples;
            }
            _ => merged.push(fault),
        }
    }
    list.retain(|fault| fault.kind != faults::FaultKind::Burst);
    list.extend(merged);
}

pub(super) fn undetermined(
    table: &Table,
    samples: &Samples,
    data_faults: Vec<DataFault>,
    why: String,
) -> Diagnosis {
    let catalogue = Catalogue::new(samples, table);
    Diagnosis {
        verdict: Verdict::Undetermined,
        reasons: vec![why],
        residual: Residual::Magnitude.name(),
        steps: Vec::new(),
        noise_floor_ut: None,
        residual_floor_ut: None,
        candidates: untestable(&catalogue),
        data_faults,
        dip: None,
        heading: None,
        shows: Vec::new(),
        effects: Vec::new(),
        calibration: None,
        offset_std_errors_ut: [f64::NAN; 3],
        matrix_std_errors: [[f64::NAN; 3]; 3],
        rotation_errors: None,
        axis_order: None,
        information: None,
        predicted_error_ut: None,
        samples_used: samples.len(),
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

fn magnitude(
    table: &Table,
    samples: &Samples,
    model: Model<f64>,
    known: &Known,
    options: &Options,
    data_faults: Vec<DataFault>,
    lower_order: bool,
) -> Result<Diagnosis, Refusal> {
    let catalogue = Catalogue::new(samples, table);
    let pass = Pass { samples, residual: Residual::Magnitude };
    let Some(base) = pass.fit(model, Vec::new(), known)? else {
        return Ok(undetermined(table, samples, data_faults, "the fit does not converge".into()));
    };
    // Even if all structure were explained: does the attitude carry a calibration, at the noise that is surely there?
    let residuals = pass.residuals(&base.model, &[])?;
    let sigma = second_difference_sigma(&residuals);
    // What second differences leave may itself be an effect, a tone for example, many times the noise: only the hopeless
    // is not searched.
    let best = Residue { rms: rms(&residuals), floor: sigma, structure: 1.0, time: 1.0 };
    let hopeless = !lower_order
        && attitude_error(&base, &best).is_none_or(|error| error > HOPELESS * MAX_PREDICTED_ERROR);
    let greedy = Greedy { pass, catalogue: &catalogue, known };
    let mut pure_lag = false;
    let mut start = base.clone();
    for id in &options.add {
        if start.pieces.len() >= MOST_ADDED {
            return Err(Refusal::CannotAdd(
                id.clone(),
                format!("a model carries at most {MOST_ADDED} effects"),
            ));
        }
        let piece = added(&pass, &catalogue, &start, id)?;
        let Some(piece) = piece else {
            if id == "misalignment" || id == "axis-order" {
                continue;
            }
            return Err(Refusal::CannotAdd(id.clone(), cannot_add(&catalogue, id)));
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
        let mut pieces = start.pieces.clone();
        pieces.push(piece);
        match pass.fit(start.model, pieces, known)? {
            Some(next) => start = greedy.aligned(next)?,
            None => return Err(Refusal::CannotAdd(id.clone(), "the fit with it does not converge".into())),
        }
    }
    let explanation = if options.search && !hopeless {
        greedy.certain(greedy.run(start)?, &options.add)?
    } else {
        greedy.only(base.clone(), start)?
    };
    let mut view = View { table, samples, catalogue: &catalogue, pass, known, explanation, lower_order };
    view.explanation.base = greedy.aligned(view.explanation.base.clone())?;
    view.finish(data_faults, pure_lag)
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
