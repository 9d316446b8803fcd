//! The state machine.

use super::collector::{Collector, Stopped};
use super::config::SessionConfig;
use super::status::{Hint, Outcome, State, StateError, Status};
use crate::calibration::Calibration;
use crate::fit::{FitError, FitReport, Method};

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
