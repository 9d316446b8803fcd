//! Magnetometer drivers over the embedded-hal 1.0 [`I2c`](embedded_hal::i2c::I2c) trait.
//!
//! A driver delivers raw counts, the scale that turns them into µT, and what the chip says about each
//! sample (overflow, data ready, temperature). It knows nothing of calibration, pins or boards, so the same
//! object runs on a microcontroller's bus and on a simulated one.
//!
//! | chip | module |
//! |---|---|
//! | any | [`Magnetometer`], the trait the application is written against |
//! | ST LSM303DLHC (magnetic half) | [`lsm303dlhc`] |
//!
//! ```
//! use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, Range};
//! use ironout_drivers::{Error, Magnetometer};
//!
//! /// The field in µT; `None` where it is out of range.
//! fn field_ut<I2C: embedded_hal::i2c::I2c>(bus: I2C) -> Result<Option<[f32; 3]>, Error<I2C::Error>> {
//!     let mut driver = Lsm303dlhc::new(bus, Config { range: Range::Gauss1_9, ..Config::default() });
//!     driver.init()?;
//!     while !driver.data_ready()? {}
//!     let sensor = driver.describe();
//!     Ok(sensor.measured_ut(sensor.sample(&driver.read()?)))
//! }
//! ```
//!
//! An EEPROM for the calibration needs no driver of ours: `eeprom24x` over the same bus is what `ironout::store::StorageSlots`
//! takes.
#![no_std]
#![forbid(unsafe_code)]

pub mod lsm303dlhc;

pub use ironout_sensor::{Axis, AxisMap, Error, Magnetometer, Reading, Sample, Sensor, Validity};

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
