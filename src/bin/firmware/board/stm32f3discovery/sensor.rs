//! The LSM303 of the board, whichever of the two it is.

use embedded_hal::i2c::{ErrorKind, I2c};
use ironout::sensor::{Error, Magnetometer, Reading, Sensor};
use ironout_drivers::lis2mdl::{self, Lis2mdl};
use ironout_drivers::lsm303_accelerometer::{Config, Lsm303Accelerometer, Model};
use ironout_drivers::lsm303dlhc::{self, Lsm303dlhc};

/// How the older chip is set up: the Earth's field with the magnets of a board, at the rate of the accelerometer or so.
const DLHC: lsm303dlhc::Config = lsm303dlhc::Config {
    range: lsm303dlhc::Range::Gauss1_9,
    rate: lsm303dlhc::DataRate::Hz75,
    temperature: true,
    temperature_format: lsm303dlhc::TemperatureFormat::LeftJustified,
};

/// The magnetic half: both have the same address and another identity, so that each start tries the one that was there last.
pub struct Lsm303<I2C> {
    agr: Lis2mdl<I2C>,
    dlhc: Lsm303dlhc<I2C>,
    is_agr: bool,
}

impl<I2C: I2c<Error = ErrorKind> + Clone> Lsm303<I2C> {
    pub(super) fn new(bus: I2C) -> Self {
        Self {
            agr: Lis2mdl::new(bus.clone(), lis2mdl::Config::of(lis2mdl::Model::Lsm303agr)),
            dlhc: Lsm303dlhc::new(bus, DLHC),
            is_agr: true,
        }
    }
}

impl<I2C: I2c<Error = ErrorKind>> Magnetometer for Lsm303<I2C> {
    type BusError = ErrorKind;

    fn describe(&self) -> Sensor {
        if self.is_agr { self.agr.describe() } else { self.dlhc.describe() }
    }

    fn init(&mut self) -> Result<(), Error<ErrorKind>> {
        for is_agr in [self.is_agr, !self.is_agr] {
            let started = if is_agr { self.agr.init() } else { self.dlhc.init() };
            if started.is_ok() {
                self.is_agr = is_agr;
                return started;
            }
        }
        // What is said is said of the one that was there.
        if self.is_agr { self.agr.init() } else { self.dlhc.init() }
    }

    fn data_ready(&mut self) -> Result<bool, Error<ErrorKind>> {
        if self.is_agr { self.agr.data_ready() } else { self.dlhc.data_ready() }
    }

    fn read(&mut self) -> Result<Reading, Error<ErrorKind>> {
        if self.is_agr { self.agr.read() } else { self.dlhc.read() }
    }

    fn temperature_c(&mut self) -> Result<Option<f32>, Error<ErrorKind>> {
        if self.is_agr { self.agr.temperature_c() } else { self.dlhc.temperature_c() }
    }
}

/// The accelerometer half: one has an identity, the other has none.
pub struct Accelerometer<I2C> {
    agr: Lsm303Accelerometer<I2C>,
    dlhc: Lsm303Accelerometer<I2C>,
    is_agr: bool,
}

impl<I2C: I2c<Error = ErrorKind> + Clone> Accelerometer<I2C> {
    pub(super) fn new(bus: I2C) -> Self {
        let of = |bus, model| Lsm303Accelerometer::new(bus, Config { model, ..Config::default() });
        Self { agr: of(bus.clone(), Model::Lsm303agr), dlhc: of(bus, Model::Lsm303dlhc), is_agr: false }
    }
}

impl<I2C: I2c<Error = ErrorKind>> ironout_drivers::Accelerometer for Accelerometer<I2C> {
    type BusError = ErrorKind;

    fn init(&mut self) -> Result<(), Error<ErrorKind>> {
        self.is_agr = self.agr.init().is_ok();
        if self.is_agr { Ok(()) } else { self.dlhc.init() }
    }

    fn read_mps2(&mut self) -> Result<Option<[f32; 3]>, Error<ErrorKind>> {
        if self.is_agr { self.agr.read_mps2() } else { self.dlhc.read_mps2() }
    }
}
