//! What the application needs of a magnetometer, whichever chip it is.

use crate::error::Error;

/// One measurement, as the chip delivers it, in the chip's own axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading {
    /// x, y, z in counts.
    pub counts: [i16; 3],
    /// Per axis: the field was outside the range, so that the count is no measurement of it.
    pub overflow: [bool; 3],
}

impl Reading {
    /// Whether any axis was outside its range. Such a sample must not enter a calibration.
    pub fn saturated(&self) -> bool {
        self.overflow.iter().any(|&axis| axis)
    }
}

/// A three-axis magnetometer: counts, their scale, and the state of the chip.
///
/// The scale is given apart from the counts on purpose: a calibration accumulates the integers exactly and
/// turns them into µT once, when it solves.
pub trait Magnetometer {
    /// The error of the bus below.
    type BusError;

    /// The chip's name, for logs and for the console.
    fn name(&self) -> &'static str;

    /// Identifies the chip, writes the whole configuration and reads it back. Also the way to bring the chip
    /// back after a fault: it assumes nothing about the chip's state and may be called at any time.
    ///
    /// # Errors
    /// Every variant of [`Error`].
    fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// µT per count, per axis, at the configured range.
    fn ut_per_count(&self) -> [f32; 3];

    /// The largest magnitude of a valid count.
    fn full_scale_counts(&self) -> u16;

    /// The configured number of measurements a second.
    fn rate_hz(&self) -> f32;

    /// Whether a measurement that was not read yet is waiting.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn data_ready(&mut self) -> Result<bool, Error<Self::BusError>>;

    /// Reads the latest measurement, all axes in one bus transaction, so that they belong together.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn read(&mut self) -> Result<Reading, Error<Self::BusError>>;

    /// The chip's temperature in °C, `None` where the chip has no sensor for it or it is switched off.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn temperature_c(&mut self) -> Result<Option<f32>, Error<Self::BusError>>;
}

impl<M: Magnetometer + ?Sized> Magnetometer for &mut M {
    type BusError = M::BusError;

    fn name(&self) -> &'static str {
        (**self).name()
    }
    fn init(&mut self) -> Result<(), Error<Self::BusError>> {
        (**self).init()
    }
    fn ut_per_count(&self) -> [f32; 3] {
        (**self).ut_per_count()
    }
    fn full_scale_counts(&self) -> u16 {
        (**self).full_scale_counts()
    }
    fn rate_hz(&self) -> f32 {
        (**self).rate_hz()
    }
    fn data_ready(&mut self) -> Result<bool, Error<Self::BusError>> {
        (**self).data_ready()
    }
    fn read(&mut self) -> Result<Reading, Error<Self::BusError>> {
        (**self).read()
    }
    fn temperature_c(&mut self) -> Result<Option<f32>, Error<Self::BusError>> {
        (**self).temperature_c()
    }
}
