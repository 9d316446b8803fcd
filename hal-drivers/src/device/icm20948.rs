//! The magnetometer of an ICM-20948, through its bypass.

use super::driver::Driver;
use super::mode::{DelayNs, I2c, Magnetometer, both};
use super::registers::{Registers, Wires};
use crate::chip::self_test::Outcome;
use crate::chip::{ak09916, icm20948 as chip};
use ironout_sensor::{Error, Reading, Sensor};

/// The magnetometer of an ICM-20948 on bus `I2C`, in the axes of the AK09916 (see
/// [`MAGNETOMETER_AXES`](crate::icm20948::MAGNETOMETER_AXES)).
#[derive(Debug)]
pub struct Icm20948<I2C> {
    address: u8,
    inner: Driver<I2C, ak09916::Config>,
}

impl<I2C> Icm20948<I2C> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub const fn new(i2c: I2C, config: chip::Config) -> Self {
        Self { address: config.address, inner: Driver::new(i2c, config.magnetometer) }
    }

    /// Gives the bus back. The bypass stays open, and the magnetometer goes on measuring.
    pub fn destroy(self) -> I2C {
        self.inner.destroy()
    }
}

#[both(AFIT)]
impl<I2C: I2c> Icm20948<I2C> {
    /// Puts the magnetometer on the bus.
    async fn open(&mut self) -> Result<(), Error<I2C::Error>> {
        let mut host =
            Registers { i2c: &mut self.inner.i2c, address: self.address, increment: 0, dummies: 0 };
        host.write(chip::REG_BANK_SEL, 0).await?;
        host.identify(chip::WHO_AM_I, &[chip::IDENTITY]).await?;
        host.configure(&chip::OPENING).await
    }

    /// The self-test of the AK09916 in it.
    ///
    /// # Errors
    /// As [`Magnetometer::init`].
    pub async fn self_test<D: DelayNs>(&mut self, delay: &mut D) -> Result<Outcome, Error<I2C::Error>> {
        self.open().await?;
        self.inner.self_test(delay).await
    }
}

#[both(AFIT)]
impl<I2C: I2c> Magnetometer for Icm20948<I2C> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        chip::named(self.inner.describe())
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        self.open().await?;
        self.inner.init().await
    }

    async fn data_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        self.inner.data_ready().await
    }

    async fn read(&mut self) -> Result<Reading, Error<I2C::Error>> {
        Magnetometer::read(&mut self.inner).await
    }

    async fn temperature_c(&mut self) -> Result<Option<f32>, Error<I2C::Error>> {
        self.inner.temperature_c().await
    }
}
