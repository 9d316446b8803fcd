//! What the application needs of a magnetometer, whichever chip it is.

use crate::description::Sensor;
use crate::error::Error;
use crate::sample::Reading;

/// A three-axis magnetometer: counts, their scale, and the state of the chip.
///
/// The scale is given apart from the counts on purpose: a calibration accumulates the integers exactly and
/// turns them into µT once, when it solves. A chip with more than 16 bits is carried with [`Sensor::shift`] of them left out.
///
/// [`AsyncMagnetometer`](crate::AsyncMagnetometer) is the same for a bus that is awaited.
pub trait Magnetometer {
    /// The error of the bus below.
    type BusError;

    /// The chip as it is configured: name, scale, rate, range; its axes taken for the board's ([`Sensor::mounted`] says
    /// where they are not).
    fn describe(&self) -> Sensor;

    /// Identifies the chip, writes the whole configuration and reads it back. Also the way to bring the chip
    /// back after a fault: it assumes nothing about the chip's state and may be called at any time.
    ///
    /// # Errors
    /// Every variant of [`Error`].
    fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// Whether a measurement that was not read yet is waiting. The first one after [`Magnetometer::init`] may still be of
    /// the gain before it: a driver drops it here.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn data_ready(&mut self) -> Result<bool, Error<Self::BusError>>;

    /// Reads the latest measurement, all axes in one bus transaction, so that they belong together.
    ///
    /// # Errors
    /// [`Error::Bus`]; [`Error::NotKept`] where the registers read show that the chip lost its configuration.
    fn read(&mut self) -> Result<Reading, Error<Self::BusError>>;

    /// The chip's temperature in °C, `None` where the chip has no sensor for it or it is switched off.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn temperature_c(&mut self) -> Result<Option<f32>, Error<Self::BusError>>;
}

impl<M: Magnetometer + ?Sized> Magnetometer for &mut M {
    type BusError = M::BusError;

    fn describe(&self) -> Sensor {
        (**self).describe()
    }
    fn init(&mut self) -> Result<(), Error<Self::BusError>> {
        (**self).init()
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
