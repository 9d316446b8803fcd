//! The verdict on a calibration, with reasons a user can act on.

use crate::calibration::Calibration;
use crate::coverage::Coverage;
use crate::fit::{FitError, FitReport, MAX_PREDICTED_ERROR, MIN_SAMPLES};
use crate::number::Num;
use core::fmt;
use heapless::Vec;

/// Largest residual rms of an accepted calibration, over the field.
pub const MAX_RESIDUAL: f64 = 0.05;
/// Largest fraction of samples at the sensor's limits.
pub const MAX_SATURATED: f64 = 0.01;
/// A measured magnitude that differs from the expected field by more than this is noted.
const FIELD_TOLERANCE: f64 = 0.2;

/// One reason of a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// The fit itself gave no answer.
    Fit(FitError),
    /// The predicted 1σ error of the corrected vector is too large.
    ErrorTooLarge {
        /// In percent of the field.
        percent: f64,
        /// The side of the board to turn to the field, where the coverage is known.
        missing_side: Option<&'static str>,
    },
    /// The residual is too large: something disturbs.
    ResidualTooLarge {
        /// Rms in percent of the field.
        percent: f64,
    },
    /// Too many samples were at the sensor's limits.
    Saturated {
        /// In percent of the samples.
        percent: f64,
    },
    /// The measured magnitude is far from the expected field. A note, not a refusal: the matrix scales it.
    FieldMismatch {
        /// Magnitude measured, µT.
        measured_ut: f64,
        /// Magnitude expected, µT.
        expected_ut: f64,
    },
}

impl Reason {
    /// Whether this reason alone refuses the calibration.
    pub const fn refuses(&self) -> bool {
        !matches!(self, Self::FieldMismatch { .. })
    }

    /// A short word for programs.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Fit(error) => error.code(),
            Self::ErrorTooLarge { .. } => "error-too-large",
            Self::ResidualTooLarge { .. } => "residual-too-large",
            Self::Saturated { .. } => "saturated",
            Self::FieldMismatch { .. } => "field-mismatch",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fit(error) => error.fmt(f),
            Self::ErrorTooLarge { percent, missing_side } => {
                write!(
                    f,
                    "the predicted error of the corrected vector is {:.1} % of the field (limit {:.0} %). Fix: ",
                    Num(*percent),
                    Num(MAX_PREDICTED_ERROR * 100.0)
                )?;
                match missing_side {
                    Some(side) => {
                        write!(f, "keep rotating until the field points through the {side} side too")
                    }
                    None => write!(f, "rotate through more directions"),
                }
            }
            Self::ResidualTooLarge { percent } => write!(
                f,
                "the residual is {:.1} % of the field (limit {:.0} %). Fix: keep away from moving iron and currents, or \
                 look for a missing effect",
                Num(*percent),
                Num(MAX_RESIDUAL * 100.0)
            ),
            Self::Saturated { percent } => write!(
                f,
                "{:.1} % of the samples are at the limits of the sensor. Fix: choose a wider range, or remove the magnet",
                Num(*percent)
            ),
            Self::FieldMismatch { measured_ut, expected_ut } => write!(
                f,
                "note: the sensor measures {:.1} uT instead of {:.1} uT. The matrix corrects it",
                Num(*measured_ut),
                Num(*expected_ut)
            ),
        }
    }
}

/// Accepted or refused, and why.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdict {
    /// Whether the calibration may be used.
    pub accepted: bool,
    /// Reasons and notes, the refusing ones first.
    pub reasons: Vec<Reason, 6>,
}

impl Verdict {
    /// The verdict on a fit that gave no answer.
    pub fn of_error(error: FitError) -> Self {
        let mut reasons = Vec::new();
        // Capacity six, one element.
        let _ = reasons.push(Reason::Fit(error));
        Self { accepted: false, reasons }
    }
}

/// What a calibration is judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Figures {
    /// The calibration.
    pub calibration: Calibration<f64>,
    /// Samples behind it.
    pub samples: u64,
    /// Predicted 1σ error of the corrected vector in the worst direction, µT.
    pub predicted_error_ut: f64,
    /// Rms residual of the corrected magnitude, µT.
    pub rms_ut: f64,
    /// The magnitude the measurements have themselves, µT.
    pub measured_field_ut: f64,
}

impl From<&FitReport> for Figures {
    fn from(report: &FitReport) -> Self {
        Self {
            calibration: report.calibration,
            samples: report.samples,
            predicted_error_ut: report.predicted_error_ut,
            rms_ut: report.rms_ut,
            measured_field_ut: report.measured_field_ut,
        }
    }
}

/// Judges a fit: the predicted error, the residual, the sensor's limits (design: "Accepting"; the gates on the quadric itself
/// are in the fit).
pub fn judge(
    report: &FitReport,
    coverage: Option<&Coverage>,
    saturated: u64,
    expected_field_ut: Option<f64>,
) -> Verdict {
    judge_figures(&Figures::from(report), coverage, saturated, expected_field_ut)
}

/// Judges a calibration however it was made, as [`judge`] does.
pub fn judge_figures(
    report: &Figures,
    coverage: Option<&Coverage>,
    saturated: u64,
    expected_field_ut: Option<f64>,
) -> Verdict {
    let mut reasons: Vec<Reason, 6> = Vec::new();
    // There are five kinds of reasons and each is given at most once, so six places are enough.
    let mut give = |reason| {
        let _ = reasons.push(reason);
    };
    let field = report.calibration.field_ut;
    if report.samples < MIN_SAMPLES {
        give(Reason::Fit(FitError::TooFewSamples { samples: report.samples }));
    }
    // Negated comparisons refuse a NaN too.
    let error = report.predicted_error_ut / field;
    if !(error <= MAX_PREDICTED_ERROR) {
        let missing_side = coverage.map(Coverage::missing_side);
        give(Reason::ErrorTooLarge { percent: error * 100.0, missing_side });
    }
    let residual = report.rms_ut / field;
    if !(residual <= MAX_RESIDUAL) {
        give(Reason::ResidualTooLarge { percent: residual * 100.0 });
    }
    let share = saturated as f64 / (saturated + report.samples).max(1) as f64;
    if share > MAX_SATURATED {
        give(Reason::Saturated { percent: share * 100.0 });
    }
    if let Some(expected_ut) = expected_field_ut
        && !(crate::math::abs(report.measured_field_ut / expected_ut - 1.0) <= FIELD_TOLERANCE)
    {
        give(Reason::FieldMismatch { measured_ut: report.measured_field_ut, expected_ut });
    }
    let accepted = !reasons.iter().any(Reason::refuses) && report.calibration.is_sound();
    Verdict { accepted, reasons }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> Figures {
        Figures {
            calibration: Calibration::identity(50.0),
            samples: 1000,
            predicted_error_ut: 0.1,
            rms_ut: 0.5,
            measured_field_ut: 50.0,
        }
    }

    /// The words of the reasons, and whether the calibration is accepted.
    fn verdict(figures: &Figures, saturated: u64) -> (bool, Vec<&'static str, 6>) {
        let verdict = judge_figures(figures, None, saturated, Some(50.0));
        (verdict.accepted, verdict.reasons.iter().map(Reason::code).collect())
    }

    #[test]
    fn each_gate_lets_through_what_is_just_inside_and_names_what_is_just_outside() {
        let none: &[&str] = &[];
        assert_eq!(verdict(&good(), 0), (true, none.iter().copied().collect()));
        let cases: [(Figures, u64, Option<&str>); 9] = [
            // 5 % of the field, also with the calibration's own field.
            (Figures { rms_ut: 2.49, ..good() }, 0, None),
            (Figures { rms_ut: 2.51, ..good() }, 0, Some("residual-too-large")),
            (Figures { rms_ut: f64::NAN, ..good() }, 0, Some("residual-too-large")),
            // 1 % of the field.
            (Figures { predicted_error_ut: 0.499, ..good() }, 0, None),
            (Figures { predicted_error_ut: 0.501, ..good() }, 0, Some("error-too-large")),
            (Figures { predicted_error_ut: f64::NAN, ..good() }, 0, Some("error-too-large")),
            // 1 % of all samples: 10 of 1010 are less, 11 of 1011 more.
            (good(), 10, None),
            (good(), 11, Some("saturated")),
            (Figures { samples: MIN_SAMPLES - 1, ..good() }, 0, Some("too-few-samples")),
        ];
        for (figures, saturated, reason) in cases {
            let expected = (reason.is_none(), reason.into_iter().collect());
            assert_eq!(verdict(&figures, saturated), expected, "{figures:?} {saturated}");
        }
    }

    #[test]
    fn a_field_that_differs_by_a_fifth_is_noted_and_refuses_nothing() {
        for (measured_field_ut, noted) in [(41.0, false), (59.0, false), (39.0, true), (61.0, true)] {
            let (accepted, reasons) = verdict(&Figures { measured_field_ut, ..good() }, 0);
            assert!(
                accepted && reasons.contains(&"field-mismatch") == noted,
                "{measured_field_ut}: {reasons:?}"
            );
        }
    }
}
