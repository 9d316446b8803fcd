//! Why there is no calibration for level headings, in words.

use core::fmt;

use crate::fit::FitError;
use crate::number::Num;

pub(super) const DEG: f64 = 180.0 / core::f64::consts::PI;
/// Largest 1σ of a level heading, degrees: as for the host's fit of a vehicle.
pub const MAX_HEADING_ERROR_DEG: f64 = 1.5;
/// Largest residual, over the horizontal field.
pub(super) const MAX_RESIDUAL: f64 = 0.15;
/// Tilts of the log, rms, degrees: a board that was tilted more was turned by hand.
pub(super) const MAX_TILT_DEG: f64 = 20.0;

/// Why there is no calibration for level headings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotLevel {
    /// The sums have no solution.
    Fit(FitError),
    /// The heading error is too large, degrees, and what makes most of it.
    Uncertain(f64, Cause),
    /// The magnitude varies: rms, percent of the horizontal field.
    FieldVaries(f64),
    /// The board was tilted by this much, rms, degrees.
    Tilted(f64),
    /// Gravity leans by this much against the plane of the readings, degrees.
    Leaning(f64),
}

/// What makes most of a heading error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Too little of a circle.
    Circle,
    /// The magnitude varies slowly, not as noise does.
    Field,
    /// The direction down: the accelerometer was pushed sideways.
    Down,
    /// The vertical offset, at a tilt of one degree.
    Vertical,
}

impl NotLevel {
    /// There are no samples.
    pub const NOTHING: Self = Self::Fit(FitError::TooFewSamples { samples: 0 });

    /// A short word for programs.
    pub const fn code(&self) -> &'static str {
        match self {
            NotLevel::Fit(error) => error.code(),
            NotLevel::Uncertain(..) => "error-too-large",
            NotLevel::FieldVaries(_) => "residual-too-large",
            NotLevel::Tilted(_) => "not-level",
            NotLevel::Leaning(_) => "leaning",
        }
    }
}

impl fmt::Display for NotLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotLevel::Fit(error) => error.fmt(f),
            NotLevel::Uncertain(degrees, cause) => {
                let (when, fix) = match cause {
                    Cause::Circle => ("", "go on turning: two full circles to the left and two to the right"),
                    Cause::Field => (
                        "",
                        "the magnitude varies along the way: drive away from steel, cables and other vehicles, or go on turning",
                    ),
                    Cause::Down => ("", "drive as many circles to the left as to the right, slower"),
                    Cause::Vertical => (
                        " tilted by 1 deg",
                        "level turns do not show the vertical offset: calibrate the sensor in all directions once (cal start), or \
                         turn on slopes or waves",
                    ),
                };
                write!(
                    f,
                    "the predicted heading error{when} is {:.1} deg (limit {:.1} deg). Fix: {fix}",
                    Num(*degrees),
                    Num(MAX_HEADING_ERROR_DEG)
                )
            }
            NotLevel::FieldVaries(percent) => write!(
                f,
                "the magnitude varies by {:.0} % of the horizontal field (limit {:.0} %). Fix: drive the circles away from steel, \
                 cables and other vehicles",
                Num(*percent),
                Num(100.0 * MAX_RESIDUAL)
            ),
            NotLevel::Tilted(degrees) => write!(
                f,
                "the sensor was tilted by {:.0} deg rms (limit {:.0} deg). Fix: turn it level, or in all directions with cal start",
                Num(*degrees),
                Num(MAX_TILT_DEG)
            ),
            NotLevel::Leaning(degrees) => write!(
                f,
                "the plane of the readings leans by {:.0} deg against the vertical. Fix: drive slower, left and right, or mount the \
                 sensor level",
                Num(*degrees)
            ),
        }
    }
}
