//! Whichever magnetometer it is: what a probing found, as one type.

use super::bmm150::Bmm150;
use super::bmm350::Bmm350;
use super::driver::Driver;
use super::icm20948::Icm20948;
use super::memsic::{Mmc5603, Mmc5983ma};
use super::mode::{DelayNs, I2c, Magnetometer, both};
use crate::chip::kind::{Found, Kind};
use crate::chip::{
    ak09916, bmm150, bmm350, hmc5883l, icm20948, ist8310, lis2mdl, lis3mdl, lsm303dlhc, mmc5603, mmc5983ma,
    qmc5883l, qmc5883p, qmc6309, qmc6310, rm3100,
};
use ironout_sensor::{Error, Reading, Sensor};

/// The driver of a chip that was found on bus `I2C`, in its default configuration. `D` waits where a chip needs it.
#[derive(Debug)]
pub enum AnyMagnetometer<I2C, D> {
    /// LIS2MDL, IIS2MDC or LSM303AGR.
    Lis2mdl(Driver<I2C, lis2mdl::Config>),
    /// LIS3MDL.
    Lis3mdl(Driver<I2C, lis3mdl::Config>),
    /// LSM303DLHC.
    Lsm303dlhc(Driver<I2C, lsm303dlhc::Config>),
    /// HMC5883L.
    Hmc5883l(Driver<I2C, hmc5883l::Config>),
    /// QMC5883L.
    Qmc5883l(Driver<I2C, qmc5883l::Config>),
    /// QMC5883P.
    Qmc5883p(Driver<I2C, qmc5883p::Config>),
    /// QMC6309.
    Qmc6309(Driver<I2C, qmc6309::Config>),
    /// QMC6310.
    Qmc6310(Driver<I2C, qmc6310::Config>),
    /// MMC5603.
    Mmc5603(Mmc5603<I2C, D>),
    /// MMC5983MA.
    Mmc5983ma(Mmc5983ma<I2C>),
    /// BMM150.
    Bmm150(Bmm150<I2C, D>),
    /// BMM350.
    Bmm350(Bmm350<I2C, D>),
    /// AK09916.
    Ak09916(Driver<I2C, ak09916::Config>),
    /// ICM-20948.
    Icm20948(Icm20948<I2C>),
    /// IST8310.
    Ist8310(Driver<I2C, ist8310::Config>),
    /// RM3100.
    Rm3100(Driver<I2C, rm3100::Config>),
}

impl<I2C, D> AnyMagnetometer<I2C, D> {
    /// Takes the bus for this chip; nothing is sent before [`Magnetometer::init`].
    pub fn new(i2c: I2C, delay: D, found: Found) -> Self {
        let address = found.address;
        match found.kind {
            Kind::Lis2mdl => Self::Lis2mdl(Driver::new(i2c, lis2mdl::Config::of(lis2mdl::Model::Lis2mdl))),
            Kind::Iis2mdc => Self::Lis2mdl(Driver::new(i2c, lis2mdl::Config::of(lis2mdl::Model::Iis2mdc))),
            Kind::Lsm303agr => {
                Self::Lis2mdl(Driver::new(i2c, lis2mdl::Config::of(lis2mdl::Model::Lsm303agr)))
            }
            Kind::Lis3mdl => {
                Self::Lis3mdl(Driver::new(i2c, lis3mdl::Config { address, ..Default::default() }))
            }
            Kind::Lsm303dlhc => Self::Lsm303dlhc(Driver::new(i2c, lsm303dlhc::Config::default())),
            Kind::Hmc5883l => Self::Hmc5883l(Driver::new(i2c, hmc5883l::Config::default())),
            Kind::Qmc5883l => Self::Qmc5883l(Driver::new(i2c, qmc5883l::Config::default())),
            Kind::Qmc5883p => Self::Qmc5883p(Driver::new(i2c, qmc5883p::Config::default())),
            Kind::Qmc6309 => Self::Qmc6309(Driver::new(i2c, qmc6309::Config::default())),
            Kind::Qmc6310 => {
                Self::Qmc6310(Driver::new(i2c, qmc6310::Config { address, ..Default::default() }))
            }
            Kind::Mmc5603 => Self::Mmc5603(Mmc5603::new(i2c, delay, mmc5603::Config::default())),
            Kind::Mmc5983ma => Self::Mmc5983ma(Mmc5983ma::new(i2c, mmc5983ma::Config::default())),
            Kind::Bmm150 => {
                Self::Bmm150(Bmm150::new(i2c, delay, bmm150::Config { address, ..Default::default() }))
            }
            Kind::Bmm350 => {
                Self::Bmm350(Bmm350::new(i2c, delay, bmm350::Config { address, ..Default::default() }))
            }
            Kind::Ak09916 => Self::Ak09916(Driver::new(i2c, ak09916::Config::default())),
            Kind::Icm20948 => {
                Self::Icm20948(Icm20948::new(i2c, icm20948::Config { address, ..Default::default() }))
            }
            Kind::Ist8310 => Self::Ist8310(Driver::new(i2c, ist8310::Config { address })),
            Kind::Rm3100 => Self::Rm3100(Driver::new(i2c, rm3100::Config { address, ..Default::default() })),
        }
    }

    /// Gives the bus back. The chip goes on measuring.
    pub fn destroy(self) -> I2C {
        match self {
            Self::Lis2mdl(driver) => driver.destroy(),
            Self::Lis3mdl(driver) => driver.destroy(),
            Self::Lsm303dlhc(driver) => driver.destroy(),
            Self::Hmc5883l(driver) => driver.destroy(),
            Self::Qmc5883l(driver) => driver.destroy(),
            Self::Qmc5883p(driver) => driver.destroy(),
            Self::Qmc6309(driver) => driver.destroy(),
            Self::Qmc6310(driver) => driver.destroy(),
            Self::Mmc5603(driver) => driver.destroy().0,
            Self::Mmc5983ma(driver) => driver.destroy(),
            Self::Bmm150(driver) => driver.destroy().0,
            Self::Bmm350(driver) => driver.destroy().0,
            Self::Ak09916(driver) => driver.destroy(),
            Self::Icm20948(driver) => driver.destroy(),
            Self::Ist8310(driver) => driver.destroy(),
            Self::Rm3100(driver) => driver.destroy(),
        }
    }
}

#[both(AFIT)]
impl<I2C: I2c, D: DelayNs> Magnetometer for AnyMagnetometer<I2C, D> {
    type BusError = I2C::Error;

    fn describe(&self) -> Sensor {
        match self {
            Self::Lis2mdl(driver) => Magnetometer::describe(driver),
            Self::Lis3mdl(driver) => Magnetometer::describe(driver),
            Self::Lsm303dlhc(driver) => Magnetometer::describe(driver),
            Self::Hmc5883l(driver) => Magnetometer::describe(driver),
            Self::Qmc5883l(driver) => Magnetometer::describe(driver),
            Self::Qmc5883p(driver) => Magnetometer::describe(driver),
            Self::Qmc6309(driver) => Magnetometer::describe(driver),
            Self::Qmc6310(driver) => Magnetometer::describe(driver),
            Self::Mmc5603(driver) => Magnetometer::describe(driver),
            Self::Mmc5983ma(driver) => Magnetometer::describe(driver),
            Self::Bmm150(driver) => Magnetometer::describe(driver),
            Self::Bmm350(driver) => Magnetometer::describe(driver),
            Self::Ak09916(driver) => Magnetometer::describe(driver),
            Self::Icm20948(driver) => Magnetometer::describe(driver),
            Self::Ist8310(driver) => Magnetometer::describe(driver),
            Self::Rm3100(driver) => Magnetometer::describe(driver),
        }
    }

    async fn init(&mut self) -> Result<(), Error<I2C::Error>> {
        match self {
            Self::Lis2mdl(driver) => Magnetometer::init(driver).await,
            Self::Lis3mdl(driver) => Magnetometer::init(driver).await,
            Self::Lsm303dlhc(driver) => Magnetometer::init(driver).await,
            Self::Hmc5883l(driver) => Magnetometer::init(driver).await,
            Self::Qmc5883l(driver) => Magnetometer::init(driver).await,
            Self::Qmc5883p(driver) => Magnetometer::init(driver).await,
            Self::Qmc6309(driver) => Magnetometer::init(driver).await,
            Self::Qmc6310(driver) => Magnetometer::init(driver).await,
            Self::Mmc5603(driver) => Magnetometer::init(driver).await,
            Self::Mmc5983ma(driver) => Magnetometer::init(driver).await,
            Self::Bmm150(driver) => Magnetometer::init(driver).await,
            Self::Bmm350(driver) => Magnetometer::init(driver).await,
            Self::Ak09916(driver) => Magnetometer::init(driver).await,
            Self::Icm20948(driver) => Magnetometer::init(driver).await,
            Self::Ist8310(driver) => Magnetometer::init(driver).await,
            Self::Rm3100(driver) => Magnetometer::init(driver).await,
        }
    }

    async fn data_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        match self {
            Self::Lis2mdl(driver) => Magnetometer::data_ready(driver).await,
            Self::Lis3mdl(driver) => Magnetometer::data_ready(driver).await,
            Self::Lsm303dlhc(driver) => Magnetometer::data_ready(driver).await,
            Self::Hmc5883l(driver) => Magnetometer::data_ready(driver).await,
            Self::Qmc5883l(driver) => Magnetometer::data_ready(driver).await,
            Self::Qmc5883p(driver) => Magnetometer::data_ready(driver).await,
            Self::Qmc6309(driver) => Magnetometer::data_ready(driver).await,
            Self::Qmc6310(driver) => Magnetometer::data_ready(driver).await,
            Self::Mmc5603(driver) => Magnetometer::data_ready(driver).await,
            Self::Mmc5983ma(driver) => Magnetometer::data_ready(driver).await,
            Self::Bmm150(driver) => Magnetometer::data_ready(driver).await,
            Self::Bmm350(driver) => Magnetometer::data_ready(driver).await,
            Self::Ak09916(driver) => Magnetometer::data_ready(driver).await,
            Self::Icm20948(driver) => Magnetometer::data_ready(driver).await,
            Self::Ist8310(driver) => Magnetometer::data_ready(driver).await,
            Self::Rm3100(driver) => Magnetometer::data_ready(driver).await,
        }
    }

    async fn read(&mut self) -> Result<Reading, Error<I2C::Error>> {
        match self {
            Self::Lis2mdl(driver) => Magnetometer::read(driver).await,
            Self::Lis3mdl(driver) => Magnetometer::read(driver).await,
            Self::Lsm303dlhc(driver) => Magnetometer::read(driver).await,
            Self::Hmc5883l(driver) => Magnetometer::read(driver).await,
            Self::Qmc5883l(driver) => Magnetometer::read(driver).await,
            Self::Qmc5883p(driver) => Magnetometer::read(driver).await,
            Self::Qmc6309(driver) => Magnetometer::read(driver).await,
            Self::Qmc6310(driver) => Magnetometer::read(driver).await,
            Self::Mmc5603(driver) => Magnetometer::read(driver).await,
            Self::Mmc5983ma(driver) => Magnetometer::read(driver).await,
            Self::Bmm150(driver) => Magnetometer::read(driver).await,
            Self::Bmm350(driver) => Magnetometer::read(driver).await,
            Self::Ak09916(driver) => Magnetometer::read(driver).await,
            Self::Icm20948(driver) => Magnetometer::read(driver).await,
            Self::Ist8310(driver) => Magnetometer::read(driver).await,
            Self::Rm3100(driver) => Magnetometer::read(driver).await,
        }
    }

    async fn temperature_c(&mut self) -> Result<Option<f32>, Error<I2C::Error>> {
        match self {
            Self::Lis2mdl(driver) => Magnetometer::temperature_c(driver).await,
            Self::Lis3mdl(driver) => Magnetometer::temperature_c(driver).await,
            Self::Lsm303dlhc(driver) => Magnetometer::temperature_c(driver).await,
            Self::Hmc5883l(driver) => Magnetometer::temperature_c(driver).await,
            Self::Qmc5883l(driver) => Magnetometer::temperature_c(driver).await,
            Self::Qmc5883p(driver) => Magnetometer::temperature_c(driver).await,
            Self::Qmc6309(driver) => Magnetometer::temperature_c(driver).await,
            Self::Qmc6310(driver) => Magnetometer::temperature_c(driver).await,
            Self::Mmc5603(driver) => Magnetometer::temperature_c(driver).await,
            Self::Mmc5983ma(driver) => Magnetometer::temperature_c(driver).await,
            Self::Bmm150(driver) => Magnetometer::temperature_c(driver).await,
            Self::Bmm350(driver) => Magnetometer::temperature_c(driver).await,
            Self::Ak09916(driver) => Magnetometer::temperature_c(driver).await,
            Self::Icm20948(driver) => Magnetometer::temperature_c(driver).await,
            Self::Ist8310(driver) => Magnetometer::temperature_c(driver).await,
            Self::Rm3100(driver) => Magnetometer::temperature_c(driver).await,
        }
    }
}
