//! [`Accelerometer`](crate::Accelerometer) and [`Gyroscope`](crate::Gyroscope) over a bus that is awaited.

use crate::error::Error;

/// What [`Accelerometer`](crate::Accelerometer) is, over a bus that is awaited.
#[allow(
    async_fn_in_trait,
    reason = "a driver is awaited where it is made: no executor needs to move its futures"
)]
pub trait AsyncAccelerometer {
    /// The error of the bus below.
    type BusError;

    /// As [`Accelerometer::init`](crate::Accelerometer::init).
    ///
    /// # Errors
    /// Every variant of [`Error`].
    async fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// As [`Accelerometer::read_mps2`](crate::Accelerometer::read_mps2).
    ///
    /// # Errors
    /// [`Error::Bus`].
    async fn read_mps2(&mut self) -> Result<Option<[f32; 3]>, Error<Self::BusError>>;
}

/// What [`Gyroscope`](crate::Gyroscope) is, over a bus that is awaited.
#[allow(
    async_fn_in_trait,
    reason = "a driver is awaited where it is made: no executor needs to move its futures"
)]
pub trait AsyncGyroscope {
    /// The error of the bus below.
    type BusError;

    /// As [`Gyroscope::init`](crate::Gyroscope::init).
    ///
    /// # Errors
    /// Every variant of [`Error`].
    async fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// As [`Gyroscope::read_radps`](crate::Gyroscope::read_radps).
    ///
    /// # Errors
    /// [`Error::Bus`].
    async fn read_radps(&mut self) -> Result<Option<[f32; 3]>, Error<Self::BusError>>;
}
