//! What a session tells: where it stands, what to do next, and what came of it.

use crate::coverage::{Coverage, Seen};
use crate::fit::FitReport;
use crate::quality::Verdict;
use core::fmt;

/// Where a session stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// Nothing is collected.
    Idle,
    /// Samples are collected.
    Collecting,
    /// A calibration was found and may be accepted.
    Solved,
    /// The data do not support a calibration.
    Refused,
}

impl State {
    /// The state in one word: `idle`, `collecting`, `solved`, `refused`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Collecting => "collecting",
            Self::Solved => "solved",
            Self::Refused => "refused",
        }
    }
}

/// A request that does not fit the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StateError {
    /// The state it came in.
    pub state: State,
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.state {
            State::Idle => write!(f, "no samples are being collected: start a calibration first"),
            State::Collecting => write!(f, "still collecting: stop first"),
            State::Solved => write!(f, "a solution is ready: accept or cancel it first"),
            State::Refused => write!(f, "the last data were rejected: start again"),
        }
    }
}

impl core::error::Error for StateError {}

/// What to do next, in words.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Hint {
    /// Start a calibration.
    Start,
    /// Turn the board: nothing has moved yet.
    Move,
    /// Turn the board so that the field comes through a side it has not come through yet. Where the field is now says where
    /// to, so that nobody needs to know where north is, nor on which half of the Earth the board is.
    Turn {
        /// The side it has not come through, for example `front-left`.
        missing: &'static str,
        /// The side it comes through now.
        now: &'static str,
    },
    /// The data carry a calibration: stop.
    Stop,
    /// Accept the solution.
    Accept,
    /// Start again.
    Again,
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start => write!(f, "start a calibration"),
            Self::Move => write!(f, "rotate the sensor slowly in all directions"),
            Self::Turn { missing, now } => {
                write!(f, "keep rotating; bring the {missing} side to where the {now} side is now")
            }
            Self::Stop => write!(f, "enough directions are covered: stop and solve"),
            Self::Accept => write!(f, "accept the solution to store and apply it"),
            Self::Again => write!(f, "the data were rejected: start again"),
        }
    }
}

/// What a session has taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Samples in motion, in the sums.
    pub n: u64,
    /// Samples left out: at rest, repeated or saturated.
    pub skipped: u64,
    /// Of those, samples at the sensor's limits.
    pub saturated: u64,
}

/// A snapshot of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Where it stands.
    pub state: State,
    /// What was taken.
    pub counts: Counts,
    /// Fraction of directions seen, 0 … 1.
    pub coverage: f32,
    /// Largest gap in the directions, degrees.
    pub gap_deg: f32,
    /// The directions seen.
    pub seen: Seen,
    /// Residual rms of the fit so far, µT.
    pub rms_ut: Option<f64>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: Option<f64>,
    /// Predicted 1σ error of the corrected vector, over the field.
    pub predicted_error: Option<f64>,
    /// What to do next.
    pub hint: Hint,
}

/// The outcome of a stop.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outcome {
    /// Accepted or refused, with reasons.
    pub verdict: Verdict,
    /// The fit, where there was one; also of a refused calibration.
    pub report: Option<FitReport>,
    /// The directions seen.
    pub coverage: Coverage,
}

impl Status {
    /// The figures of a fit; nothing was seen.
    pub(super) fn of(state: State, report: Option<&FitReport>) -> Self {
        Self {
            state,
            counts: Counts::default(),
            coverage: 0.0,
            gap_deg: 180.0,
            seen: Seen::default(),
            rms_ut: report.map(|r| r.rms_ut),
            noise_ut: report.map(|r| r.noise_ut),
            predicted_error: report.map(|r| r.predicted_error_ut / r.calibration.field_ut),
            hint: Hint::Start,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Hint;
    use std::string::ToString;

    #[test]
    fn the_missing_side_is_what_is_brought_to_where_the_other_one_is() {
        let hint = Hint::Turn { missing: "front-left", now: "bottom" };
        assert_eq!(
            hint.to_string(),
            "keep rotating; bring the front-left side to where the bottom side is now"
        );
    }
}
