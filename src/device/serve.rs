//! The device with a driver and a memory that are waited for.

use super::machine::{Action, Device};
use super::output::Output;
use super::sensor::{SensorAnswer, SensorFault, SensorTask};
use crate::sensor::{Error, Magnetometer};
use crate::store::{Store, serve};

/// Does with the sensor what the device asks for.
pub fn serve_sensor<M: Magnetometer + ?Sized>(sensor: &mut M, task: SensorTask) -> SensorAnswer {
    let answer = match task {
        SensorTask::Start => sensor.init().map(|()| SensorAnswer::Started),
        SensorTask::Sample => match sensor.data_ready() {
            Ok(true) => sensor.read().map(SensorAnswer::Reading),
            Ok(false) => Ok(SensorAnswer::NotReady),
            Err(error) => Err(error),
        },
        // A bus that fails shows with the next sample.
        SensorTask::Temperature => Ok(SensorAnswer::Temperature(sensor.temperature_c().ok().flatten())),
    };
    answer.unwrap_or_else(|error| SensorAnswer::Failed(SensorFault::of(&error)))
}

impl SensorFault {
    /// What an error of a driver means to the user.
    pub fn of<E>(error: &Error<E>) -> Self {
        match *error {
            Error::Bus(_) => SensorFault::NoAnswer,
            Error::NotFound { expected, found } => SensorFault::WrongChip { expected, found },
            Error::NotKept { .. } => SensorFault::NotKept,
            Error::InvalidConfig(what) => SensorFault::InvalidConfig(what),
        }
    }
}

impl Device {
    /// One round: whatever is due now is done, waiting for sensor or memory. `false` where nothing is left to do before
    /// [`Self::next_deadline_ms`] or the next byte.
    pub fn turn<M: Magnetometer + ?Sized>(
        &mut self,
        now_ms: u64,
        sensor: &mut M,
        store: &mut impl Store,
        out: &mut impl Output,
    ) -> bool {
        match self.poll(now_ms, out) {
            Action::Sensor(task) => self.complete_sensor(serve_sensor(sensor, task), now_ms),
            Action::Store(task) => self.complete_store(&serve(store, &task), now_ms),
            Action::Again => {}
            Action::Sleep => return false,
        }
        true
    }
}
