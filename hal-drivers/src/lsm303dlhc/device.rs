//! The driver itself: what goes over the bus.

use embedded_hal::i2c::I2c;

use super::register::{self as reg, ADDRESS};
use super::types::Config;
use crate::error::Error;
use crate::magnetometer::{Magnetometer, Reading};

/// The magnetic half of an LSM303DLHC on bus `I2C`.
#[derive(Debug)]
pub struct Lsm303dlhc<I2C> {
    i2c: I2C,
    config: Config,
}

impl<I2C: I2c> Lsm303dlhc<I2C> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub const fn new(i2c: I2C, config: Config) -> Self {
        Self { i2c, config }
    }

    /// Gives the bus back. The chip goes on converting.
    pub fn destroy(self) -> I2C {
        self.i2c
    }

    /// The configuration in use.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Writes another configuration to the chip.
    ///
    /// # Errors
    /// As [`Magnetometer::init`]; the new configuration stays the one to be written by the next `init`.
    pub fn reconfigure(&mut self, config: Config) -> Result<(), Error<I2C::Error>> {
        self.config = config;
        self.init()
    }

    fn read_registers<const N: usize>(&mut self, first: u8) -> Result<[u8; N], Error<I2C::Error>> {
        let mut bytes = [0; N];
        self.i2c.write_read(ADDRESS, &[first], &mut bytes)?;
        Ok(bytes)
    }
}

impl<I2C: I2c> Magnetometer for Lsm303dlhc<I2C> {
    type BusError = I2C::Error;

    fn name(&self) -> &'static str {
        "LSM303DLHC"
    }

    fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        let found = self.read_registers(reg::IRA)?;
        if found != reg::IDENTITY {
            return Err(Error::NotFound { expected: reg::IDENTITY, found });
        }
        let wanted = [self.config.cra(), self.config.range.crb(), reg::MR_CONTINUOUS];
        let registers = [reg::CRA, reg::CRB, reg::MR];
        // One register a transaction: not every model of the chip increments its pointer on writing.
        for (register, byte) in registers.into_iter().zip(wanted) {
            self.i2c.write(ADDRESS, &[register, byte])?;
        }
        let kept: [u8; 3] = self.read_registers(reg::CRA)?;
        for ((register, written), read) in registers.into_iter().zip(wanted).zip(kept) {
            if written != read {
                return Err(Error::NotKept { register, written, read });
            }
        }
        Ok(())
    }

    fn ut_per_count(&self) -> [f32; 3] {
        self.config.range.ut_per_count()
    }

    fn full_scale_counts(&self) -> u16 {
        reg::FULL_SCALE
    }

    fn rate_hz(&self) -> f32 {
        self.config.rate.hz()
    }

    fn data_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        let [status] = self.read_registers(reg::SR)?;
        Ok(status & reg::SR_DRDY != 0)
    }

    fn read(&mut self) -> Result<Reading, Error<I2C::Error>> {
        let [xh, xl, zh, zl, yh, yl] = self.read_registers(reg::OUT_X_H)?;
        let counts = [[xh, xl], [yh, yl], [zh, zl]].map(i16::from_be_bytes);
        // The chip says −4096; any other value beyond 12 bits was flipped on the bus and is no measurement either.
        Ok(Reading { counts, overflow: counts.map(|axis| !reg::VALID.contains(&axis)) })
    }

    fn temperature_c(&mut self) -> Result<Option<f32>, Error<I2C::Error>> {
        if !self.config.temperature {
            return Ok(None);
        }
        // One register a transaction: behind the outputs the address pointer does not go on to the next one
        // (it goes to 0). So the two bytes may be of two measurements: where the high one changed meanwhile, the
        // low one is read again.
        let [before] = self.read_registers(reg::TEMP_OUT_H)?;
        let [mut low] = self.read_registers(reg::TEMP_OUT_L)?;
        let [high] = self.read_registers(reg::TEMP_OUT_H)?;
        if high != before {
            [low] = self.read_registers(reg::TEMP_OUT_L)?;
        }
        Ok(Some(self.config.temperature_format.celsius([high, low])))
    }
}
