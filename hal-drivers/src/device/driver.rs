//! The driver of every chip that is a register map: what goes over the bus, and in which order.

use super::mode::{DelayNs, I2c, Magnetometer, both};
use super::registers::{Registers, Wires};
use crate::chip::description::{Chip, Thermometer};
use crate::chip::self_test::{Good, Outcome, SelfTest};
use ironout_sensor::{Error, Reading, Sensor};

/// A chip on bus `I2C`, configured as `C`.
#[derive(Debug)]
pub struct Driver<I2C, C> {
    pub(super) i2c: I2C,
    pub(super) config: C,
    /// Measurements to drop: they may be of the configuration before.
    settling: u8,
    /// For a chip that measures when told: it was, and has not been read since.
    triggered: bool,
}

impl<I2C, C> Driver<I2C, C> {
    /// Takes the bus; nothing is sent before [`Magnetometer::init`].
    pub const fn new(i2c: I2C, config: C) -> Self {
        Self { i2c, config, settling: 0, triggered: false }
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> I2C {
        self.i2c
    }

    /// The configuration in use.
    pub const fn config(&self) -> &C {
        &self.config
    }
}

impl<I2C, C: Chip> Driver<I2C, C> {
    /// The chip's registers, for as long as one operation takes.
    pub(super) fn registers(&mut self) -> Registers<&mut I2C> {
        Registers {
            address: self.config.address(),
            increment: C::INCREMENT,
            dummies: C::DUMMIES,
            i2c: &mut self.i2c,
        }
    }
}

#[both(AFIT)]
impl<I2C: I2c, C: Chip> Driver<I2C, C> {
    /// Writes another configuration to the chip.
    ///
    /// # Errors
    /// As [`Magnetometer::init`]; the new configuration stays the one to be written by the next `init`.
    pub async fn reconfigure(&mut self, config: C) -> Result<(), Error<I2C::Error>> {
        self.config = config;
        self.init().await
    }

    /// Whether the chip says that a measurement waits.
    async fn waits(&mut self) -> Result<bool, Error<I2C::Error>> {
        self.trigger().await?;
        let (register, bit) = C::STATUS;
        let [status] = self.registers().read(register).await?;
        Ok(status & bit != 0)
    }

    /// Tells a chip to measure that wants to be told.
    async fn trigger(&mut self) -> Result<(), Error<I2C::Error>> {
        if let (Some(write), false) = (C::TRIGGER, self.triggered) {
            self.registers().write(write.register, write.byte).await?;
            self.triggered = true;
        }
        Ok(())
    }

    /// The mean of `samples` measurements, in counts of the chip's carried counts; `None` where one is not there in time.
    async fn mean<D: DelayNs>(
        &mut self,
        delay: &mut D,
        samples: u8,
        patience_ms: u32,
    ) -> Result<Option<[i32; 3]>, Error<I2C::Error>> {
        let mut sums = [0_i32; 3];
        for _ in 0..samples.max(1) {
            let mut waited_ms = 0;
            while !self.waits().await? {
                if waited_ms >= patience_ms {
                    return Ok(None);
                }
                delay.delay_ms(1).await;
                waited_ms += 1;
            }
            let reading = Magnetometer::read(self).await?;
            for (sum, count) in sums.iter_mut().zip(reading.counts) {
                *sum += i32::from(count);
            }
        }
        Ok(Some(sums.map(|sum| sum / i32::from(samples.max(1)))))
    }
}

#[both(AFIT)]
impl<I2C: I2c, C: SelfTest> Driver<I2C, C> {
    /// Lets the chip test itself, as its datasheet says, and configures it anew. Takes up to a second; the board has to lie
    /// still, and the field must leave room for the test's own.
    ///
    /// # Errors
    /// [`Error::Bus`] and, from the configuration before and after, those of [`Magnetometer::init`].
    pub async fn self_test<D: DelayNs>(&mut self, delay: &mut D) -> Result<Outcome, Error<I2C::Error>> {
        let tested = self.tested(delay).await;
        // Also after an error: a chip left in its test would measure the test's field.
        let restored = self.init().await;
        let outcome = tested?;
        restored?;
        Ok(outcome)
    }

    async fn tested<D: DelayNs>(&mut self, delay: &mut D) -> Result<Outcome, Error<I2C::Error>> {
        let identity = C::IDENTITY;
        self.registers().identify(identity.register, identity.bytes).await?;
        let plan = self.config.plan();
        self.registers().configure(plan.before.as_ref()).await?;
        self.triggered = false;
        let level = matches!(plan.good, Good::Level(_));
        let mut without = [0; 3];
        if !level {
            delay.delay_ms(plan.settling_ms).await;
            if self.mean(delay, 1, plan.patience_ms).await?.is_none() {
                return Ok(Outcome::NoData);
            }
            let Some(mean) = self.mean(delay, plan.samples, plan.patience_ms).await? else {
                return Ok(Outcome::NoData);
            };
            without = mean;
        }
        self.registers().write(plan.start.register, plan.start.byte).await?;
        // A test that is a measurement of its own was triggered by its start.
        self.triggered = level;
        delay.delay_ms(plan.settling_ms).await;
        if !level && self.mean(delay, 1, plan.patience_ms).await?.is_none() {
            return Ok(Outcome::NoData);
        }
        let with = self.mean(delay, plan.samples, plan.patience_ms).await?;
        Ok(with.map_or(Outcome::NoData, |with| plan.good.judge(without, with)))
    }
}

#[both(AFIT)]
impl<I2C: I2c, C: Chip> Magnetometer for Driver<I2C, C> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        self.config.sensor()
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        self.config.check().map_err(Error::InvalidConfig)?;
        let identity = C::IDENTITY;
        self.registers().identify(identity.register, identity.bytes).await?;
        self.settling = C::DROPPED;
        self.triggered = false;
        let writes = self.config.writes();
        self.registers().configure(writes.as_ref()).await?;
        self.trigger().await
    }

    async fn data_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        let ready = self.waits().await?;
        if ready && self.settling > 0 {
            // Reading it is what lets the flag fall.
            Magnetometer::read(self).await?;
            self.settling -= 1;
            return Ok(false);
        }
        Ok(ready)
    }

    async fn read(&mut self) -> Result<Reading, Error<I2C::Error>> {
        let mut output = C::Output::default();
        // Also a reading that fails may have taken the measurement.
        self.triggered = false;
        self.registers().read_into(C::OUTPUT, output.as_mut()).await?;
        if let Some((register, written, read)) = self.config.lost(&output) {
            return Err(Error::NotKept { register, written, read });
        }
        self.trigger().await?;
        Ok(self.config.decode(&output))
    }

    async fn temperature_c(&mut self) -> Result<Option<f32>, Error<I2C::Error>> {
        let bytes = match self.config.thermometer() {
            Thermometer::None => return Ok(None),
            Thermometer::Burst(first) => self.registers().read(first).await?,
            Thermometer::Split { high, low } => {
                // The two bytes may be of two measurements: where the high one changed meanwhile, the low one is read again.
                let [before] = self.registers().read(high).await?;
                let [mut second] = self.registers().read(low).await?;
                let [first] = self.registers().read(high).await?;
                if first != before {
                    [second] = self.registers().read(low).await?;
                }
                [first, second]
            }
        };
        Ok(Some(self.config.celsius(bytes)))
    }
}
