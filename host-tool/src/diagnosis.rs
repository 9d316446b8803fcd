//! What a diagnosis says: plain data between the engine that finds it and the words and the JSON that show it.

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The base model explains the log: nothing is missing.
    Complete,
    /// An effect (or several) was missing; with it the log is explained.
    Missing,
    /// Effects explain the error that this log cannot tell apart.
    Confounded,
    /// An error remains that no effect explains.
    Unexplained,
    /// The log does not determine the model: nothing can be said.
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

/// What was found about one effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// It was missing and is in `steps`.
    Missing,
    /// It was tested and is not there, or too small to matter.
    NotNeeded,
    /// It explains the same as another.
    Confounded,
    /// The log does not allow to test it.
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

/// The residual in which an effect shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// `‖h‖ − F`, µT.
    Magnitude,
    /// The angle between the field and gravity.
    Dip,
    /// The measured vector of a board at rest, µT.
    Vector,
}

impl Seen {
    /// The word of the contract.
    pub const fn name(self) -> &'static str {
        match self {
            Seen::Magnitude => "magnitude",
            Seen::Dip => "dip",
            Seen::Vector => "vector",
        }
    }
}

/// What a sensor, a cable or a logger did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// An axis at the end of its range.
    Clipping,
    /// A magnet or iron passed, or single readings are far off.
    Burst,
    /// One reading repeated while the board turned.
    Stuck,
    /// Rows are missing.
    Gap,
    /// An axis is a copy of another.
    CopiedAxis,
}

impl FaultKind {
    /// The word of the contract.
    pub const fn name(self) -> &'static str {
        match self {
            FaultKind::Clipping => "clipping",
            FaultKind::Burst => "burst",
            FaultKind::Stuck => "stuck",
            FaultKind::Gap => "gap",
            FaultKind::CopiedAxis => "copied-axis",
        }
    }
}

/// One fault of the data.
#[derive(Debug, Clone, PartialEq)]
pub struct DataFault {
    /// What.
    pub kind: FaultKind,
    /// From when, s; `None` without a time column.
    pub from_s: Option<f64>,
    /// Until when, s.
    pub to_s: Option<f64>,
    /// Samples concerned (for a gap: missing, by the log's own rate).
    pub samples: usize,
    /// Columns concerned.
    pub columns: Vec<String>,
}

/// The state of the model after one addition: the error falling.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Id of the effect added; `None` for the base model.
    pub added: Option<String>,
    /// Rms residual, µT.
    pub rms_ut: Option<f64>,
    /// Rms residual on held-out blocks of time, µT.
    pub holdout_rms_ut: Option<f64>,
    /// Rms residual of the dip, degrees; `None` without an accelerometer.
    pub dip_rms_deg: Option<f64>,
}

/// An effect of the final model with its coefficients: one for each entry of `steps` that added something.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundEffect {
    /// Id, as `fit --add` takes it.
    pub id: String,
    /// Name in words.
    pub name: String,
    /// The physical cause, from [`ironout::effect::Effect::explanation`].
    pub explanation: String,
    /// Columns it reads.
    pub columns: Vec<String>,
    /// Coefficients, in `unit`.
    pub coefficients: Vec<f64>,
    /// Their standard errors; empty where unknown.
    pub std_errors: Vec<f64>,
    /// Unit of the coefficients.
    pub unit: String,
    /// Values of the columns at which the effect is zero.
    pub reference: Vec<(String, f64)>,
    /// Searched parameters: `at_s`, `frequency_hz`, `delay_s`.
    pub parameters: Vec<(String, f64)>,
}

/// One effect that was considered.
#[derive(Debug, Clone, PartialEq)]
pub struct Considered {
    /// Id.
    pub id: String,
    /// Name in words.
    pub name: String,
    /// What was found.
    pub status: Status,
    /// Where it would show.
    pub seen: Seen,
    /// Held-out error of the model with it, µT.
    pub holdout_rms_ut: Option<f64>,
    /// Probability that chance explains as much, all searching included.
    pub p_value: Option<f64>,
    /// Ids it cannot be told from.
    pub confounded_with: Vec<String>,
    /// The reason for the status, in words: for an untestable one what is wrong with which column.
    pub why: String,
    /// The column that would allow the test (untestable only).
    pub needs: Option<String>,
    /// Angle of a misalignment, degrees.
    pub angle_deg: Option<f64>,
}

/// Spread of the dip, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dip {
    /// With the triangular matrix.
    pub rms_deg_before: Option<f64>,
    /// After alignment, with all effects.
    pub rms_deg_after: Option<f64>,
    /// The rotation between the two sensors.
    pub misalignment_deg: Option<f64>,
}

/// Error of the heading against `heading_deg`, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    /// Of the base model.
    pub rms_deg_before: Option<f64>,
    /// Of the final model.
    pub rms_deg_after: Option<f64>,
}

/// How much of the base model's residual one quantity explains.
#[derive(Debug, Clone, PartialEq)]
pub struct Where {
    /// `time`, `attitude`, `spectrum`, or the name of a column.
    pub against: String,
    /// Share of the squared residual that a smooth curve in it takes away, 0 to 1.
    pub explained: Option<f64>,
    /// Probability that chance does as well.
    pub p_value: Option<f64>,
}

/// The residuals, sample by sample, for plots.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Row of the log of each sample.
    pub rows: Vec<usize>,
    /// Residual of the base model, µT: one series for the magnitude, one for each axis in use of a board at rest.
    pub base_ut: Vec<Vec<f64>>,
    /// Residual of the final model, likewise.
    pub final_ut: Vec<Vec<f64>>,
    /// Unit vectors of the corrected field in the body frame (base model); empty at rest.
    pub directions: Vec<[f64; 3]>,
}

/// Everything a diagnosis found.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// The answer.
    pub verdict: Verdict,
    /// Why, where the word alone does not say it: for `undetermined` what is wrong and what to do.
    pub reasons: Vec<String>,
    /// The residual that was studied: the magnitude, or the vector of a board at rest.
    pub seen: Seen,
    /// What the base model is and which prior stands behind it, in one sentence.
    pub base_model: String,
    /// Magnitude the corrected vectors are scaled to, µT; `None` at rest without one.
    pub field_ut: Option<f64>,
    /// Samples studied.
    pub samples_used: usize,
    /// Samples set aside as faulty.
    pub samples_set_aside: usize,
    /// The error falling, the base model first. Empty where there is no base model.
    pub steps: Vec<Step>,
    /// The effects of the final model, in the order added.
    pub effects: Vec<FoundEffect>,
    /// σ per sensor axis, µT.
    pub noise_floor_ut: Option<f64>,
    /// What that noise makes of the residual, rms, µT.
    pub residual_floor_ut: Option<f64>,
    /// Every effect considered.
    pub candidates: Vec<Considered>,
    /// Faults of the data.
    pub data_faults: Vec<DataFault>,
    /// Where there is an accelerometer.
    pub dip: Option<Dip>,
    /// Where there is `heading_deg`.
    pub heading: Option<Heading>,
    /// Where the base model fails.
    pub failures: Vec<Where>,
    /// The residuals.
    pub series: Series,
}
