//! The BMM150: woken first, and its trimming read.

use super::driver::Driver;
use super::mode::{DelayNs, I2c, Magnetometer, both};
use super::registers::Wires;
use crate::chip::bmm150::{self as chip, Config, Trim, Trimmed};
use crate::chip::self_test::Outcome;
use ironout_sensor::{Error, Reading, Sensor};

/// The longest self-test, ms.
const PATIENCE_MS: u8 = 50;

/// A BMM150 on bus `I2C`. `D` waits for the chip to start, 3 ms at each [`Magnetometer::init`].
#[derive(Debug)]
pub struct Bmm150<I2C, D> {
    inner: Driver<I2C, Trimmed>,
    delay: D,
}

impl<I2C, D> Bmm150<I2C, D> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub fn new(i2c: I2C, delay: D, config: Config) -> Self {
        Self { inner: Driver::new(i2c, Trimmed { config, trim: Trim::default() }), delay }
    }

    /// Gives bus and delay back. The chip goes on measuring.
    pub fn destroy(self) -> (I2C, D) {
        (self.inner.destroy(), self.delay)
    }

    /// The trimming of the chip, once [`Magnetometer::init`] has read it.
    pub fn trim(&self) -> Trim {
        self.inner.config().trim
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs> Bmm150<I2C, D> {
    async fn wake(&mut self) -> Result<(), Error<I2C::Error>> {
        self.inner.registers().write(chip::POWER, chip::POWER_ON).await?;
        self.delay.delay_ms(chip::START_UP_MS).await;
        self.inner.registers().identify(chip::CHIP_ID, &[chip::IDENTITY]).await
    }

    /// The chip's normal self-test (connections, signal path and overflow of each axis), then its configuration anew.
    ///
    /// # Errors
    /// As [`Magnetometer::init`].
    pub async fn self_test(&mut self) -> Result<Outcome, Error<I2C::Error>> {
        let tested = self.tested().await;
        let restored = self.init().await;
        let outcome = tested?;
        restored?;
        Ok(outcome)
    }

    async fn tested(&mut self) -> Result<Outcome, Error<I2C::Error>> {
        self.wake().await?;
        self.inner.registers().write(chip::OPERATION, chip::SLEEP).await?;
        self.inner.registers().write(chip::OPERATION, chip::SLEEP | chip::SELF_TEST).await?;
        for _ in 0..PATIENCE_MS {
            self.delay.delay_ms(1).await;
            let [operation] = self.inner.registers().read(chip::OPERATION).await?;
            if operation & chip::SELF_TEST == 0 {
                let [x, _, y, _, z] = self.inner.registers().read(chip::DATA_X_L).await?;
                let flags = [x, y, z].map(|byte| byte & 1);
                return Ok(Outcome::of(flags.map(i32::from), flags.map(|flag| flag == 1)));
            }
        }
        Ok(Outcome::NoData)
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs> Magnetometer for Bmm150<I2C, D> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        self.inner.describe()
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        self.wake().await?;
        let trim = Trim::of(self.inner.registers().read(chip::TRIM).await?);
        if !trim.is_there() {
            return Err(Error::InvalidConfig(
                "BMM150: the chip holds no trimming to compensate with: replace it",
            ));
        }
        self.inner.config.trim = trim;
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
