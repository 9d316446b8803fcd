//! Samples on their way in.

use super::learner_inputs::LearnerInputs;
use super::machine::Device;
use super::sensor::SensorAnswer;
use super::streamed;
use crate::protocol::StreamMode;
use crate::sensor::{Reading, Sample};

/// A rate of turn that is older, ms, is not of now: `cal zero` does not go on with it.
const GYRO_SILENT_MS: u64 = 500;

impl Device {
    /// Takes a measurement (chip axes) that the owner made on its own: with [`Pace::Pushed`](crate::device::Pace::Pushed), all of them. It works without
    /// anything else, too: a sensor that is heard of works.
    pub fn on_sample(&mut self, reading: &Reading, t_ms: u64) {
        let t_ms = self.steady(t_ms);
        self.sensor.heard(t_ms);
        self.take_sample(self.config.sensor.sample(reading), t_ms);
    }

    #[inline(never)]
    fn take_sample(&mut self, sample: Sample, t_ms: u64) {
        self.session.push(sample);
        self.samples_taken = self.samples_taken.wrapping_add(1);
        let measured_ut = self.config.sensor.measured_ut(sample);
        if let Some(measured_ut) = measured_ut {
            self.view.measured(t_ms, measured_ut);
        }
        if let Some(active) = &mut self.active {
            let LearnerInputs { motion, turn_at_ms, .. } = &self.learner_inputs;
            let is_fresh = t_ms.saturating_sub(*turn_at_ms) <= GYRO_SILENT_MS;
            active.take(t_ms, measured_ut, motion, motion.turn_radps.filter(|_| is_fresh));
        }
        if self.is_level()
            && let (Some(forces), Some(measured_ut)) = (&mut self.level, measured_ut)
        {
            forces.push(measured_ut, self.learner_inputs.motion.accel_mps2);
        }
        #[cfg(feature = "study")]
        self.learn(sample, t_ms);
        if self.stream != StreamMode::Off {
            if self.waiting.is_full() {
                self.waiting.pop_front();
            }
            // There is room now.
            let _ = self.waiting.push_back(streamed::Sample {
                t_ms,
                seq: self.samples_taken.wrapping_add(self.sensor.lost()),
                counts: sample.counts,
                measured_ut,
                turn_radps: self.turn_radps(),
                is_tilted: self.tilted().is_some(),
            });
        }
    }

    /// How the board turned at the last sample, as far as it is known.
    pub(super) fn turn_radps(&self) -> Option<[f32; 3]> {
        let of_field = || self.active.as_ref().and_then(|active| active.turn_radps);
        self.learner_inputs.motion.turn_radps.or_else(of_field)
    }

    /// Takes what came of an [`Action::Sensor`](crate::device::Action::Sensor), with the time it is now.
    pub fn complete_sensor(&mut self, answer: SensorAnswer, now_ms: u64) {
        let now_ms = self.steady(now_ms);
        if let SensorAnswer::Temperature(temp_c) = answer {
            return self.take_temperature(temp_c);
        }
        self.sensor.answered(answer, now_ms);
        if let SensorAnswer::Reading(reading) = answer {
            self.take_sample(self.config.sensor.sample(&reading), now_ms);
        }
    }
}
