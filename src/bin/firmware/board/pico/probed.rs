//! The magnetometer on the Pico's bus, whichever it is.

use super::bus::Bus;
use super::time::now_us;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::ErrorKind;
use ironout::sensor::{Error, Magnetometer, Reading, Sensor};
use ironout_drivers::{AnyMagnetometer, Kind, probe};

/// The sensor as long as none was found: whatever it will be, it is described anew then.
const UNKNOWN: Sensor = Sensor::uniform("magnetometer", 0.15, 100.0);

/// Waits by counting: a chip's start asks for some milliseconds at most.
pub struct Wait;

impl DelayNs for Wait {
    fn delay_ns(&mut self, ns: u32) {
        let end_us = now_us() + u64::from(ns.div_ceil(1000));
        while now_us() < end_us {}
    }
}

/// The bus with the chip that was found on it, if one was.
enum Chip {
    Unknown(Bus),
    Found(AnyMagnetometer<Bus, Wait>),
}

/// A magnetometer that is looked for at each start that is in vain.
pub struct Probed {
    /// Taken out only while it is exchanged.
    chip: Option<Chip>,
}

impl Probed {
    pub(super) const fn new(bus: Bus) -> Self {
        Self { chip: Some(Chip::Unknown(bus)) }
    }

    fn found(&mut self) -> Result<&mut AnyMagnetometer<Bus, Wait>, Error<ErrorKind>> {
        match &mut self.chip {
            Some(Chip::Found(driver)) => Ok(driver),
            _ => Err(Error::Bus(ErrorKind::Other)),
        }
    }
}

impl Magnetometer for Probed {
    type BusError = ErrorKind;

    fn describe(&self) -> Sensor {
        match &self.chip {
            Some(Chip::Found(driver)) => driver.describe(),
            _ => UNKNOWN,
        }
    }

    /// Starts the chip that was found before; where that fails, or none was found yet, the bus is looked through anew.
    fn init(&mut self) -> Result<(), Error<ErrorKind>> {
        let mut bus = match self.chip.take() {
            Some(Chip::Found(mut driver)) => {
                if driver.init().is_ok() {
                    self.chip = Some(Chip::Found(driver));
                    return Ok(());
                }
                driver.destroy()
            }
            Some(Chip::Unknown(bus)) => bus,
            None => return Err(Error::Bus(ErrorKind::Other)),
        };
        let findings = probe(&mut bus, &mut Wait);
        // An ICM-20948 with its bypass open is found as the AK09916 behind it as well; whoever closes it is the first of the two.
        let icm20948 = findings.iter().find(|found| found.kind == Kind::Icm20948);
        let Some(found) = icm20948.or(findings.first()) else {
            self.chip = Some(Chip::Unknown(bus));
            return Err(Error::Bus(findings.trouble.unwrap_or(ErrorKind::Other)));
        };
        let mut driver = AnyMagnetometer::new(bus, Wait, found);
        let done = driver.init();
        self.chip = Some(if done.is_ok() { Chip::Found(driver) } else { Chip::Unknown(driver.destroy()) });
        done
    }

    fn data_ready(&mut self) -> Result<bool, Error<ErrorKind>> {
        self.found()?.data_ready()
    }

    fn read(&mut self) -> Result<Reading, Error<ErrorKind>> {
        self.found()?.read()
    }

    fn temperature_c(&mut self) -> Result<Option<f32>, Error<ErrorKind>> {
        self.found()?.temperature_c()
    }
}
