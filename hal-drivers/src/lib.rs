//! Drivers of three-axis magnetometers over the embedded-hal 1.0 `I2c` trait, blocking and async. See the README for the table of
//! chips; each module's first lines are the chip's registers with their sources.
//!
//! An application knows the chip only through [`Magnetometer`]: raw counts in the chip's own axes, the scale that turns
//! them into µT, and what the chip says about the sample (overflow, data ready, temperature). How the chip is mounted, how it is
//! calibrated and which pins it hangs on belong to the board and to the application; nothing here knows any of them.
//!
//! A chip is data, [`Chip`]: a register map and what its bytes mean. One text drives them all, [`Driver`], and is compiled
//! twice, for a bus that is waited for and, with the feature `async`, for one that is awaited (`asynch`).
//!
//! ```
//! use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, Range};
//! use ironout_drivers::{Error, Magnetometer};
//!
//! // Whatever implements `embedded_hal::i2c::I2c` is the bus.
//! fn field_ut<I2C: embedded_hal::i2c::I2c>(bus: I2C) -> Result<Option<[f32; 3]>, Error<I2C::Error>> {
//!     let mut driver = Lsm303dlhc::new(bus, Config { range: Range::Gauss1_9, ..Config::default() });
//!     driver.init()?; // identifies the chip, writes the whole configuration, reads it back
//!     let sensor = driver.describe();
//!     // `None`: the field is outside the range, and the reading is no measurement.
//!     Ok(sensor.measured_ut(sensor.sample(&driver.read()?)))
//! }
//! ```
//!
//! An EEPROM for the calibration needs no driver of ours: `eeprom24x` over the same bus is what `ironout::store::StorageSlots`
//! takes.
#![no_std]
#![forbid(unsafe_code)]
// One text, two modes: that is what it is for.
#![allow(clippy::duplicate_mod)]

mod blocking;
pub mod chip;

/// The same drivers over `embedded-hal-async`: what is a function elsewhere is awaited here. From the same text.
#[cfg(feature = "async")]
pub mod asynch;

/// A chip's wires, as the drivers that take either kind of them name them.
pub mod wires {
    pub use crate::blocking::{Registers, SpiRegisters, Wires};
}

pub use blocking::{AnyMagnetometer, Driver, Memsic, NoDelay, probe};
pub use chip::description::{Chip, Identity, Thermometer, Write};
pub use chip::kind::{Findings, Found, Kind, MOST_FOUND};
pub use chip::self_test::{Good, Outcome, Plan, SelfTest};
pub use chip::set_reset::SetReset;
pub use ironout_sensor::{
    Accelerometer, AsyncAccelerometer, AsyncGyroscope, AsyncMagnetometer, Axis, AxisMap, Error, Gyroscope,
    Magnetometer, Reading, Sample, Sensor, Validity,
};

/// A module of a chip's: what it is, and its driver.
macro_rules! chip {
    ($(#[$doc:meta])* $module:ident, $driver:ident) => {
        $(#[$doc])*
        ///
        #[doc = concat!("Registers with their sources: [`chip::", stringify!($module), "`](crate::chip::", stringify!($module), ").")]
        pub mod $module {
            #[doc(inline)]
            pub use crate::chip::$module::*;

            #[doc = concat!("The driver. Awaited: `asynch::Driver<I2C, ", stringify!($module), "::Config>`.")]
            pub type $driver<I2C> = crate::Driver<I2C, Config>;
        }
    };
    ($(#[$doc:meta])* $module:ident, own $driver:ident) => {
        $(#[$doc])*
        ///
        #[doc = concat!("Registers with their sources: [`chip::", stringify!($module), "`](crate::chip::", stringify!($module), ").")]
        pub mod $module {
            #[doc(inline)]
            pub use crate::blocking::$driver;
            #[doc(inline)]
            pub use crate::chip::$module::*;
        }
    };
}

chip!(
    /// ST LSM303DLHC, the magnetic half (address 0x1e): 12-bit counts, ±1.3 to ±8.1 G, 0.75 to 220 Hz.
    ///
    /// Three things about this chip that its users trip over:
    /// - the output registers stand in the order **x, z, y**, high byte first;
    /// - z has **another scale** than x and y (datasheet table 75);
    /// - an axis out of range reads **−4096**, which is no count.
    ///
    /// The six output bytes are read in one transaction: the chip holds them together from the first byte to the
    /// last. The address pointer of the magnetic half increments by itself; the most significant bit of the
    /// sub-address, which the accelerometer half wants, must stay clear here.
    lsm303dlhc, Lsm303dlhc
);
chip!(
    /// ST LIS2MDL, IIS2MDC, and the magnetic half of an LSM303AGR: 16 bits, ±49 G, 10 to 100 Hz.
    lis2mdl, Lis2mdl
);
chip!(
    /// ST LIS3MDL: 16 bits, ±4 to ±16 G, 10 to 155 Hz.
    lis3mdl, Lis3mdl
);
chip!(
    /// Honeywell HMC5883L: 12 bits, ±0.88 to ±8.1 G, 0.75 to 75 Hz.
    hmc5883l, Hmc5883l
);
chip!(
    /// QST QMC5883L: 16 bits, ±2 or ±8 G, 10 to 200 Hz.
    qmc5883l, Qmc5883l
);
chip!(
    /// QST QMC5883P: 16 bits, ±2 to ±30 G, 10 to 200 Hz.
    qmc5883p, Qmc5883p
);
chip!(
    /// QST QMC6309: 16 bits, ±8 to ±32 G, 10 to 200 Hz.
    qmc6309, Qmc6309
);
chip!(
    /// QST QMC6310: 16 bits, ±2 to ±30 G, 10 to 200 Hz.
    qmc6310, Qmc6310
);
chip!(
    /// MEMSIC MMC5603: 20 bits, ±30 G, 1 to 255 Hz, its own offset removed by SET and RESET.
    mmc5603, own Mmc5603
);
chip!(
    /// MEMSIC MMC5983MA: 18 bits, ±8 G, 10 to 200 Hz, its own offset removed by SET and RESET.
    mmc5983ma, own Mmc5983ma
);
chip!(
    /// Bosch BMM150: compensated by each chip's trimming, 10 to 30 Hz.
    bmm150, own Bmm150
);
chip!(
    /// Bosch BMM350: compensated by each chip's OTP memory, magnetically reset, 25 to 400 Hz.
    bmm350, own Bmm350
);
chip!(
    /// AKM AK09916: 16 bits, ±4912 µT, 10 to 100 Hz.
    ak09916, Ak09916
);
chip!(
    /// TDK ICM-20948: an AK09916 behind its bypass.
    icm20948, own Icm20948
);
chip!(
    /// iSentek IST8310: 16 bits, ±1600 µT, 160 Hz at most.
    ist8310, Ist8310
);
chip!(
    /// PNI RM3100: 24 bits, ±800 µT, 9 to 300 Hz.
    rm3100, Rm3100
);

chip!(
    /// ST LSM303DLHC and LSM303AGR, the accelerometer half (address 0x19): ±2 to ±16 g.
    lsm303_accelerometer, own Lsm303Accelerometer
);
chip!(
    /// ST L3GD20, L3GD20H and I3G4250D gyroscopes, on SPI or I²C.
    l3gd20, own L3gd20
);

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
