//! Feeding the study: samples, columns, motion, the chip's temperature.

use super::active::Active;
use super::learner_inputs::Axes;
use super::machine::Device;
use super::own::{Origin, TEMPERATURE};
use super::sensor::SensorTask;
use super::study::Fed;
use crate::effect::{ColumnName, TIME};
#[cfg(feature = "study")]
use crate::fit::{MAX_PREDICTED_ERROR, Order};
use crate::record::Record;
#[cfg(feature = "study")]
use crate::sensor::Sample;
#[cfg(feature = "study")]
use crate::session::State;
use crate::store::Slot;

/// How often a temperature is measured, ms: a chip that warms by some tenths of a degree a second is followed within its own steps.
pub const TEMPERATURE_MS: u64 = 250;
/// How often a chip that has none is asked, ms.
pub const NO_TEMPERATURE_MS: u64 = 30_000;
/// How often a calibration under way is looked at, and with how many samples first.
#[cfg(feature = "study")]
const BEGIN_MS: u64 = 2000;
#[cfg(feature = "study")]
const BEGIN_SAMPLES: u64 = 150;
/// The study begins at a calibration whose predicted error is so many times what would be accepted, ...
#[cfg(feature = "study")]
const GOOD_ENOUGH: f64 = 5.0;
/// ... and with so many samples at any: a strong effect is what makes it wrong.
#[cfg(feature = "study")]
const MOST_SAMPLES: u64 = 1500;

pub(super) const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
pub(super) const TURN: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];

impl Device {
    /// Takes the value of a column (a temperature, an ADC channel, anything that an effect may follow) from the owner; NaN where it is
    /// not known any more. Says whether it is used or tested.
    pub fn on_column(&mut self, name: &str, value: f32, t_ms: u64) -> bool {
        self.steady(t_ms);
        let Ok(name) = ColumnName::new(name) else { return false };
        let value = Some(f64::from(value)).filter(|value| value.is_finite());
        let (used, tested) = self.feed(&name, value);
        used || tested
    }

    /// Takes what accelerometer (m/s², specific force) and gyro (rad/s) measured, both in the board's axes.
    pub fn on_motion(&mut self, accel_mps2: Option<[f32; 3]>, turn_radps: Option<[f32; 3]>) {
        self.learner_inputs.motion.accel_mps2 = accel_mps2;
        self.learner_inputs.motion.turn_radps = turn_radps;
        self.learner_inputs.turn_at_ms = self.now_ms;
        for (names, values) in [(ACCEL, accel_mps2), (TURN, turn_radps)] {
            let Some(values) = values else { continue };
            for (name, value) in names.into_iter().zip(values) {
                if let Ok(name) = ColumnName::new(name) {
                    let _ = self.log.feed(&name, value);
                }
            }
        }
    }

    /// A column's new value, or that it is not known; whether the calibration in use reads it, and whether it is tested.
    pub(super) fn feed(&mut self, name: &ColumnName, value: Option<f64>) -> (bool, bool) {
        let now_ms = self.now_ms;
        let number = value.unwrap_or(f64::NAN);
        let used = self.active.as_mut().is_some_and(|active| active.feed(name.as_str(), number, now_ms));
        if name.as_str() == TIME {
            return (used, false);
        }
        // A column for which there is no room is in no log; it is tested all the same.
        let _ = self.log.feed(name, number as f32);
        let learner_inputs = &mut self.learner_inputs;
        let axis = |names: [&str; 3]| names.iter().position(|own| *own == name.as_str());
        let whole = |[x, y, z]: Axes| Some([x?, y?, z?]);
        let single = value.map(|value| value as f32);
        if let Some(slot) = axis(ACCEL).and_then(|axis| learner_inputs.accel.get_mut(axis)) {
            *slot = single;
            learner_inputs.motion.accel_mps2 = whole(learner_inputs.accel);
            return (used, value.is_some());
        }
        if let Some(slot) = axis(TURN).and_then(|axis| learner_inputs.turn.get_mut(axis)) {
            *slot = single;
            learner_inputs.motion.turn_radps = whole(learner_inputs.turn);
            learner_inputs.turn_at_ms = now_ms;
            return (used || self.turning_is_used(), value.is_some());
        }
        let tested = match single {
            Some(value) => learner_inputs.learner.feed(name, value) == Fed::Tested,
            None => {
                learner_inputs.learner.drop_column(name.as_str());
                false
            }
        };
        (used, tested)
    }

    fn turning_is_used(&self) -> bool {
        self.active.as_ref().is_some_and(|active| active.live.as_ref().is_ok_and(|live| live.needs_gyro()))
    }

    /// Learns from a sample.
    #[cfg(feature = "study")]
    #[inline(never)]
    pub(super) fn learn(&mut self, sample: Sample, t_ms: u64) {
        // A question is answered of the moment that it was asked in, all of it, whatever comes between its pieces of work.
        if !self.learner_inputs.learner.is_learning() || self.learner_inputs.question.is_some() {
            return;
        }
        let Some(measured_ut) = self.config.sensor.measured_ut(sample) else { return };
        let (motion, turn_radps) = (self.learner_inputs.motion, self.turn_radps());
        let cleaned = match self.active.as_mut() {
            Some(active) => match active.at(t_ms).map(|live| live.cleaned(measured_ut, turn_radps)) {
                // An effect waits for its column: what it does now is not known.
                Some(Err(_)) => return,
                Some(Ok(cleaned)) => cleaned,
                None => measured_ut,
            },
            None => measured_ut,
        };
        self.learner_inputs.learner.push(cleaned, t_ms, &motion);
    }

    /// A calibration begins from nothing, and so does the study: at the calibration in use, or once there is one.
    pub(super) fn learn_anew(&mut self) {
        match &self.active {
            Some(active) => self.learner_inputs.learner.begin(&active.record.calibration),
            // The study knows where it stood; where that is wrong it finds out.
            None => self.learner_inputs.learner.begin_again(),
        }
        self.learner_inputs.begin_at_ms = 0;
    }

    /// Begins the study at a calibration that is under way, once it is good enough. Whether it took a computation.
    #[cfg(feature = "study")]
    #[inline(never)]
    pub(super) fn begin_to_learn(&mut self) -> bool {
        let learner_inputs = &self.learner_inputs;
        // Level turns do not show where to begin.
        if self.is_level()
            || learner_inputs.learner.is_learning()
            || self.session.state() != State::Collecting
            || self.now_ms < learner_inputs.begin_at_ms
            || self.session.counts().n < BEGIN_SAMPLES
            || !self.may_compute(true)
        {
            return false;
        }
        self.compute_asked_ms = None;
        self.learner_inputs.begin_at_ms = self.now_ms + BEGIN_MS;
        let n = self.session.counts().n;
        if n < MOST_SAMPLES {
            if let Some(Ok(report)) = self.session.ellipsoid_so_far()
                && report.model == Order::Ellipsoid
                && report.predicted_error_ut < GOOD_ENOUGH * MAX_PREDICTED_ERROR * report.calibration.field_ut
            {
                self.learner_inputs.learner.begin(&report.calibration);
            }
        } else if let Some(Ok(report)) = self.session.fit_so_far() {
            self.learner_inputs.learner.begin(&report.calibration);
        }
        true
    }

    /// Applies a record from now on. What was learned goes on where it was learned without effects, in the same field.
    #[inline(never)]
    pub(super) fn put_to_work(&mut self, slot: Slot, record: &Record) {
        let had_effects = self.active.as_ref().is_some_and(|active| !active.record.effects.is_empty());
        let learner = &mut self.learner_inputs.learner;
        let near = |field: f64| (field / record.calibration.field_ut - 1.0).abs() < 1e-6;
        if had_effects || !learner.field_ut().is_some_and(near) {
            learner.begin(&record.calibration);
        }
        self.learner_inputs.own_clock = false;
        Active::install(&mut self.active, slot, record, self.config.sensor.axes);
        self.feed_again();
    }

    /// The values that are known, to a calibration that was put to work.
    pub(super) fn feed_again(&mut self) {
        let now_ms = self.now_ms;
        let Some(active) = &mut self.active else { return };
        let learner = &self.learner_inputs.learner;
        for name in learner.tested() {
            if let Some(value) = learner.value(name) {
                active.feed(name, f64::from(value), now_ms);
            }
        }
    }

    /// There is no calibration any more.
    #[inline(never)]
    pub(super) fn cleared_from_work(&mut self) {
        let Some(active) = self.active.take() else { return };
        if !active.record.effects.is_empty() {
            self.learner_inputs.learner.begin(&active.record.calibration);
        }
    }

    /// Whether the chip's temperature is due: right after a sample, four times a second.
    pub(super) fn temperature_task(&self) -> Option<SensorTask> {
        let is_due = self.now_ms >= self.learner_inputs.temperature_at_ms && self.sensor.asks();
        is_due.then_some(SensorTask::Temperature)
    }

    pub(super) fn take_temperature(&mut self, temp_c: Option<f32>) {
        let Some(temp_c) = temp_c.filter(|value| value.is_finite()) else {
            self.learner_inputs.temperature_at_ms = self.now_ms + NO_TEMPERATURE_MS;
            self.learner_inputs.no_temperature = true;
            return;
        };
        self.learner_inputs.temperature_at_ms = self.now_ms + TEMPERATURE_MS;
        self.on_own_column(TEMPERATURE, temp_c, Origin::Inside);
    }
}
