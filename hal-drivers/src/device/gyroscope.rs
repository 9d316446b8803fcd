//! The gyroscopes L3GD20, L3GD20H and I3G4250D, on SPI or I²C.

use super::mode::{Gyroscope, I2c, SpiDevice, both};
use super::registers::{Registers, SpiRegisters, Wires};
use crate::chip::l3gd20::{self as chip, Config, Model};
use ironout_sensor::Error;

/// An L3GD20, L3GD20H or I3G4250D on wires `W`: [`Self::new_spi`] or [`Self::new_i2c`].
#[derive(Debug)]
pub struct L3gd20<W> {
    wires: W,
    config: Config,
    model: Option<Model>,
}

impl<SPI: SpiDevice> L3gd20<SpiRegisters<SPI>> {
    /// Takes the chip on its SPI bus (mode 0 or 3, 10 MHz at most); nothing is sent before [`Gyroscope::init`].
    pub const fn new_spi(spi: SPI, config: Config) -> Self {
        Self { wires: SpiRegisters { spi }, config, model: None }
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> SPI {
        self.wires.spi
    }
}

impl<I2C: I2c> L3gd20<Registers<I2C>> {
    /// Takes the bus, with one of [`ADDRESSES`](chip::ADDRESSES); nothing is sent before [`Gyroscope::init`].
    pub const fn new_i2c(i2c: I2C, address: u8, config: Config) -> Self {
        let wires = Registers { i2c, address, increment: chip::INCREMENT, dummies: 0 };
        Self { wires, config, model: None }
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> I2C {
        self.wires.i2c
    }
}

impl<W> L3gd20<W> {
    /// Which of the chips [`Gyroscope::init`] found.
    pub const fn model(&self) -> Option<Model> {
        self.model
    }
}

#[both(AFIT)]
impl<W: Wires> Gyroscope for L3gd20<W> {
    type BusError = W::Error;

    async fn init(&mut self) -> Result<(), Error<W::Error>> {
        let [found] = self.wires.read(chip::WHO_AM_I).await?;
        self.model = Model::of(found);
        if self.model.is_none() {
            return Err(Error::NotFound { expected: [0xd4, 0, 0], found: [found, 0, 0] });
        }
        let writes = self.config.writes();
        self.wires.configure(&writes).await
    }

    async fn read_radps(&mut self) -> Result<Option<[f32; 3]>, Error<W::Error>> {
        let bytes = self.wires.read(chip::OUT_X_L).await?;
        Ok(self.config.radps(bytes))
    }
}
