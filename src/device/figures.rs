//! What the owner may ask the device.

use super::light::Light;
use super::machine::Device;
use super::sensor::SensorFault;
use crate::calibration::Calibration;
#[cfg(feature = "study")]
use crate::learn::Learner;
use crate::record::Record;
use crate::session::{Session, State};
use crate::store::Slot;

impl Device {
    /// The calibration in use.
    pub fn calibration(&self) -> Option<&Calibration<f64>> {
        self.record().map(|record| &record.calibration)
    }

    /// The stored record of the calibration in use.
    pub fn record(&self) -> Option<&Record> {
        self.active.as_ref().filter(|active| active.live.is_ok()).map(|active| &active.record)
    }

    /// The slot that must not be overwritten.
    pub(super) fn slot_in_use(&self) -> Option<Slot> {
        self.active.as_ref().map(|active| active.slot)
    }

    /// The session: what is being collected and what came of it.
    pub const fn session(&self) -> &Session {
        &self.session
    }

    /// What is wrong with the sensor, if it does not work.
    pub const fn sensor_fault(&self) -> Option<SensorFault> {
        self.sensor.fault()
    }

    /// Samples that were due, or conversions that were made, and not taken since power-up, while the sensor worked.
    pub const fn samples_lost(&self) -> u32 {
        self.sensor.lost()
    }

    /// What the light has to show.
    pub fn light(&self) -> Light {
        match self.state() {
            _ if self.sensor.fault().is_some() => Light::SensorFault,
            State::Collecting => Light::Collecting,
            State::Solved => Light::Solved,
            State::Refused => Light::Refused,
            State::Idle if self.record().is_some() => Light::Calibrated,
            State::Idle => Light::Uncalibrated,
        }
    }

    /// The study of what the calibration in use leaves over.
    #[cfg(feature = "study")]
    pub const fn learner(&self) -> &Learner {
        &self.learner_inputs.learner
    }
}
