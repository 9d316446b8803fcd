//! The accelerometer half of an LSM303.

use super::mode::{Accelerometer, I2c, both};
use super::registers::{Registers, Wires};
use crate::chip::lsm303_accelerometer::{self as chip, Config, Model};
use ironout_sensor::Error;

/// The accelerometer half of an LSM303DLHC or LSM303AGR on bus `I2C`.
#[derive(Debug)]
pub struct Lsm303Accelerometer<I2C> {
    i2c: I2C,
    config: Config,
}

impl<I2C> Lsm303Accelerometer<I2C> {
    /// Takes the bus; nothing is sent before [`Accelerometer::init`].
    pub const fn new(i2c: I2C, config: Config) -> Self {
        Self { i2c, config }
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> I2C {
        self.i2c
    }

    fn registers(&mut self) -> Registers<&mut I2C> {
        Registers { i2c: &mut self.i2c, address: chip::ADDRESS, increment: chip::INCREMENT, dummies: 0 }
    }
}

#[both(AFIT)]
impl<I2C: I2c> Accelerometer for Lsm303Accelerometer<I2C> {
    type BusError = I2C::Error;

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        if self.config.model == Model::Lsm303agr {
            self.registers().identify(chip::WHO_AM_I, &[chip::IDENTITY]).await?;
        }
        let writes = self.config.writes();
        self.registers().configure(&writes).await
    }

    async fn read_mps2(&mut self) -> Result<Option<[f32; 3]>, Error<I2C::Error>> {
        let bytes = self.registers().read(chip::OUT_X_L).await?;
        Ok(self.config.mps2(bytes))
    }
}
