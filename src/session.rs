//! A calibration from start to verdict: Idle → Collecting → Solved | Refused. No I/O.
//!
//! The session owns the accumulator, the rest gate and the sketch of directions; whoever owns the sensor pushes
//! counts, whoever talks to the user asks for the status.

use crate::calibration::Calibration;
use crate::coverage::{Coverage, Sketch, side_name};
use crate::fit::{FitError, FitOptions, FitReport, MAX_PREDICTED_ERROR, Method, fit};
use crate::gate::{Gated, RestGate, block_samples};
use crate::moments::Moments;
use crate::quality::{Verdict, judge};
use crate::record::Record;
use crate::scatter::Scatter;
use crate::sensor::{Sample, Sensor};
use crate::whiteness::ThirdDifferences;
use core::fmt;

/// Where a session stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// The word of the console: `idle`, `collecting`, `solved`, `refused`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Collecting => "collecting",
            Self::Solved => "solved",
            Self::Refused => "refused",
        }
    }
}

/// What a session needs to know of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SessionConfig {
    /// Scale of each axis, µT per count.
    pub ut_per_count: [f64; 3],
    /// The expected magnitude of the field, µT; `None` keeps the mean magnitude.
    pub field_ut: Option<f64>,
    /// The method.
    pub method: Method,
    /// Samples in a block of the rest gate; see [`crate::gate::block_samples`].
    pub samples_per_block: u16,
}

impl SessionConfig {
    /// For a sensor whose every conversion is taken: its scale in the board's axes, its rate; the default method, and no
    /// expected magnitude.
    pub fn of(sensor: &Sensor) -> Self {
        Self {
            ut_per_count: sensor.board_ut_per_count().map(f64::from),
            field_ut: None,
            method: Method::default(),
            samples_per_block: block_samples(f64::from(sensor.rate_hz)),
        }
    }
}

/// A request that does not fit the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateError {
    /// The state it came in.
    pub state: State,
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.state {
            State::Idle => write!(f, "nothing is collected: start a calibration first"),
            State::Collecting => write!(f, "still collecting: stop first"),
            State::Solved => write!(f, "a solution waits: accept or cancel it first"),
            State::Refused => write!(f, "the last data were refused: start again"),
        }
    }
}

impl core::error::Error for StateError {}

/// What to do next, in words.
#[derive(Clone, Copy, Debug, PartialEq)]
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
            Self::Start => write!(f, "start a calibration with: cal start"),
            Self::Move => write!(f, "turn the board slowly in all directions"),
            Self::Turn { missing, now } => {
                write!(f, "keep turning; bring the {missing} side to where the {now} side is now")
            }
            Self::Stop => write!(f, "enough directions seen; solve with: cal stop"),
            Self::Accept => write!(f, "store and apply the solution with: cal accept"),
            Self::Again => write!(f, "the data were refused; begin again with: cal start"),
        }
    }
}

/// What a session has taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
pub struct Status {
    /// Where it stands.
    pub state: State,
    /// What was taken.
    pub counts: Counts,
    /// Fraction of directions seen, 0 … 1.
    pub coverage: f32,
    /// Largest gap in the directions, degrees.
    pub gap_deg: f32,
    /// Residual rms of the fit so far, µT.
    pub rms_ut: Option<f64>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: Option<f64>,
    /// Predicted 1σ error of the corrected vector, over the field.
    pub predicted_error: Option<f64>,
    /// What to do next.
    pub hint: Hint,
}

/// The outcome of [`Session::stop`].
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Accepted or refused, with reasons.
    pub verdict: Verdict,
    /// The fit, where there was one; also of a refused calibration.
    pub report: Option<FitReport>,
    /// The directions seen.
    pub coverage: Coverage,
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct Session {
    config: SessionConfig,
    state: State,
    moments: Moments,
    gate: RestGate,
    sketch: Sketch,
    differences: ThirdDifferences,
    last: Option<[i16; 3]>,
    at_rest: u64,
    repeated: u64,
    saturated: u64,
    outcome: Option<Outcome>,
}

impl Session {
    /// An idle session.
    pub fn new(config: SessionConfig) -> Self {
        Self {
            config,
            state: State::Idle,
            moments: Moments::new(),
            gate: RestGate::new(config.ut_per_count, config.samples_per_block),
            sketch: Sketch::new(config.ut_per_count.map(|v| v as f32)),
            differences: ThirdDifferences::new(config.ut_per_count.map(|v| v as f32)),
            last: None,
            at_rest: 0,
            repeated: 0,
            saturated: 0,
            outcome: None,
        }
    }

    /// The configuration.
    pub fn config(&self) -> &SessionConfig {
        &self.config
    }

    /// Changes the method of the next solve.
    pub fn set_method(&mut self, method: Method) {
        self.config.method = method;
    }

    /// Changes the expected magnitude; `false`, and nothing changed, unless it is positive and finite or `None`.
    pub fn set_field_ut(&mut self, field_ut: Option<f64>) -> bool {
        let sound = field_ut.is_none_or(|v| v.is_finite() && v > 0.0);
        if sound {
            self.config.field_ut = field_ut;
        }
        sound
    }

    /// Where the session stands.
    pub fn state(&self) -> State {
        self.state
    }

    /// Starts collecting, from nothing. Whatever was collected or solved before is forgotten.
    pub fn start(&mut self) {
        *self = Self { state: State::Collecting, ..Self::new(self.config) };
    }

    /// Gives up; idle again.
    pub fn cancel(&mut self) {
        *self = Self::new(self.config);
    }

    /// Takes one sample, in any state: outside of `Collecting` it is left alone. A sample out of range, or at the
    /// ends of the 16-bit range, is counted but not used.
    pub fn push(&mut self, sample: Sample) {
        if self.state != State::Collecting {
            return;
        }
        let counts = sample.counts;
        if !sample.is_valid() || counts.iter().any(|c| *c == i16::MIN || *c == i16::MAX) {
            self.saturated += 1;
            self.differences.interrupt();
            return;
        }
        // A sensor slower than its reader repeats itself; a repeated triple is one sample.
        if self.last == Some(counts) {
            self.repeated += 1;
            return;
        }
        self.last = Some(counts);
        self.sketch.add(counts);
        self.differences.push(counts);
        let gated = self.gate.push(counts, &mut self.moments);
        self.take_note(gated);
    }

    fn take_note(&mut self, gated: Gated) {
        if let Gated::Dropped(n) = gated {
            self.at_rest += n;
        }
        self.differences.close(gated);
    }

    fn fit(&self) -> Result<FitReport, FitError> {
        let scatter = Scatter::from_moments(&self.moments, self.config.ut_per_count)?;
        let options =
            FitOptions { method: self.config.method, field_ut: self.config.field_ut, ..Default::default() };
        let report = fit(&scatter, &options)?;
        let noise_ut2 = report.noise_ut * report.noise_ut;
        let share = self.differences.independent_share(noise_ut2, scatter.quantisation_ut2);
        let mut report = match share {
            Some(share) => {
                let effective_samples = Some((report.samples as f64 * share).max(1.0));
                fit(&scatter, &FitOptions { effective_samples, ..options })?
            }
            None => report,
        };
        report.add_noise_bias(&scatter);
        Ok(report)
    }

    fn coverage(&self, report: Option<&FitReport>) -> Coverage {
        match report {
            Some(report) => self.sketch.coverage(&report.calibration.cast()),
            None => self.sketch.coverage_about_middle(),
        }
    }

    /// Where the field comes from as the board lies now, in its axes; not of unit length. Before there is a calibration:
    /// about the middle of what was seen.
    fn field_now(&self, report: Option<&FitReport>) -> [f32; 3] {
        let counts = self.last.unwrap_or_default();
        let measured_ut = core::array::from_fn(|a| f32::from(counts[a]) * self.config.ut_per_count[a] as f32);
        let calibration = match report {
            Some(report) => report.calibration.cast(),
            None => Calibration { offset_ut: self.sketch.middle_ut(), ..Calibration::identity(1.0) },
        };
        calibration.apply(measured_ut)
    }

    /// Solves for the calibration and judges it.
    ///
    /// # Errors
    /// [`StateError`] unless collecting.
    pub fn stop(&mut self) -> Result<&Outcome, StateError> {
        if self.state != State::Collecting {
            return Err(StateError { state: self.state });
        }
        let gated = self.gate.flush(&mut self.moments);
        self.take_note(gated);
        let fitted = self.fit();
        let coverage = self.coverage(fitted.as_ref().ok());
        let (verdict, report) = match fitted {
            Ok(report) => {
                (judge(&report, Some(&coverage), self.saturated, self.config.field_ut), Some(report))
            }
            Err(error) => (Verdict::of_error(error), None),
        };
        self.state = if verdict.accepted { State::Solved } else { State::Refused };
        Ok(self.outcome.insert(Outcome { verdict, report, coverage }))
    }

    /// The outcome of the last [`Self::stop`], until the next start or cancel.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// The accepted solution that waits for [`Self::accept`].
    pub fn solution(&self) -> Option<&FitReport> {
        if self.state == State::Solved { self.outcome.as_ref().and_then(|o| o.report.as_ref()) } else { None }
    }

    /// Hands the solution over, as it is stored; idle again.
    ///
    /// # Errors
    /// [`StateError`] unless solved.
    pub fn accept(&mut self) -> Result<Record, StateError> {
        let error = StateError { state: self.state };
        let record = self.solution().map(Record::of).ok_or(error)?;
        self.cancel();
        Ok(record)
    }

    /// What was taken so far, without a solve.
    pub fn counts(&self) -> Counts {
        Counts {
            n: self.moments.count() + self.gate.pending(),
            skipped: self.at_rest + self.repeated + self.saturated,
            saturated: self.saturated,
        }
    }

    /// A snapshot; while collecting it solves the data so far to tell what they carry.
    pub fn status(&self) -> Status {
        let live = if self.state == State::Collecting { self.fit().ok() } else { None };
        let report = live.as_ref().or(self.outcome.as_ref().and_then(|o| o.report.as_ref()));
        let coverage = match &self.outcome {
            Some(outcome) => outcome.coverage,
            None => self.coverage(report),
        };
        let predicted_error = report.map(|r| r.predicted_error_ut / r.calibration.field_ut);
        let hint = match self.state {
            State::Idle => Hint::Start,
            State::Solved => Hint::Accept,
            State::Refused => Hint::Again,
            State::Collecting if self.sketch.points().len() < 3 => Hint::Move,
            // Half the limit: a little more than enough, so that the verdict at the stop is not a surprise.
            State::Collecting if predicted_error.is_some_and(|e| e <= 0.5 * MAX_PREDICTED_ERROR) => {
                Hint::Stop
            }
            State::Collecting => {
                Hint::Turn { missing: coverage.missing_side(), now: side_name(self.field_now(report)) }
            }
        };
        let empty = self.sketch.points().is_empty();
        Status {
            state: self.state,
            counts: self.counts(),
            coverage: if empty { 0.0 } else { coverage.fraction },
            gap_deg: if empty { 180.0 } else { coverage.gap_deg },
            rms_ut: report.map(|r| r.rms_ut),
            noise_ut: report.map(|r| r.noise_ut),
            predicted_error,
            hint,
        }
    }
}
