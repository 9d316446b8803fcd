//! [`Magnetometer`](crate::Magnetometer) over a bus that is awaited.

use crate::description::Sensor;
use crate::error::Error;
use crate::sample::Reading;

/// What [`Magnetometer`](crate::Magnetometer) is, method by method, over a bus that is awaited. What each does and when it
/// fails stands there; the drivers of `ironout-drivers` implement both from one text.
#[allow(
    async_fn_in_trait,
    reason = "a driver is awaited where it is made: no executor needs to move its futures"
)]
pub trait AsyncMagnetometer {
    /// The error of the bus below.
    type BusError;

    /// As [`Magnetometer::describe`](crate::Magnetometer::describe).
    fn describe(&self) -> Sensor;

    /// As [`Magnetometer::init`](crate::Magnetometer::init).
    ///
    /// # Errors
    /// Every variant of [`Error`].
    async fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// As [`Magnetometer::data_ready`](crate::Magnetometer::data_ready).
    ///
    /// # Errors
    /// [`Error::Bus`].
    async fn data_ready(&mut self) -> Result<bool, Error<Self::BusError>>;

    /// As [`Magnetometer::read`](crate::Magnetometer::read).
    ///
    /// # Errors
    /// [`Error::Bus`]; [`Error::NotKept`] where the registers read show that the chip lost its configuration.
    async fn read(&mut self) -> Result<Reading, Error<Self::BusError>>;

    /// As [`Magnetometer::temperature_c`](crate::Magnetometer::temperature_c).
    ///
    /// # Errors
    /// [`Error::Bus`].
    async fn temperature_c(&mut self) -> Result<Option<f32>, Error<Self::BusError>>;
}
