//! The BMM350: its OTP memory read and its magnetic reset done before it measures.

use super::driver::Driver;
use super::mode::{DelayNs, I2c, Magnetometer, both};
use super::registers::Wires;
use crate::chip::bmm350::{self as chip, Config, Otp, Trimmed};
use crate::chip::description::Chip;
use ironout_sensor::{Error, Reading, Sensor};

/// How often the OTP memory is asked whether it has read a word, a millisecond apart.
const OTP_PATIENCE: u8 = 5;

/// A BMM350 on bus `I2C`. `D` waits for its resets and its start, some 100 ms at each [`Magnetometer::init`].
#[derive(Debug)]
pub struct Bmm350<I2C, D> {
    inner: Driver<I2C, Trimmed>,
    delay: D,
}

impl<I2C, D> Bmm350<I2C, D> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub fn new(i2c: I2C, delay: D, config: Config) -> Self {
        Self { inner: Driver::new(i2c, Trimmed { config, otp: Otp::default() }), delay }
    }

    /// Gives bus and delay back. The chip goes on measuring.
    pub fn destroy(self) -> (I2C, D) {
        (self.inner.destroy(), self.delay)
    }

    /// The OTP memory of the chip, once [`Magnetometer::init`] has read it.
    pub fn otp(&self) -> Otp {
        self.inner.config().otp
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs> Bmm350<I2C, D> {
    /// A word of the OTP memory.
    async fn word(&mut self, address: u8) -> Result<u16, Error<I2C::Error>> {
        let command = chip::OTP_READ | address;
        self.inner.registers().write(chip::OTP_COMMAND, command).await?;
        let mut status = 0;
        for _ in 0..OTP_PATIENCE {
            self.delay.delay_ms(1).await;
            [status] = self.inner.registers().read(chip::OTP_STATUS).await?;
            if status & (chip::OTP_DONE | chip::OTP_ERROR) != 0 {
                break;
            }
        }
        if status & (chip::OTP_DONE | chip::OTP_ERROR) != chip::OTP_DONE {
            return Err(Error::NotKept { register: chip::OTP_COMMAND, written: command, read: status });
        }
        let [high] = self.inner.registers().read(chip::OTP_HIGH).await?;
        let [low] = self.inner.registers().read(chip::OTP_LOW).await?;
        Ok(u16::from_be_bytes([high, low]))
    }

    async fn otp_memory(&mut self) -> Result<Otp, Error<I2C::Error>> {
        let mut words = [0; 10];
        for (address, word) in (chip::FIRST_WORD..).zip(words.iter_mut()) {
            *word = self.word(address).await?;
        }
        let reference = self.word(chip::REFERENCE_WORD).await?;
        self.inner.registers().write(chip::OTP_COMMAND, chip::OTP_OFF).await?;
        Ok(Otp::of(words, reference))
    }

    /// A command, its time, and whether `mask` of the status then reads `expected`.
    async fn command(
        &mut self,
        command: u8,
        ms: u32,
        (mask, expected): (u8, u8),
    ) -> Result<(), Error<I2C::Error>> {
        self.inner.registers().write(chip::COMMAND, command).await?;
        self.delay.delay_ms(ms).await;
        let [status] = self.inner.registers().read(chip::COMMAND_STATUS).await?;
        if status & mask == expected {
            Ok(())
        } else {
            Err(Error::NotKept { register: chip::COMMAND, written: command, read: status })
        }
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs> Magnetometer for Bmm350<I2C, D> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        self.inner.describe()
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        self.inner.config().check().map_err(Error::InvalidConfig)?;
        self.inner.registers().identify(chip::CHIP_ID, &[chip::IDENTITY]).await?;
        // The resets below are done suspended, which is how the chip is after this.
        self.inner.registers().write(chip::RESET, chip::RESET_NOW).await?;
        self.delay.delay_ms(chip::RESET_MS).await;
        self.inner.config.otp = self.otp_memory().await?;
        let did = |command: u8| (0xe0, command << 5);
        self.command(chip::BIT_RESET, chip::BIT_RESET_MS, did(chip::BIT_RESET)).await?;
        self.command(chip::FLUX_GUIDE_RESET, chip::FLUX_GUIDE_RESET_MS, did(chip::FLUX_GUIDE_RESET)).await?;
        self.inner.init().await?;
        self.command(chip::UPDATE, chip::UPDATE_MS, (chip::ILLEGAL, 0)).await?;
        self.command(chip::NORMAL, chip::NORMAL_MS, (chip::IS_NORMAL, chip::IS_NORMAL)).await
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
