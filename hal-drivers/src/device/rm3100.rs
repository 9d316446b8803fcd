//! The RM3100's self-test, which is not like those of others.

use super::driver::Driver;
use super::mode::{DelayNs, I2c, Magnetometer, both};
use super::registers::Wires;
use crate::chip::rm3100::{self as chip, Config};
use crate::chip::self_test::Outcome;
use ironout_sensor::Error;

/// The longest self-test, ms.
const PATIENCE_MS: u8 = 100;

#[both(AFIT)]
impl<I2C: I2c> Driver<I2C, Config> {
    /// Lets the chip test its three oscillators (BIST), and configures it anew.
    ///
    /// # Errors
    /// As [`Magnetometer::init`].
    pub async fn self_test<D: DelayNs>(&mut self, delay: &mut D) -> Result<Outcome, Error<I2C::Error>> {
        let tested = self.tested(delay).await;
        // Off again, also after an error.
        let off = self.registers().write(chip::BIST, 0).await;
        let restored = self.init().await;
        let outcome = tested?;
        off?;
        restored?;
        Ok(outcome)
    }

    async fn tested<D: DelayNs>(&mut self, delay: &mut D) -> Result<Outcome, Error<I2C::Error>> {
        self.registers().identify(chip::REVID, &[chip::IDENTITY]).await?;
        self.registers().write(chip::CMM, 0).await?;
        self.registers().write(chip::BIST, chip::BIST_START).await?;
        self.registers().write(chip::POLL, chip::POLL_ALL).await?;
        for _ in 0..PATIENCE_MS {
            delay.delay_ms(1).await;
            let [status] = self.registers().read(chip::STATUS).await?;
            if status & chip::DRDY != 0 {
                let [bist] = self.registers().read(chip::BIST).await?;
                let flags = [bist >> 4, bist >> 5, bist >> 6].map(|bits| bits & 1);
                return Ok(Outcome::of(flags.map(i32::from), flags.map(|flag| flag == 1)));
            }
        }
        Ok(Outcome::NoData)
    }
}
