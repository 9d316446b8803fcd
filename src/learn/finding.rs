//! What a question finds, as plain figures.

use super::candidate::{CANDIDATES, Candidate, Found};

/// What became of a candidate: the words of `diagnose`, and that it is in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It is missing.
    Missing,
    /// The data give no evidence for it.
    NotNeeded,
    /// Others explain the same.
    Confounded,
    /// The study cannot tell.
    Untestable,
    /// It is in the calibration in use.
    InUse,
}

impl Status {
    /// The word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::NotNeeded => "not-needed",
            Self::Confounded => "confounded",
            Self::Untestable => "untestable",
            Self::InUse => "in-use",
        }
    }
}

/// What is found of a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// What became of it.
    pub status: Status,
    /// Rms on held-out blocks of time without it, µT; of the dip in degrees; NaN where not known.
    pub before: f32,
    /// The same with it.
    pub after: f32,
    /// p-value, corrected for its own search and the number of candidates.
    pub p_value: f32,
    /// Those that explain the same.
    pub partners: Found,
    /// When it was added, from 1; 0 for one that was not.
    pub order: u8,
}

pub(super) const NOTHING: Finding = Finding {
    status: Status::Untestable,
    before: f32::NAN,
    after: f32::NAN,
    p_value: f32::NAN,
    partners: Found::none(),
    order: 0,
};

/// The verdict, as of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is missing.
    Complete,
    /// Effects are missing; with them, nothing is.
    Missing,
    /// Something is missing that several explain alike.
    Confounded,
    /// An error remains that nothing explains.
    Unexplained,
    /// There is not enough to say anything.
    Undetermined,
}

impl Verdict {
    /// The word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Missing => "missing",
            Self::Confounded => "confounded",
            Self::Unexplained => "unexplained",
            Self::Undetermined => "undetermined",
        }
    }
}

/// The coefficients of the effects in use, by their candidates' places, in their unit.
pub type InUse = [Option<[f64; 3]>; CANDIDATES];

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The verdict.
    pub verdict: Verdict,
    /// Samples.
    pub rows: u32,
    /// Rms of the model in use, µT, ...
    pub rms_ut: f32,
    /// ... the same on held-out blocks, ...
    pub holdout_rms_ut: f32,
    /// ... and what of it is noise.
    pub floor_ut: f32,
    /// Predicted error of the base, relative to the field: the largest standard error of its parameters, from the noise that is left with
    /// every effect in.
    pub base_error: f32,
    /// Rms of the dip, degrees; NaN without an accelerometer.
    pub dip_rms_deg: f32,
    /// Whether the sensor is late was told by how a gyro turns, not by the dip.
    pub late_by_turning: bool,
    /// By place.
    pub findings: [Finding; CANDIDATES],
}

impl Outcome {
    /// What is found of a candidate.
    pub fn of(&self, candidate: Candidate) -> Finding {
        self.findings.get(candidate.place()).copied().unwrap_or(NOTHING)
    }

    /// The candidates by rank: those in use, those missing in the order they were added, those that explain the same, the others by
    /// what they leave, and last those that cannot be tested.
    pub fn ranked(&self) -> impl Iterator<Item = (Candidate, Finding)> {
        let mut left = Candidate::all().fold(Found::none(), Found::with);
        core::iter::from_fn(move || {
            let first =
                left.iter().reduce(|best, other| if self.before(other, best) { other } else { best })?;
            left = left.without(first);
            Some((first, self.of(first)))
        })
    }

    /// Whether a candidate ranks before another.
    #[inline(never)]
    fn before(&self, a: Candidate, b: Candidate) -> bool {
        let ((g, x, p), (h, y, q)) = (self.rank(a), self.rank(b));
        g < h || (g == h && (x < y || (x == y && p < q)))
    }

    #[inline(never)]
    fn rank(&self, candidate: Candidate) -> (u16, f32, usize) {
        let one = self.of(candidate);
        let group = match one.status {
            Status::InUse => 0,
            Status::Missing | Status::Confounded if one.order > 0 => 1 + u16::from(one.order),
            Status::Missing | Status::Confounded => 100,
            Status::NotNeeded if candidate != Candidate::Lag => 101,
            Status::NotNeeded => 102,
            Status::Untestable => 103,
        };
        (group, if one.after.is_nan() { f32::INFINITY } else { one.after }, candidate.place())
    }
}
