//! The MMC5983MA: continuous measurements, interrupted to measure the chip's own offset and temperature.

use super::mode::{I2c, Magnetometer, both};
use super::registers::{Registers, Wires};
use crate::chip::mmc5983ma::{self as chip, Config, Raw};
use ironout_sensor::{Error, Reading, Sensor};

/// What the chip was told last.
#[derive(Debug, Clone, Copy)]
enum Step {
    /// Nothing: the offset is due.
    Due,
    /// To measure its temperature.
    Temperature,
    /// To measure after SET.
    Set,
    /// To measure after RESET.
    Reset(Raw),
    /// To measure after SET again.
    SetAgain(Raw, Raw),
    /// To measure continuously.
    Running,
}

/// An MMC5983MA on bus `I2C`. Its own offset is measured by the calls of [`Magnetometer::data_ready`], without waiting: the first
/// data are there some four measurements after [`Magnetometer::init`].
#[derive(Debug)]
pub struct Mmc5983ma<I2C> {
    i2c: I2C,
    config: Config,
    step: Step,
    /// Counts of the chip.
    offset: [i32; 3],
    temperature_c: Option<f32>,
    /// Measurements since the offset was measured.
    since: u16,
}

impl<I2C> Mmc5983ma<I2C> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub const fn new(i2c: I2C, config: Config) -> Self {
        Self { i2c, config, step: Step::Due, offset: [0; 3], temperature_c: None, since: 0 }
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> I2C {
        self.i2c
    }

    /// The configuration in use.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The chip's own offset that is taken out of each reading, µT along its axes.
    pub fn bridge_offset_ut(&self) -> [f32; 3] {
        self.offset.map(|counts| counts as f32 * 100.0 / chip::COUNTS_PER_GAUSS)
    }

    fn registers(&mut self) -> Registers<&mut I2C> {
        Registers { i2c: &mut self.i2c, address: chip::ADDRESS, increment: 0 }
    }
}

#[both(AFIT)]
impl<I2C: I2c> Mmc5983ma<I2C> {
    /// Writes another configuration to the chip.
    ///
    /// # Errors
    /// As [`Magnetometer::init`].
    pub async fn reconfigure(&mut self, config: Config) -> Result<(), Error<I2C::Error>> {
        self.config = config;
        self.init().await
    }

    async fn raw(&mut self) -> Result<Raw, Error<I2C::Error>> {
        let bytes = self.registers().read(chip::OUT_X_0).await?;
        // The flag does not fall by reading in every mode of the chip.
        self.registers().write(chip::STATUS, chip::MEAS_M_DONE).await?;
        Ok(Raw::of(bytes))
    }

    async fn control(&mut self, byte: u8) -> Result<(), Error<I2C::Error>> {
        Ok(self.registers().write(chip::CONTROL_0, byte).await?)
    }

    /// Goes on where the chip has done what it was told, `done` by its status; `true` where a measurement for the
    /// application waits. After an error it is due from the start.
    async fn go_on(&mut self, done: u8) -> Result<bool, Error<I2C::Error>> {
        let step = core::mem::replace(&mut self.step, Step::Due);
        let measured = done & chip::MEAS_M_DONE != 0;
        self.step = match step {
            Step::Due => {
                self.registers().write(chip::CONTROL_2, 0).await?;
                self.registers().write(chip::STATUS, chip::MEAS_M_DONE | chip::MEAS_T_DONE).await?;
                self.control(chip::TM_T).await?;
                Step::Temperature
            }
            Step::Temperature if done & chip::MEAS_T_DONE != 0 => {
                let [byte] = self.registers().read(chip::T_OUT).await?;
                self.temperature_c = Some(chip::celsius(byte));
                self.control(chip::SET).await?;
                self.control(chip::TM_M).await?;
                Step::Set
            }
            Step::Set if measured => {
                let raw = self.raw().await?;
                self.control(chip::RESET).await?;
                self.control(chip::TM_M).await?;
                Step::Reset(raw)
            }
            Step::Reset(set) if measured => {
                let raw = self.raw().await?;
                self.control(chip::SET).await?;
                self.control(chip::TM_M).await?;
                Step::SetAgain(set, raw)
            }
            Step::SetAgain(set, reset) if measured => {
                let again = self.raw().await?;
                self.offset = chip::bridge_offset(set, reset, again, self.offset);
                self.since = 0;
                let continuous = self.config.rate.continuous();
                self.registers().write(chip::CONTROL_2, continuous).await?;
                Step::Running
            }
            other => other,
        };
        Ok(measured && matches!(step, Step::Running))
    }
}

#[both(AFIT)]
impl<I2C: I2c> Magnetometer for Mmc5983ma<I2C> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        self.config.sensor()
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        self.config.check().map_err(Error::InvalidConfig)?;
        self.step = Step::Due;
        self.registers().identify(chip::PRODUCT_ID, &[chip::IDENTITY]).await?;
        // They cannot be read back: that the chip measures at all is what shows that they arrived.
        let bandwidth = self.config.rate.bandwidth();
        self.registers().write(chip::CONTROL_1, bandwidth).await?;
        self.registers().write(chip::CONTROL_3, 0).await?;
        self.go_on(0).await?;
        Ok(())
    }

    async fn data_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        let [status] = self.registers().read(chip::STATUS).await?;
        self.go_on(status).await
    }

    async fn read(&mut self) -> Result<Reading, Error<I2C::Error>> {
        let raw = self.raw().await?;
        self.since = self.since.saturating_add(1);
        let due = self.config.refresh_every != 0 && self.since >= self.config.refresh_every;
        if due && matches!(self.step, Step::Running) {
            self.step = Step::Due;
        }
        Ok(self.config.reading(raw, self.offset))
    }

    /// As it was when the offset was measured last.
    async fn temperature_c(&mut self) -> Result<Option<f32>, Error<I2C::Error>> {
        Ok(self.temperature_c)
    }
}
