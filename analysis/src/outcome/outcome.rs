//! What a diagnosis says.

use crate::base::axes::Alignment;
use crate::base::model::Base;
use crate::base::mounting::{self, OrderStatus};
use crate::base::order::AxisOrder;
use crate::base::quality::NoiseEstimate;
use crate::calibration::{FittedEffect, Information, StdErrors};
use crate::evidence::wander::Wander;
use crate::noise::own::Colour;
use crate::outcome::contradiction::Contradiction;
use crate::plain;
use crate::reason::Reason;
use crate::residual::traces::Traces;
use crate::samples::faults::DataFault;
use crate::search::shown::Shown;
use crate::unlogged::levels::Levels;
use crate::unlogged::pair::Pair;
use crate::unlogged::recordings::Recordings;
use crate::unlogged::switching::Switching;
use ironout::calibration::Calibration;
use ironout::effect::Registry;
use ironout::extended::MAX_EFFECTS;
use ironout::study::Residual;
use serde::Serialize;

/// The verdict of the contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing is missing.
    Complete,
    /// Effects were missing; with them, nothing is.
    Missing,
    /// Something is missing that several candidates explain alike.
    Confounded,
    /// Structure remains that no candidate explains.
    Unexplained,
    /// The data do not support a calibration, so nothing can be said.
    Undetermined,
}

impl Verdict {
    /// The word of the contract.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Complete => "complete",
            Verdict::Missing => "missing",
            Verdict::Confounded => "confounded",
            Verdict::Unexplained => "unexplained",
            Verdict::Undetermined => "undetermined",
        }
    }
}

/// One row of the falling error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepRow {
    /// The effect added; `None` for the base model.
    pub added: Option<String>,
    /// Rms of the residual, µT.
    pub rms_ut: f64,
    /// The same on held-out blocks of time.
    pub holdout_rms_ut: Option<f64>,
    /// Spread of the dip, degrees.
    pub dip_rms_deg: Option<f64>,
}

/// What became of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// It was missing, and is in the steps.
    Missing,
    /// Not significant in this log.
    NotNeeded,
    /// Others explain the same.
    Confounded,
    /// The log cannot tell.
    Untestable,
}

impl Status {
    /// The word of the contract.
    pub const fn name(self) -> &'static str {
        match self {
            Status::Missing => "missing",
            Status::NotNeeded => "not-needed",
            Status::Confounded => "confounded",
            Status::Untestable => "untestable",
        }
    }
}

/// One candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CandidateRow {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: String,
    /// What became of it.
    pub status: Status,
    /// The residual that it was tested in.
    pub residual: &'static str,
    /// Held-out rms with it, µT (degrees where the residual is the dip).
    pub holdout_rms_ut: Option<f64>,
    /// p-value, corrected for all searches.
    pub p_value: Option<f64>,
    /// Those that explain the same.
    pub confounded_with: Vec<String>,
    /// Why.
    pub why: String,
    /// Angle of a misalignment, degrees.
    pub angle_deg: Option<f64>,
    /// Share of the squared error that it would take off the model in which it was tested: of one in the model, off the base.
    pub takes: Option<f64>,
}

impl CandidateRow {
    /// A row without figures.
    pub(crate) fn new(id: &str, name: &str, status: Status, residual: Residual, why: String) -> Self {
        CandidateRow {
            id: id.into(),
            name: name.into(),
            status,
            residual: residual.name(),
            holdout_rms_ut: None,
            p_value: None,
            confounded_with: Vec::new(),
            why,
            angle_deg: None,
            takes: None,
        }
    }
}

/// How much of the base model's residual something explains.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Where {
    /// A column, `time`, `attitude` or `spectrum`.
    pub against: String,
    /// Share of the residual's variance.
    pub explained: f64,
    /// p-value.
    pub p_value: f64,
    /// Mean residual in bins of what it is against, µT: the shape for a plot.
    pub shape: Vec<f64>,
}

/// Spread of the dip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Dip {
    /// With the triangular matrix of the base model, degrees.
    pub rms_deg_before: f64,
    /// Aligned, with all effects, degrees.
    pub rms_deg_after: f64,
    /// Rotation between the triangular matrix' frame and the accelerometer, degrees.
    pub misalignment_deg: f64,
}

/// Error of the heading against the reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Heading {
    /// With the triangular matrix of the base model, degrees rms.
    pub rms_deg_before: f64,
    /// Aligned, with all effects, degrees rms.
    pub rms_deg_after: f64,
}

/// The noise that is left.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseRow {
    /// What it is most like.
    pub colour: Colour,
    /// The root of twice the log of the odds that it is something else: standard deviations, if it were one number.
    pub misfit: f64,
    /// Whether it is that noise and nothing more.
    pub is_noise: bool,
    /// How many samples say as much about a calibration as one of white noise.
    pub memory_samples: f64,
}

impl NoiseRow {
    /// Of a residual.
    pub fn of(left: &NoiseEstimate) -> NoiseRow {
        let NoiseEstimate { colour, misfit, is_noise, memory, .. } = *left;
        NoiseRow { colour, misfit, is_noise, memory_samples: memory }
    }
}

/// A diagnosis.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Why, in words.
    pub reasons: Vec<Reason>,
    /// `magnitude`, or `vector` for a board at rest.
    pub residual: &'static str,
    /// The error falling.
    pub steps: Vec<StepRow>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_floor_ut: Option<f64>,
    /// What it makes of the residual, µT.
    pub residual_floor_ut: Option<f64>,
    /// The least that noise may make of it, µT.
    pub residual_floor_least_ut: Option<f64>,
    /// What noise is left, where a model was fitted.
    pub noise: Option<NoiseRow>,
    /// Every candidate.
    pub candidates: Vec<CandidateRow>,
    /// Faults of the data.
    pub data_faults: Vec<DataFault>,
    /// The dip.
    pub dip: Option<Dip>,
    /// The heading.
    pub heading: Option<Heading>,
    /// Where the base model fails.
    pub shows: Vec<Where>,
    /// The effects of the final model.
    pub effects: Vec<FittedEffect>,
    /// The final calibration (full matrix where aligned).
    #[serde(serialize_with = "plain::calibration_if_any")]
    pub calibration: Option<Calibration<f64>>,
    /// Standard errors of offset and matrix.
    pub std_errors: Option<StdErrors>,
    /// Whether the matrix stands in the accelerometer's axes.
    pub alignment: Alignment,
    /// How the magnetometer's axes stand to the accelerometer's, where the log shows it.
    pub order_status: Option<OrderStatus>,
    /// Information about offset and triangle, effects projected out.
    pub information: Option<Information>,
    /// Whether the fit of the final model converged.
    pub converged: bool,
    /// The base model as `fit` gives it; `None` where the samples alone carry none.
    pub base: Option<Base>,
    /// Predicted error of a corrected vector in the worst direction, µT, in the sensor's own axes.
    pub predicted_error_ut: Option<f64>,
    /// 1σ that the rotation to the accelerometer turns a corrected vector by, rad; zero where there is none.
    pub rotation_error_rad: f64,
    /// The share of what is left that is the field itself, another one from place to place; `None` where something else may be
    /// the cause.
    #[serde(skip)]
    pub field_varies: Option<f64>,
    /// Why `fit` refuses the calibration with what was found; `None` where it accepts.
    #[serde(skip)]
    pub fit_refuses: Option<String>,
    /// Whether what was found explains all but the noise, and only the calibration with it is not sure enough: what a longer log would mend.
    #[serde(skip)]
    pub only_unsure: bool,
    /// Whether the attitude, and not only the noise, lets the base model be determined.
    #[serde(skip)]
    pub has_attitude: bool,
    /// p-value of each effect of the model beside all others, by id, its search counted but not how
    /// many candidates were tried.
    #[serde(skip)]
    pub chances: Vec<(String, f64)>,
    /// Samples used.
    pub samples_used: usize,
    /// Samples set aside.
    pub samples_set_aside: usize,
    /// The prior that was used, in words.
    pub prior: String,
    /// What the log says against the earlier calibration that it was studied on top of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Contradiction>,
    /// The offsets of several recordings, where they differ: all else is of the readings with that of the last of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Recordings>,
    /// An offset that switches between two values with no column that says when, where what is left shows one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub switching: Option<Switching>,
    /// An offset with more jumps than steps were named, with no column behind it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<Levels>,
    /// What the log's other magnetometer shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair: Option<Pair>,
    /// How the offset wanders where the verdict is unexplained.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wander: Option<Wander>,
    /// Whether a lower-order base (no soft iron) was used.
    pub lower_order: bool,
    /// Whether the log shows the effects that were asked for. A search tests in another way, and leaves this to the steps.
    pub shown: Vec<Shown>,
    /// The residuals, for plots.
    pub traces: Traces,
    /// The families of effects that the ids are of.
    #[serde(skip)]
    pub registry: Registry,
}

impl Diagnosis {
    /// Predicted error of a corrected vector in the worst direction, µT, in the axes that it is given in.
    pub fn vector_error_ut(&self) -> Option<f64> {
        let rotated =
            self.rotation_error_rad * self.calibration.map_or(0.0, |calibration| calibration.field_ut);
        self.predicted_error_ut.map(|error| error.hypot(rotated))
    }

    /// How the axes stand in the log, where they do not stand for themselves. Where nothing tells a mounting from its mirror
    /// image, the mounting.
    pub fn axis_order(&self) -> Option<AxisOrder> {
        self.order_status.and_then(|order_status| order_status.swapped())
    }

    /// Effects for a fit (those of `asked` that are significant, then those of the steps), and the rest, for which a calibration has
    /// no place. Neither list contains a rotation or an order of the axes, which belong to every fit.
    pub fn to_add(&self, asked: &[String]) -> (Vec<String>, Vec<String>) {
        let mut ids: Vec<String> = Vec::new();
        let found = self.steps.iter().filter_map(|step| step.added.as_ref());
        for id in asked.iter().filter(|id| !self.is_not_needed(id)).chain(found) {
            if !ids.contains(id) && !mounting::is_one(id) {
                ids.push(id.clone());
            }
        }
        let left_out = ids.split_off(ids.len().min(MAX_EFFECTS));
        (ids, left_out)
    }

    /// Whether an effect was tested and is not needed.
    pub fn is_not_needed(&self, id: &str) -> bool {
        self.candidates.iter().any(|row| row.id == id && row.status == Status::NotNeeded)
    }
}
