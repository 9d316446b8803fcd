//! MEMSIC's chips: continuous measurements, interrupted to measure the chip's own offset and temperature.

use super::mode::{DelayNs, I2c, Magnetometer, both};
use super::registers::{Registers, Wires};
use crate::chip::description::Write;
use crate::chip::set_reset::{self as chip, Raw, SetReset};
use crate::chip::{mmc5603, mmc5983ma};
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

/// A chip of MEMSIC's on bus `I2C`, configured as `C`. Its own offset is measured by the calls of [`Magnetometer::data_ready`]: the
/// first data are there some four measurements after [`Magnetometer::init`]. `D` waits where a chip needs time after SET and RESET.
#[derive(Debug)]
pub struct Memsic<I2C, D, C> {
    i2c: I2C,
    delay: D,
    config: C,
    step: Step,
    /// Counts of the chip.
    offset: [i32; 3],
    temperature_c: Option<f32>,
    /// Measurements since the offset was measured.
    since: u16,
}

/// An MMC5983MA on bus `I2C`. It needs no time after SET and RESET.
pub type Mmc5983ma<I2C> = Memsic<I2C, NoDelay, mmc5983ma::Config>;

/// An MMC5603 on bus `I2C`. `D` waits 1 ms after SET and RESET, three times for each offset.
pub type Mmc5603<I2C, D> = Memsic<I2C, D, mmc5603::Config>;

/// Waits for nothing.
#[derive(Debug, Clone, Copy)]
pub struct NoDelay;

#[both(AFIT)]
impl DelayNs for NoDelay {
    async fn delay_ns(&mut self, _ns: u32) {}
}

impl<I2C> Mmc5983ma<I2C> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub const fn new(i2c: I2C, config: mmc5983ma::Config) -> Self {
        Self::with(i2c, NoDelay, config)
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> I2C {
        self.i2c
    }
}

impl<I2C, D> Mmc5603<I2C, D> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub const fn new(i2c: I2C, delay: D, config: mmc5603::Config) -> Self {
        Self::with(i2c, delay, config)
    }

    /// Gives bus and delay back. The chip goes on measuring.
    pub fn destroy(self) -> (I2C, D) {
        (self.i2c, self.delay)
    }
}

impl<I2C, D, C> Memsic<I2C, D, C> {
    const fn with(i2c: I2C, delay: D, config: C) -> Self {
        Self { i2c, delay, config, step: Step::Due, offset: [0; 3], temperature_c: None, since: 0 }
    }

    /// The configuration in use.
    pub const fn config(&self) -> &C {
        &self.config
    }
}

impl<I2C, D, C: SetReset> Memsic<I2C, D, C> {
    /// The chip's own offset that is taken out of each reading, µT along its axes.
    pub fn bridge_offset_ut(&self) -> [f32; 3] {
        self.offset.map(|counts| counts as f32 * 100.0 / C::COUNTS_PER_GAUSS)
    }

    fn registers(&mut self) -> Registers<&mut I2C> {
        Registers { i2c: &mut self.i2c, address: C::ADDRESS, increment: 0, dummies: 0 }
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs, C: SetReset> Memsic<I2C, D, C> {
    /// Writes another configuration to the chip.
    ///
    /// # Errors
    /// As [`Magnetometer::init`].
    pub async fn reconfigure(&mut self, config: C) -> Result<(), Error<I2C::Error>> {
        self.config = config;
        self.init().await
    }

    async fn raw(&mut self) -> Result<Raw, Error<I2C::Error>> {
        let mut output = C::Output::default();
        self.registers().read_into(C::OUTPUT, output.as_mut()).await?;
        // The flag does not fall by reading in every mode of the chip.
        self.registers().write(C::STATUS, C::FIELD_DONE).await?;
        Ok(self.config.raw(&output))
    }

    async fn control(&mut self, byte: u8) -> Result<(), Error<I2C::Error>> {
        Ok(self.registers().write(C::CONTROL, byte).await?)
    }

    async fn write(&mut self, writes: &[Write]) -> Result<(), Error<I2C::Error>> {
        for write in writes {
            self.registers().write(write.register, write.byte).await?;
        }
        Ok(())
    }

    /// SET or RESET, and the measurement after it.
    async fn pulse(&mut self, which: u8) -> Result<(), Error<I2C::Error>> {
        self.control(which).await?;
        if C::PULSE_MS > 0 {
            self.delay.delay_ms(C::PULSE_MS).await;
        }
        self.control(chip::TM_M).await
    }

    /// Goes on where the chip has done what it was told, `done` by its status; `true` where a measurement for the
    /// application waits. After an error it is due from the start.
    async fn go_on(&mut self, done: u8) -> Result<bool, Error<I2C::Error>> {
        let step = core::mem::replace(&mut self.step, Step::Due);
        let measured = done & C::FIELD_DONE != 0;
        self.step = match step {
            Step::Due => {
                self.write(&[C::STOP]).await?;
                self.registers().write(C::STATUS, C::FIELD_DONE | C::TEMPERATURE_DONE).await?;
                self.control(chip::TM_T).await?;
                Step::Temperature
            }
            Step::Temperature if done & C::TEMPERATURE_DONE != 0 => {
                let [byte] = self.registers().read(C::TEMPERATURE).await?;
                self.temperature_c = Some(chip::celsius(byte));
                self.pulse(chip::SET).await?;
                Step::Set
            }
            Step::Set if measured => {
                let raw = self.raw().await?;
                self.pulse(chip::RESET).await?;
                Step::Reset(raw)
            }
            Step::Reset(set) if measured => {
                let raw = self.raw().await?;
                self.pulse(chip::SET).await?;
                Step::SetAgain(set, raw)
            }
            Step::SetAgain(set, reset) if measured => {
                let again = self.raw().await?;
                self.offset = chip::bridge_offset(set, reset, again, self.offset);
                self.since = 0;
                let start = self.config.start();
                self.write(start.as_ref()).await?;
                Step::Running
            }
            other => other,
        };
        Ok(measured && matches!(step, Step::Running))
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs, C: SetReset> Magnetometer for Memsic<I2C, D, C> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        self.config.sensor()
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        self.config.check().map_err(Error::InvalidConfig)?;
        self.step = Step::Due;
        let identity = C::IDENTITY;
        self.registers().identify(identity.register, identity.bytes).await?;
        // They cannot be read back: that the chip measures at all is what shows that they arrived.
        let writes = self.config.writes();
        self.write(writes.as_ref()).await?;
        self.go_on(0).await?;
        Ok(())
    }

    async fn data_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        let [status] = self.registers().read(C::STATUS).await?;
        self.go_on(status).await
    }

    async fn read(&mut self) -> Result<Reading, Error<I2C::Error>> {
        let raw = self.raw().await?;
        self.since = self.since.saturating_add(1);
        let every = self.config.refresh_every();
        let due = every != 0 && self.since >= every;
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
