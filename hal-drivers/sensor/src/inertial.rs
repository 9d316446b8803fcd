//! What the application needs of an accelerometer and of a gyroscope, whichever chips they are.

use crate::error::Error;

/// A three-axis accelerometer, in the chip's axes.
pub trait Accelerometer {
    /// The error of the bus below.
    type BusError;

    /// Identifies the chip where it can be, writes the whole configuration and reads it back; at any time, also after a fault.
    ///
    /// # Errors
    /// Every variant of [`Error`].
    fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// The specific force along x, y, z of the chip in m/s²: at rest 9.81 away from the ground. `None` where an axis was at
    /// the end of its range.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn read_mps2(&mut self) -> Result<Option<[f32; 3]>, Error<Self::BusError>>;
}

/// A three-axis gyroscope, in the chip's axes.
pub trait Gyroscope {
    /// The error of the bus below.
    type BusError;

    /// Identifies the chip, writes the whole configuration and reads it back; at any time, also after a fault.
    ///
    /// # Errors
    /// Every variant of [`Error`].
    fn init(&mut self) -> Result<(), Error<Self::BusError>>;

    /// The rates about x, y, z of the chip in rad/s, right-handed. `None` where an axis was at the end of its range.
    ///
    /// # Errors
    /// [`Error::Bus`].
    fn read_radps(&mut self) -> Result<Option<[f32; 3]>, Error<Self::BusError>>;
}
