//! A calibration from start to verdict: Idle → Collecting → Solved | Refused. No I/O.
//!
//! The session owns the rest gate with the sums behind it and the sketch of directions; whoever owns the sensor pushes
//! counts, whoever talks to the user asks for the status. What collects and what came of it are never needed at once, and
//! share their memory.

use crate::calibration::Calibration;
use crate::coverage::{Coverage, Sketch};
use crate::fit::{FitError, FitOptions, FitReport, MAX_PREDICTED_ERROR, Method, fit};
use crate::gate::{Gated, RestGate};
use crate::quality::{Verdict, judge};
use crate::scatter::Scatter;
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
    /// The scale in the precision of coverage, whose cells are coarse.
    fn scale(&self) -> [f32; 3] {
        self.ut_per_count.map(|scale| scale as f32)
    }
}

/// A box of samples with no longer side than this is a board that was not turned yet, µT: some 5° of the Earth's field.
const MOVED_UT: f32 = 4.0;

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
    /// Point a side of the board along the field.
    Point {
        /// The side, for example `front-left`.
        side: &'static str,
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
            Self::Point { side } => write!(f, "keep turning; point the {side} side to the ground and north"),
            Self::Stop => write!(f, "enough directions seen; solve with: cal stop"),
            Self::Accept => write!(f, "store and apply the solution with: cal accept"),
            Self::Again => write!(f, "the data were refused; begin again with: cal start"),
        }
    }
}

/// A snapshot of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Where it stands.
    pub state: State,
    /// Samples in motion, in the sums.
    pub n: u64,
    /// Samples left out: at rest, repeated or saturated.
    pub skipped: u64,
    /// Of those, samples at the sensor's limits.
    pub saturated: u64,
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

/// What collects.
#[derive(Clone, Debug)]
struct Collector {
    gate: RestGate,
    sketch: Sketch,
    differences: ThirdDifferences,
    last: Option<[i16; 3]>,
    at_rest: u32,
    repeated: u32,
    saturated: u32,
}

/// What came of it.
#[derive(Clone, Debug)]
struct Stopped {
    outcome: Outcome,
    n: u64,
    skipped: u64,
    saturated: u32,
}

/// Where a session stands, and what it knows there.
#[derive(Clone, Debug)]
// The difference is what a session that collects needs; there is nowhere else to keep it.
#[allow(clippy::large_enum_variant)]
enum Stage {
    Idle,
    Collecting(Collector),
    Stopped(Stopped),
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct Session {
    config: SessionConfig,
    stage: Stage,
}

const _: () = assert!(core::mem::size_of::<Session>() <= 1600, "the session's memory is a promise");

impl Collector {
    fn new(config: &SessionConfig) -> Self {
        let ut_per_count = config.scale();
        Self {
            gate: RestGate::new(config.ut_per_count, config.samples_per_block),
            sketch: Sketch::new(ut_per_count),
            differences: ThirdDifferences::new(ut_per_count),
            last: None,
            at_rest: 0,
            repeated: 0,
            saturated: 0,
        }
    }

    fn push(&mut self, counts: [i16; 3], saturated: bool) {
        if saturated || counts.iter().any(|c| *c == i16::MIN || *c == i16::MAX) {
            self.saturated = self.saturated.saturating_add(1);
            self.differences.interrupt();
            return;
        }
        // A sensor slower than its reader repeats itself; a repeated triple is one sample.
        if self.last == Some(counts) {
            self.repeated = self.repeated.saturating_add(1);
            return;
        }
        self.last = Some(counts);
        self.sketch.add(counts);
        self.differences.push(counts);
        let gated = self.gate.push(counts);
        self.take_note(gated);
    }

    #[inline]
    fn take_note(&mut self, gated: Gated) {
        if gated == Gated::Pending {
            return;
        }
        if let Gated::Dropped(n) = gated {
            self.at_rest = self.at_rest.saturating_add(n as u32);
        }
        self.differences.close(gated);
    }

    fn fit(&self, config: &SessionConfig) -> Result<FitReport, FitError> {
        let scatter = Scatter::from_moments(self.gate.moments(), config.ut_per_count)?;
        let options = FitOptions { method: config.method, field_ut: config.field_ut, ..Default::default() };
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

    fn coverage(&self, config: &SessionConfig, report: Option<&FitReport>) -> Coverage {
        match report {
            Some(report) => self.sketch.coverage(&report.calibration.cast(), config.scale()),
            None => self.sketch.coverage_about_middle(config.scale()),
        }
    }

    fn skipped(&self) -> u64 {
        u64::from(self.at_rest) + u64::from(self.repeated) + u64::from(self.saturated)
    }

    /// Solves for the calibration and judges it.
    fn stop(&mut self, config: &SessionConfig) -> Stopped {
        let gated = self.gate.flush();
        self.take_note(gated);
        let fitted = self.fit(config);
        let coverage = self.coverage(config, fitted.as_ref().ok());
        let (verdict, report) = match fitted {
            Ok(report) => {
                (judge(&report, Some(&coverage), self.saturated.into(), config.field_ut), Some(report))
            }
            Err(error) => (Verdict::of_error(error), None),
        };
        Stopped {
            outcome: Outcome { verdict, report, coverage },
            n: self.gate.moments().count(),
            skipped: self.skipped(),
            saturated: self.saturated,
        }
    }

    /// A snapshot; it solves the data so far to tell what they carry.
    fn status(&self, config: &SessionConfig) -> Status {
        let report = self.fit(config).ok();
        let coverage = self.coverage(config, report.as_ref());
        let figures = Status::of(State::Collecting, report.as_ref());
        let hint = if self.sketch.extent_ut(config.scale()) < MOVED_UT {
            Hint::Move
        // Half the limit: a little more than enough, so that the verdict at the stop is not a surprise.
        } else if figures.predicted_error.is_some_and(|e| e <= 0.5 * MAX_PREDICTED_ERROR) {
            Hint::Stop
        } else {
            Hint::Point { side: coverage.missing_side() }
        };
        Status {
            n: self.gate.moments().count() + self.gate.pending(),
            skipped: self.skipped(),
            saturated: self.saturated.into(),
            coverage: coverage.fraction,
            gap_deg: coverage.gap_deg,
            hint,
            ..figures
        }
    }
}

impl Status {
    /// The figures of a fit; nothing was seen.
    fn of(state: State, report: Option<&FitReport>) -> Self {
        Self {
            state,
            n: 0,
            skipped: 0,
            saturated: 0,
            coverage: 0.0,
            gap_deg: 180.0,
            rms_ut: report.map(|r| r.rms_ut),
            noise_ut: report.map(|r| r.noise_ut),
            predicted_error: report.map(|r| r.predicted_error_ut / r.calibration.field_ut),
            hint: Hint::Start,
        }
    }
}

impl Session {
    /// An idle session.
    pub fn new(config: SessionConfig) -> Self {
        Self { config, stage: Stage::Idle }
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
        match &self.stage {
            Stage::Idle => State::Idle,
            Stage::Collecting(_) => State::Collecting,
            Stage::Stopped(stopped) if stopped.outcome.verdict.accepted => State::Solved,
            Stage::Stopped(_) => State::Refused,
        }
    }

    /// Starts collecting, from nothing. Whatever was collected or solved before is forgotten.
    pub fn start(&mut self) {
        self.stage = Stage::Collecting(Collector::new(&self.config));
    }

    /// Gives up; idle again.
    pub fn cancel(&mut self) {
        self.stage = Stage::Idle;
    }

    /// Takes one sample, in any state: outside of `Collecting` it is left alone. A sample that is `saturated`, or at the
    /// ends of the 16-bit range, is counted but not used.
    pub fn push(&mut self, counts: [i16; 3], saturated: bool) {
        if let Stage::Collecting(collector) = &mut self.stage {
            collector.push(counts, saturated);
        }
    }

    /// The fit of the samples in motion so far; it changes nothing. `None` unless collecting.
    ///
    /// # Errors
    /// In the `Some`, the [`FitError`] that [`Self::stop`] would refuse with.
    pub fn fit_so_far(&self) -> Option<Result<FitReport, FitError>> {
        match &self.stage {
            Stage::Collecting(collector) => Some(collector.fit(&self.config)),
            _ => None,
        }
    }

    /// Solves for the calibration and judges it.
    ///
    /// # Errors
    /// [`StateError`] unless collecting.
    pub fn stop(&mut self) -> Result<&Outcome, StateError> {
        let error = StateError { state: self.state() };
        let Stage::Collecting(collector) = &mut self.stage else { return Err(error) };
        self.stage = Stage::Stopped(collector.stop(&self.config));
        self.outcome().ok_or(error)
    }

    /// The outcome of the last [`Self::stop`], until the next start or cancel.
    pub fn outcome(&self) -> Option<&Outcome> {
        match &self.stage {
            Stage::Stopped(stopped) => Some(&stopped.outcome),
            _ => None,
        }
    }

    /// The accepted solution that waits for [`Self::accept`].
    pub fn solution(&self) -> Option<&FitReport> {
        self.outcome().filter(|o| o.verdict.accepted).and_then(|o| o.report.as_ref())
    }

    /// Hands the solution over; idle again.
    ///
    /// # Errors
    /// [`StateError`] unless solved.
    pub fn accept(&mut self) -> Result<Calibration<f64>, StateError> {
        let calibration = self.solution().map(|report| report.calibration);
        let calibration = calibration.ok_or(StateError { state: self.state() })?;
        self.cancel();
        Ok(calibration)
    }

    /// A snapshot; while collecting it solves the data so far to tell what they carry.
    pub fn status(&self) -> Status {
        match &self.stage {
            Stage::Idle => Status::of(State::Idle, None),
            Stage::Collecting(collector) => collector.status(&self.config),
            Stage::Stopped(stopped) => {
                let Outcome { verdict, report, coverage } = &stopped.outcome;
                let (state, hint) = if verdict.accepted {
                    (State::Solved, Hint::Accept)
                } else {
                    (State::Refused, Hint::Again)
                };
                Status {
                    n: stopped.n,
                    skipped: stopped.skipped,
                    saturated: stopped.saturated.into(),
                    coverage: coverage.fraction,
                    gap_deg: coverage.gap_deg,
                    hint,
                    ..Status::of(state, report.as_ref())
                }
            }
        }
    }
}
