//! What a session does while it collects: the gate, the directions, and the fit of what there is.

use super::config::SessionConfig;
use super::status::{Counts, Hint, Outcome, State, Status};
use crate::calibration::Calibration;
use crate::coverage::{Sketch, side_name};
use crate::fit::{FitError, FitOptions, FitReport, MAX_PREDICTED_ERROR, fit};
use crate::gate::{Gated, RestGate};
#[cfg(feature = "device")]
use crate::level::{Forces, LevelFit, LevelPrior, NotLevel, fit_level};
use crate::quality::{Verdict, judge};
use crate::scatter::Scatter;
use crate::sensor::Sample;
use crate::whiteness::Whiteness;

/// A box of samples with no longer side than this is a board that was not turned yet, µT: some 5° of the Earth's field.
const MOVED_UT: f32 = 4.0;

/// What collects.
#[derive(Clone, Debug)]
pub(super) struct Collector {
    gate: RestGate,
    sketch: Sketch,
    whiteness: Whiteness,
    last: Option<[i16; 3]>,
    at_rest: u32,
    repeated: u32,
    saturated: u32,
}

/// What came of it.
#[derive(Clone, Debug)]
pub(super) struct Stopped {
    pub(super) outcome: Outcome,
    pub(super) counts: Counts,
}

impl Collector {
    pub(super) fn new(config: &SessionConfig) -> Self {
        let ut_per_count = config.scale();
        Self {
            gate: RestGate::new(config.ut_per_count, config.samples_per_block),
            sketch: Sketch::new(ut_per_count),
            whiteness: Whiteness::new(config.samples_per_block),
            last: None,
            at_rest: 0,
            repeated: 0,
            saturated: 0,
        }
    }

    pub(super) fn push(&mut self, sample: Sample) {
        let counts = sample.counts;
        if !sample.is_valid() || counts.iter().any(|c| *c == i16::MIN || *c == i16::MAX) {
            self.saturated = self.saturated.saturating_add(1);
            self.whiteness.interrupt();
            return;
        }
        // A sensor slower than its reader repeats itself; a repeated triple is one sample.
        if self.last == Some(counts) {
            self.repeated = self.repeated.saturating_add(1);
            return;
        }
        self.last = Some(counts);
        self.whiteness.push(counts);
        let gated = self.gate.push(counts);
        self.take_note(gated);
        // The grid does not grow in the push that decides on a block: that bounds the longest one, and the next sample comes
        // soon enough.
        if self.gate.block_is_open() {
            self.sketch.add(counts);
        } else {
            self.sketch.add_inside(counts);
        }
    }

    pub(super) fn interrupt(&mut self) {
        self.whiteness.interrupt();
    }

    #[inline]
    fn take_note(&mut self, gated: Gated) {
        if gated == Gated::Pending {
            return;
        }
        if let Gated::Dropped(n) = gated {
            self.at_rest = self.at_rest.saturating_add(n as u32);
        }
        self.whiteness.heed(gated);
    }

    pub(super) fn fit(&self, config: &SessionConfig) -> Result<FitReport, FitError> {
        self.fit_with(config, true)
    }

    pub(super) fn ellipsoid(&self, config: &SessionConfig) -> Result<FitReport, FitError> {
        self.fit_with(config, false)
    }

    fn fit_with(&self, config: &SessionConfig, lower_orders: bool) -> Result<FitReport, FitError> {
        let scatter = Scatter::from_moments(self.gate.moments(), config.ut_per_count)?;
        let options = FitOptions {
            method: config.solved_by(),
            field_ut: config.field_ut,
            lower_orders,
            ..Default::default()
        };
        let report = fit(&scatter, &options)?;
        let share = self.whiteness.independent_share(&report, config.ut_per_count, scatter.quantisation_ut2);
        let report = match share {
            Some(share) => {
                let effective_samples = Some((report.samples as f64 * share).max(1.0));
                fit(&scatter, &FitOptions { effective_samples, ..options })?
            }
            None => report,
        };
        // The adjusted method has none.
        #[cfg(feature = "methods")]
        let report = {
            let mut report = report;
            report.add_noise_bias(&scatter);
            report
        };
        Ok(report)
    }

    /// The fit for level headings.
    #[cfg(feature = "device")]
    pub(super) fn level(
        &self,
        config: &SessionConfig,
        prior: &LevelPrior,
        forces: &Forces,
    ) -> Result<LevelFit, NotLevel> {
        let scatter =
            Scatter::from_moments(self.gate.moments(), config.ut_per_count).map_err(NotLevel::Fit)?;
        fit_level(&scatter, &self.whiteness, config.ut_per_count, prior, forces)
    }

    /// The calibration of a fit; without one, about the middle of what was seen.
    #[inline(never)]
    fn calibration(&self, scale: [f32; 3], report: Option<&FitReport>) -> Calibration<f32> {
        match report {
            Some(report) => report.calibration.cast(),
            None => self.sketch.calibration_about_middle(scale),
        }
    }

    pub(super) fn counts(&self) -> Counts {
        Counts {
            n: self.gate.moments().count() + self.gate.pending(),
            skipped: u64::from(self.at_rest) + u64::from(self.repeated) + u64::from(self.saturated),
            saturated: self.saturated.into(),
        }
    }

    /// Where the field comes from as the board lies now, in its axes; not of unit length.
    fn field_now(&self, scale: [f32; 3], calibration: &Calibration<f32>) -> [f32; 3] {
        let counts = self.last.unwrap_or_default();
        calibration.apply(core::array::from_fn(|a| f32::from(counts[a]) * scale[a]))
    }

    /// Solves for the calibration and judges it.
    pub(super) fn stop(&mut self, config: &SessionConfig) -> Stopped {
        let gated = self.gate.flush();
        self.take_note(gated);
        let fitted = self.fit(config);
        let scale = config.scale();
        let coverage = self.sketch.coverage(&self.calibration(scale, fitted.as_ref().ok()), scale);
        let (verdict, report) = match fitted {
            Ok(report) => {
                (judge(&report, Some(&coverage), self.saturated.into(), config.field_ut), Some(report))
            }
            Err(error) => (Verdict::of_error(error), None),
        };
        Stopped { outcome: Outcome { verdict, report, coverage }, counts: self.counts() }
    }

    /// A snapshot; it solves the data so far to tell what they carry. Without the lower orders, which take more than twice the
    /// time and only say that there is not enough yet: samples go on coming meanwhile.
    pub(super) fn status(&self, config: &SessionConfig) -> Status {
        let report = self.fit_with(config, false).ok();
        let scale = config.scale();
        let calibration = self.calibration(scale, report.as_ref());
        let coverage = self.sketch.coverage(&calibration, scale);
        let figures = Status::of(State::Collecting, report.as_ref());
        let hint = if self.sketch.extent_ut(scale) < MOVED_UT {
            Hint::Move
        // Half the limit: a little more than enough, so that the verdict at the stop is not a surprise.
        } else if figures.predicted_error.is_some_and(|e| e <= 0.5 * MAX_PREDICTED_ERROR) {
            Hint::Stop
        } else {
            Hint::Turn {
                missing: coverage.missing_side(),
                now: side_name(self.field_now(scale, &calibration)),
            }
        };
        Status {
            counts: self.counts(),
            coverage: coverage.fraction,
            gap_deg: coverage.gap_deg,
            seen: coverage.seen,
            hint,
            ..figures
        }
    }
}
