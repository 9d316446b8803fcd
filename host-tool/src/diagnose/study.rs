//! The whole diagnosis of one log.

use super::alignment::{Alignment, align, rotation_covariance, without_effects};
use super::candidates::Catalogue;
use super::engine::{BadShape, Earlier, Fitted, Known, Pass, Piece};
use super::faults::{self, DataFault, Faults};
use super::greedy::{Explanation, Greedy, Judged};
use super::outcome::{CandidateRow, Diagnosis, Dip, FittedEffect, Heading, Status, StepRow, Verdict, Where};
use super::quality::{Residue, covariance, covariance_of, information, noise_gain, predicted_error, residue};
use super::samples::Samples;
use super::screen::{Candidate, SIGNIFICANCE, screen};
use super::series::{rms, second_difference_sigma};
use super::table::Table;
use super::traces::Traces;
use super::{base, rest};
use ironout::calibration::Calibration;
use ironout::fit::MAX_PREDICTED_ERROR;
use ironout::quality::MAX_RESIDUAL;
use ironout::study::{Model, PhysicalPrior, Residual};
use nalgebra::Vector3;

/// A log is taken as of a calibrated sensor if the raw magnitude spreads by at most this share of its mean ...
const CALIBRATED_SPREAD: f64 = 0.15;
/// ... and its offset is then known to this share of the field.
const CALIBRATED_OFFSET: f64 = 0.05;

/// The most effects that `--add` may name, as many as a calibration carries.
const MOST_ADDED: usize = 4;

/// A rotation between the sensors beyond this is worth a word, degrees: soft iron itself may turn the field by less.
const MISALIGNED_DEG: f64 = 4.0;

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

/// The diagnosis of a log.
pub fn diagnose(table: &Table, options: &Options) -> Result<Diagnosis, Refusal> {
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
    // Bursts show in the residual of the base model; the model improves as they go.
    let mut samples = samples;
    let mut burst_samples = 0;
    for _ in 0..4 {
        let pass = Pass { samples: &samples, residual: Residual::Magnitude };
        let Some((model, _)) = base::start(&samples, options.field_ut) else { break };
        let Some(fitted) = pass.fit(model, Vec::new(), &known)? else { break };
        let found = faults::bursts(&pass.residuals(&fitted.model, &[])?);
        let share: usize = found.iter().map(|(from, to)| to - from + 1).sum();
        burst_samples += share;
        if found.is_empty()
            || faults::have_company(&samples, &found)
            || burst_samples as f64 > faults::BURST_SHARE * samples.len() as f64
        {
            break;
        }
        for (from, to) in found {
            let (first, last) = (samples.row[from], samples.row[to]);
            set_aside[first..=last].fill(true);
            data_faults.push(faults::burst_fault(table, &samples, (from, to)));
        }
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
        if let Some(lower) = as_logged(table, &samples, options, data_faults)? {
            diagnosis = lower;
        } else {
            accuse_nobody(&mut diagnosis);
        }
    }
    diagnosis.samples_set_aside = set_aside;
    Ok(diagnosis)
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
    if rms(&off) > CALIBRATED_SPREAD * mean {
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

fn undetermined(table: &Table, samples: &Samples, data_faults: Vec<DataFault>, why: String) -> Diagnosis {
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
        rotation_covariance: None,
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

fn untestable(catalogue: &Catalogue) -> Vec<CandidateRow> {
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
fn added<'a>(
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
    let best = Residue { rms: rms(&residuals), floor: sigma, structure: 1.0, time: 1.0 };
    let hopeless =
        !lower_order && predicted_error(&base, &best).is_none_or(|error| error > MAX_PREDICTED_ERROR);
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
    let explanation =
        if options.search && !hopeless { greedy.run(start)? } else { greedy.only(base.clone(), start)? };
    let mut view = View { table, samples, catalogue: &catalogue, pass, known, explanation, lower_order };
    view.explanation.base = greedy.aligned(view.explanation.base.clone())?;
    view.finish(data_faults, pure_lag)
}

fn cannot_add(catalogue: &Catalogue, id: &str) -> String {
    if let Some(one) = catalogue.untestable().into_iter().find(|one| one.id == id) {
        return one.why;
    }
    let mut known: Vec<String> = catalogue.plain(false).into_iter().map(|piece| piece.id).collect();
    known.extend(["step", "periodic"].map(String::from));
    known.extend(catalogue.usable_columns().map(|(_, name)| format!("offset:{name}@delay")));
    format!("unknown effect; this log allows {}", known.join(", "))
}

/// Everything that the report of a magnitude study is made from.
struct View<'v, 'a> {
    table: &'a Table<'a>,
    samples: &'a Samples,
    catalogue: &'v Catalogue<'a>,
    pass: Pass<'a>,
    known: &'v Known,
    explanation: Explanation<'a>,
    lower_order: bool,
}

/// What the dip says in the end.
struct DipStudy<'a> {
    alignment: Alignment,
    lag: Option<(Piece<'a>, f64)>,
    after_deg: f64,
    rotation_covariance: Option<[[f64; 3]; 3]>,
    /// p-value and held-out rms in degrees of the pure lag.
    tested: Option<(f64, Option<f64>)>,
}

impl<'a> View<'_, 'a> {
    fn dip(&self, force_lag: bool) -> Result<Option<DipStudy<'a>>, BadShape> {
        let fitted = &self.explanation.fitted;
        let clean = without_effects(self.samples, &fitted.model, &fitted.pieces);
        let Some(alignment) = align(&clean, &fitted.model)? else { return Ok(None) };
        let after_deg = alignment.after_deg;
        let rotation_covariance = rotation_covariance(&clean, &alignment.model)?;
        let mut study = DipStudy { alignment, lag: None, after_deg, rotation_covariance, tested: None };
        let Some(lag) = self.catalogue.lag() else { return Ok(Some(study)) };
        let pass = Pass { samples: &clean, residual: Residual::Dip };
        let Some(base) = pass.fit(study.alignment.model, Vec::new(), self.known)? else {
            return Ok(Some(study));
        };
        let candidate = Candidate { piece: lag.clone(), searched: 1.0 };
        let screening = screen(&pass, &base, std::slice::from_ref(&candidate), 2)?;
        let Some(tested) = screening.tested.into_iter().next() else { return Ok(Some(study)) };
        let held_deg = tested.held_out.map(|squares| (squares / base.rows).sqrt().to_degrees());
        study.tested = Some((tested.p_value, held_deg));
        let has_eddy = fitted.pieces.iter().any(|piece| piece.id == lag.id);
        if (tested.accepted || force_lag || has_eddy)
            && let Some(with) = pass.fit(base.model, vec![lag], self.known)?
        {
            let residuals = pass.residuals(&with.model, &with.pieces.iter().collect::<Vec<_>>())?;
            let time = residue(&residuals, 5, 0.0).time;
            let error = covariance(&with, time).map_or(f64::NAN, |covariance| covariance[4][4].sqrt());
            study.lag = with.pieces.into_iter().next().map(|piece| (piece, error));
            if !has_eddy {
                study.alignment.model = with.model;
                study.after_deg = rms(&residuals).to_degrees();
            }
        }
        Ok(Some(study))
    }

    fn finish(mut self, data_faults: Vec<DataFault>, force_lag: bool) -> Result<Diagnosis, Refusal> {
        let dip = self.dip(force_lag)?;
        if let Some(dip) = &dip {
            let model = dip.alignment.model;
            // A mirrored frame is minus a turned one, and its dip the other way.
            let mirror = |model: Model<f64>| {
                let rotation = model.rotation.map(|row| row.map(|value| -value));
                Model::new(model.offset_ut, model.matrix, model.field_ut, rotation, -model.sin_dip)
            };
            let kept = if dip.alignment.mirrored { mirror(model) } else { None };
            self.explanation.fitted.model = kept.unwrap_or(model);
        }
        let fitted = &self.explanation.fitted;
        let list: Vec<&Piece> = fitted.pieces.iter().collect();
        let residuals = self.pass.residuals(&fitted.model, &list)?;
        let left = residue(&residuals, fitted.columns(), self.samples.quantum_ut);
        let gain = noise_gain(fitted, Residual::Magnitude);
        let predicted = predicted_error(fitted, &left);
        let field = fitted.model.field_ut;
        let mut steps = self.steps(&dip)?;
        let has_eddy = fitted.pieces.iter().any(|piece| piece.id == "lag");
        let pure_lag = dip.as_ref().is_some_and(|dip| dip.lag.is_some()) && !has_eddy;
        if let (true, Some(dip)) = (pure_lag, &dip) {
            steps.push(StepRow {
                added: Some("lag".into()),
                rms_ut: fitted.rms(),
                holdout_rms_ut: super::greedy::held_out_rms(fitted),
                dip_rms_deg: Some(dip.after_deg),
            });
        }
        let swapped = dip.as_ref().and_then(|dip| dip.alignment.axis_order.clone());
        let groups = &self.explanation.confounded;
        let in_group = |id: &str| groups.iter().any(|group| group.ids.iter().any(|other| other == id));
        let (mut verdict, reasons) = self.verdict(&left, predicted, field);
        if verdict == Verdict::Complete && (pure_lag || swapped.is_some()) {
            verdict = Verdict::Missing;
        }
        steps.retain(|step| step.added.as_ref().is_none_or(|id| !in_group(id)));
        let candidates = self.candidates(&dip, pure_lag, swapped.as_deref(), verdict);
        if let (Some(_), Some(dip)) = (&swapped, &dip) {
            steps.push(StepRow {
                added: Some("axis-order".into()),
                rms_ut: fitted.rms(),
                holdout_rms_ut: super::greedy::held_out_rms(fitted),
                dip_rms_deg: Some(dip.after_deg),
            });
        }
        let effects = self.effects(&left, &dip)?;
        let covariance = covariance(fitted, left.time);
        let sigma =
            |index: usize| covariance.as_ref().map_or(f64::NAN, |rows| rows[index][index].max(0.0).sqrt());
        let full = if dip.is_some() { fitted.model.full_matrix() } else { fitted.model.matrix };
        let headings = self.heading(&dip)?;
        Ok(Diagnosis {
            verdict,
            reasons,
            residual: Residual::Magnitude.name(),
            steps,
            noise_floor_ut: Some(left.floor / gain),
            residual_floor_ut: Some(left.floor),
            candidates,
            data_faults,
            dip: dip.as_ref().map(|dip| Dip {
                rms_deg_before: self.base_dip().unwrap_or(dip.alignment.before_deg),
                rms_deg_after: dip.after_deg,
                misalignment_deg: dip.alignment.angle_deg,
            }),
            heading: headings,
            shows: self.shows()?,
            effects,
            // With swapped axes the log is to be repaired first.
            calibration: swapped.is_none().then_some(Calibration {
                offset_ut: fitted.model.offset_ut,
                matrix: full,
                field_ut: field,
            }),
            offset_std_errors_ut: [sigma(0), sigma(1), sigma(2)],
            matrix_std_errors: [
                [sigma(3), sigma(4), sigma(5)],
                [0.0, sigma(6), sigma(7)],
                [0.0, 0.0, sigma(8)],
            ],
            rotation_covariance: dip.as_ref().and_then(|dip| dip.rotation_covariance),
            axis_order: swapped,
            information: information(&self.pass, fitted, self.known, left.time),
            predicted_error_ut: predicted.map(|error| error * field),
            samples_used: self.samples.len() * self.samples.stride,
            samples_set_aside: 0,
            prior: self.prior_words(),
            lower_order: self.lower_order,
            traces: Traces::of(&self.pass, &self.explanation.base, &self.explanation.fitted)?,
        })
    }

    fn prior_words(&self) -> String {
        if self.known.earlier.is_some() {
            "the information of the earlier calibration, and a weak physical prior".into()
        } else if self.lower_order {
            "none of the base is estimated but its scale: the sensor is taken as calibrated before, its offset within 5 % of the field".into()
        } else {
            "weak: gains within some 20 % of each other, axes within some 10°, offset within a few fields"
                .into()
        }
    }

    fn base_dip(&self) -> Option<f64> {
        let base = &self.explanation.base;
        align(self.samples, &base.model).ok().flatten().map(|alignment| alignment.before_deg)
    }

    fn steps(&self, dip: &Option<DipStudy>) -> Result<Vec<StepRow>, BadShape> {
        let count = self.explanation.steps.len();
        let base_dip =
            align(self.samples, &self.explanation.base.model)?.map(|alignment| alignment.after_deg);
        Ok(self
            .explanation
            .steps
            .iter()
            .enumerate()
            .map(|(index, step)| StepRow {
                added: step.added.clone(),
                rms_ut: step.rms,
                holdout_rms_ut: step.held_out,
                dip_rms_deg: match dip {
                    Some(dip) if index + 1 == count && index > 0 => Some(dip.alignment.after_deg),
                    Some(_) if index == 0 => base_dip,
                    _ => None,
                },
            })
            .collect())
    }

    fn verdict(&self, left: &Residue, predicted: Option<f64>, field: f64) -> (Verdict, Vec<String>) {
        let mut reasons = Vec::new();
        match predicted {
            // What is held fixed has no error to predict.
            _ if self.lower_order => {}
            Some(error) if error <= MAX_PREDICTED_ERROR => {}
            Some(error) => reasons.push(format!(
                "the corrected vector would be off by {:.1} % of the field in the worst direction (1σ): turn the board \
                 through more attitudes",
                100.0 * error
            )),
            None => reasons.push("the attitude does not determine the ellipsoid".into()),
        }
        if left.rms > MAX_RESIDUAL * field {
            reasons.push(format!("the residual is {:.1} % of the field", 100.0 * left.rms / field));
        }
        if !reasons.is_empty() {
            return (Verdict::Undetermined, reasons);
        }
        if left.structure > 0.0 {
            reasons.push(format!(
                "{:.0} % of the residual's variance is structure that no candidate explains",
                100.0 * left.structure
            ));
            return (Verdict::Unexplained, reasons);
        }
        if let Some(id) = &self.explanation.repeated {
            reasons.push(format!(
                "there is a second {id} beside the one in the model, which holds each effect once"
            ));
            return (Verdict::Unexplained, reasons);
        }
        if !self.explanation.confounded.is_empty() {
            for group in &self.explanation.confounded {
                reasons.push(format!("{} explain the same", group.ids.join(", ")));
            }
            return (Verdict::Confounded, reasons);
        }
        if self.explanation.fitted.pieces.is_empty() {
            (Verdict::Complete, reasons)
        } else {
            (Verdict::Missing, reasons)
        }
    }

    fn candidates(
        &self,
        dip: &Option<DipStudy>,
        pure_lag: bool,
        swapped: Option<&str>,
        verdict: Verdict,
    ) -> Vec<CandidateRow> {
        let rows = self.explanation.fitted.rows;
        let mut list: Vec<CandidateRow> = Vec::new();
        let row_of = |one: &Judged, status: Status, partners: Vec<String>, why: String| CandidateRow {
            id: one.candidate.piece.id.clone(),
            name: one.candidate.piece.effect.name().to_string(),
            status,
            residual: Residual::Magnitude.name(),
            holdout_rms_ut: one.tested.held_out.map(|squares| (squares / rows).sqrt()),
            p_value: Some((one.tested.p_value * self.explanation.count as f64).min(1.0)),
            confounded_with: partners,
            why,
            angle_deg: None,
        };
        let group_of = |id: &str| {
            self.explanation
                .confounded
                .iter()
                .find(|group| group.ids.iter().any(|other| other == id))
                .map(|group| group.ids.iter().filter(|other| *other != id).cloned().collect::<Vec<_>>())
        };
        for piece in &self.explanation.fitted.pieces {
            let tested = self.explanation.first.iter().find(|one| one.candidate.piece.id == piece.id);
            let partners = group_of(&piece.id);
            let status = if partners.is_some() { Status::Confounded } else { Status::Missing };
            let why = match &partners {
                Some(partners) => format!(
                    "it explains the error, and so does {}: {}",
                    partners.join(", "),
                    separating(&piece.id, partners)
                ),
                None => piece.effect.explanation().to_string(),
            };
            match tested {
                Some(one) => list.push(row_of(one, status, partners.unwrap_or_default(), why)),
                None => list.push(CandidateRow {
                    id: piece.id.clone(),
                    name: piece.effect.name().to_string(),
                    status,
                    residual: Residual::Magnitude.name(),
                    holdout_rms_ut: None,
                    p_value: None,
                    confounded_with: partners.unwrap_or_default(),
                    why,
                    angle_deg: None,
                }),
            }
        }
        for one in &self.explanation.last {
            let id = &one.candidate.piece.id;
            if list.iter().any(|row| row.id == *id) {
                continue;
            }
            if id == "lag" && dip.is_some() {
                continue;
            }
            match group_of(id) {
                Some(partners) => {
                    let why = format!(
                        "it explains the error, and so does {}: {}",
                        partners.join(", "),
                        separating(id, &partners)
                    );
                    list.push(row_of(one, Status::Confounded, partners, why));
                }
                None => {
                    let why = if verdict == Verdict::Undetermined {
                        "the data do not support a calibration, so this cannot be told".to_string()
                    } else if one.tested.p_value * (self.explanation.count as f64) < SIGNIFICANCE {
                        "there, but too small to matter".to_string()
                    } else {
                        "the data do not ask for it".to_string()
                    };
                    let status =
                        if verdict == Verdict::Undetermined { Status::Untestable } else { Status::NotNeeded };
                    list.push(row_of(one, status, Vec::new(), why));
                }
            }
        }
        if let Some(dip) = dip {
            if !list.iter().any(|row| row.id == "lag") {
                let (p, held) = dip.tested.unwrap_or((1.0, None));
                let why = match &dip.lag {
                    Some((piece, error)) if pure_lag => format!(
                        "the sensor is {:.1} ± {:.1} ms late: {}",
                        1e3 * piece.coefficients[0],
                        1e3 * error,
                        piece.effect.explanation()
                    ),
                    _ => "neither the magnitude nor the dip asks for it".to_string(),
                };
                if self.catalogue.lag().is_some() {
                    list.push(CandidateRow {
                        id: "lag".into(),
                        name: "sensor lag".into(),
                        status: if pure_lag { Status::Missing } else { Status::NotNeeded },
                        residual: Residual::Dip.name(),
                        holdout_rms_ut: held,
                        p_value: Some((2.0 * p).min(1.0)),
                        confounded_with: Vec::new(),
                        why,
                        angle_deg: None,
                    });
                }
            }
            let angle = dip.alignment.angle_deg;
            list.push(CandidateRow {
                id: "misalignment".into(),
                name: "misalignment".into(),
                status: if angle > MISALIGNED_DEG { Status::Missing } else { Status::NotNeeded },
                residual: Residual::Dip.name(),
                holdout_rms_ut: None,
                p_value: None,
                confounded_with: Vec::new(),
                why: format!(
                    "the axes of magnetometer and accelerometer differ by {angle:.1}° beside the triangular matrix; the \
                     full matrix contains it"
                ),
                angle_deg: Some(angle),
            });
            list.push(CandidateRow {
                id: "axis-order".into(),
                name: "axis order".into(),
                status: if swapped.is_some() { Status::Missing } else { Status::NotNeeded },
                residual: Residual::Dip.name(),
                holdout_rms_ut: None,
                p_value: None,
                confounded_with: Vec::new(),
                why: match swapped {
                    Some(order) => format!(
                        "the log's axes stand for the board's {order}: correct the driver, or use --rotate"
                    ),
                    None => "the axes stand in the board's order".into(),
                },
                angle_deg: None,
            });
        }
        let more = untestable(self.catalogue);
        let known: Vec<String> = list.iter().map(|row| row.id.clone()).collect();
        list.extend(more.into_iter().filter(|row| !known.contains(&row.id)));
        list
    }

    fn effects(&self, left: &Residue, dip: &Option<DipStudy>) -> Result<Vec<FittedEffect>, BadShape> {
        let fitted = &self.explanation.fitted;
        let covariance = match super::frequency::with_slope(&self.pass, fitted)? {
            Some(total) => covariance_of(&total, fitted, left.time),
            None => covariance(fitted, left.time),
        };
        let mut column = Residual::Magnitude.base_columns();
        let mut list = Vec::new();
        for piece in &fitted.pieces {
            let mut errors: Vec<f64> = (column..column + piece.k())
                .map(|index| covariance.as_ref().map_or(f64::NAN, |rows| rows[index][index].max(0.0).sqrt()))
                .collect();
            if piece.k() == 9
                && let Some((_, error)) = dip.as_ref().and_then(|dip| dip.lag.as_ref())
            {
                for index in [0, 4, 8] {
                    errors[index] = errors[index].hypot(*error);
                }
            } else if piece.k() == 9 && piece.id == "lag" {
                // Without the dip the share along the identity is not known at all.
                for index in [0, 4, 8] {
                    errors[index] = f64::NAN;
                }
            }
            column += piece.k();
            list.push(describe(piece, errors));
        }
        let has_eddy = fitted.pieces.iter().any(|piece| piece.id == "lag");
        if !has_eddy && let Some((piece, error)) = dip.as_ref().and_then(|dip| dip.lag.as_ref()) {
            list.push(describe(piece, vec![*error]));
        }
        Ok(list)
    }

    fn heading(&self, dip: &Option<DipStudy>) -> Result<Option<Heading>, BadShape> {
        let Some(reference) = self.table.heading_deg else { return Ok(None) };
        let base = &self.explanation.base;
        let triangular =
            Model::new(base.model.offset_ut, base.model.matrix, base.model.field_ut, base::NO_ROTATION, 0.0);
        let fitted = &self.explanation.fitted;
        let mut pieces = fitted.pieces.clone();
        if !pieces.iter().any(|piece| piece.id == "lag") {
            pieces.extend(dip.as_ref().and_then(|dip| dip.lag.clone()).map(|(piece, _)| piece));
        }
        let before = triangular.and_then(|model| heading_error(self.samples, &model, &[], reference));
        let after = heading_error(self.samples, &fitted.model, &pieces, reference);
        Ok(before.zip(after).map(|(rms_deg_before, rms_deg_after)| Heading { rms_deg_before, rms_deg_after }))
    }

    fn shows(&self) -> Result<Vec<Where>, BadShape> {
        let base = &self.explanation.base;
        let residuals = self.pass.residuals(&base.model, &[])?;
        Ok(super::shows::shows(
            self.samples,
            &residuals,
            &self.explanation.first,
            base,
            self.explanation.count,
        ))
    }
}

/// Which recording would tell the candidates apart.
fn separating(id: &str, partners: &[String]) -> String {
    let all = || std::iter::once(id).chain(partners.iter().map(String::as_str));
    let timed = all().any(|id| ["drift", "step"].contains(&id));
    let columns: Vec<&str> = all().filter_map(|id| id.split_once(':').map(|(_, column)| column)).collect();
    match (timed, columns.first()) {
        (true, Some(column)) => format!(
            "record a log in which {column} goes up and down again while time goes on (let it cool down, switch it on and off)"
        ),
        (false, Some(first)) => {
            let other = columns.iter().find(|column| *column != first).unwrap_or(first);
            if other == first {
                format!("record a log in which {first} changes at many attitudes")
            } else {
                format!("record a log in which {first} and {other} change one at a time")
            }
        }
        (true, None) => "record a longer log: a drift goes on, a step does not".into(),
        _ => "record a log with more attitudes, and with the board still in some of them".into(),
    }
}

/// An effect with its fitted coefficients, in the words and numbers of the contract.
pub(super) fn describe(piece: &Piece, std_errors: Vec<f64>) -> FittedEffect {
    let k = piece.k();
    let mut reference = Vec::new();
    let mut parameters = Vec::new();
    let columns: Vec<String> =
        piece.effect.columns().iter().flatten().map(|column| column.name.to_string()).collect();
    for (name, value) in &piece.fixed {
        match *name {
            "reference" => {
                // The column's value, not its square's.
                let value = if piece.id.ends_with("^2") { value.max(0.0).sqrt() } else { *value };
                reference.extend(columns.first().map(|column| (column.clone(), value)));
            }
            other => parameters.push((other, *value)),
        }
    }
    FittedEffect {
        id: piece.id.clone(),
        name: piece.effect.name().to_string(),
        explanation: piece.effect.explanation().to_string(),
        columns,
        coefficients: piece.coefficients[..k].to_vec(),
        std_errors,
        unit: piece.effect.unit().to_string(),
        reference,
        parameters,
    }
}

/// Rms of the heading's error against the reference, degrees.
fn heading_error(samples: &Samples, model: &Model<f64>, pieces: &[Piece], reference: &[f64]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for (index, reading) in samples.readings.iter().enumerate() {
        let (Some(down), Some(truth)) = (reading.down, reference.get(samples.row[index])) else { continue };
        if !truth.is_finite() {
            continue;
        }
        let terms: Vec<_> = pieces.iter().map(|piece| piece.term(index)).collect();
        let Ok(h) = model.correct(reading, &terms) else { continue };
        let (h, down) = (Vector3::from(h), Vector3::from(down));
        let north = h - down * h.dot(&down);
        let east = down.cross(&north);
        // Near the vertical the nose has no heading.
        let level = (1.0 - down.x * down.x).sqrt();
        if level < 0.3 || north.norm() < 1e-6 {
            continue;
        }
        let heading = east.x.atan2(north.x).to_degrees();
        let error = (heading - truth + 540.0).rem_euclid(360.0) - 180.0;
        sum += error * error;
        count += 1.0;
    }
    (count >= 20.0).then(|| (sum / count).sqrt())
}

/// A board at rest: the vector itself is the residual.
fn at_rest(
    table: &Table,
    samples: &Samples,
    data_faults: Vec<DataFault>,
    options: &Options,
) -> Result<Diagnosis, Refusal> {
    let catalogue = Catalogue::new(samples, table);
    let pass = Pass { samples, residual: Residual::Vector };
    let known = Known::default();
    let mean = base::mean_vector(samples);
    let model = Model::new(mean, base::NO_ROTATION, 1.0, base::NO_ROTATION, 0.0);
    let nothing = || {
        undetermined(table, samples, data_faults.clone(), "the board rests and nothing else changes".into())
    };
    if catalogue.usable_columns().next().is_none() {
        return Ok(nothing());
    }
    let Some(base) = model.map(|model| pass.fit(model, Vec::new(), &known)).transpose()?.flatten() else {
        return Ok(nothing());
    };
    let greedy = Greedy { pass, catalogue: &catalogue, known: &known };
    let mut start = base.clone();
    for id in &options.add {
        if start.pieces.len() >= MOST_ADDED {
            return Err(Refusal::CannotAdd(
                id.clone(),
                format!("a model carries at most {MOST_ADDED} effects"),
            ));
        }
        let Some(piece) = added(&pass, &catalogue, &start, id)? else {
            return Err(Refusal::CannotAdd(id.clone(), cannot_add(&catalogue, id)));
        };
        let mut pieces = start.pieces.clone();
        pieces.push(piece);
        if let Some(next) = pass.fit(start.model, pieces, &known)? {
            start = next;
        }
    }
    let explanation = if options.search { greedy.run(start)? } else { greedy.only(base, start)? };
    let (used, confounded) = (explanation.fitted.pieces.len(), explanation.confounded.clone());
    let fitted = &explanation.fitted;
    let residuals = pass.residuals(&fitted.model, &fitted.pieces.iter().collect::<Vec<_>>())?;
    let left = residue(&residuals, fitted.columns(), samples.quantum_ut);
    let covariance = covariance(fitted, left.time);
    let mut column = 3;
    let effects = fitted
        .pieces
        .iter()
        .map(|piece| {
            let errors = (column..column + piece.k())
                .map(|index| covariance.as_ref().map_or(f64::NAN, |rows| rows[index][index].max(0.0).sqrt()))
                .collect();
            column += piece.k();
            describe(piece, errors)
        })
        .collect();
    let mut reasons = vec![
        "the board rests: the vector itself is the residual, there is no calibration in this log".into(),
    ];
    let verdict = if left.structure > 0.0 {
        reasons.push(format!(
            "{:.0} % of the variance is structure that no candidate explains",
            100.0 * left.structure
        ));
        Verdict::Unexplained
    } else if !confounded.is_empty() {
        Verdict::Confounded
    } else if used > 0 {
        Verdict::Missing
    } else {
        Verdict::Complete
    };
    let base_residuals = pass.residuals(&explanation.base.model, &[])?;
    let shows = super::shows::shows(
        samples,
        &base_residuals,
        &explanation.first,
        &explanation.base,
        explanation.count,
    );
    let traces = Traces::of(&pass, &explanation.base, &explanation.fitted)?;
    let view =
        View { table, samples, catalogue: &catalogue, pass, known: &known, explanation, lower_order: false };
    let in_group = |id: &String| confounded.iter().any(|group| group.ids.contains(id));
    let mut steps = view.steps(&None)?;
    steps.retain(|step| step.added.as_ref().is_none_or(|id| !in_group(id)));
    let mut candidates = view.candidates(&None, false, None, verdict);
    for row in &mut candidates {
        if row.residual == "magnitude" {
            row.residual = Residual::Vector.name();
        }
        if row.status == Status::Untestable && row.id == "lag" {
            row.why = "the board rests".into();
        }
    }
    Ok(Diagnosis {
        verdict,
        reasons,
        residual: Residual::Vector.name(),
        steps,
        noise_floor_ut: Some(left.floor),
        residual_floor_ut: Some(left.floor),
        candidates,
        effects,
        shows,
        prior: "none".into(),
        traces,
        ..undetermined(table, samples, data_faults, String::new())
    })
}
