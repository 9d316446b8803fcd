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
//! | 24-series I²C EEPROM with two-byte addresses, where a calibration is kept | [`at24c`] |
//!
//! ```
//! use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, Range};
//! use ironout_drivers::{Error, Magnetometer};
//!
//! fn field_ut<I2C: embedded_hal::i2c::I2c>(bus: I2C) -> Result<[f32; 3], Error<I2C::Error>> {
//!     let mut sensor = Lsm303dlhc::new(bus, Config { range: Range::Gauss1_9, ..Config::default() });
//!     sensor.init()?;
//!     let (scale, reading) = (sensor.ut_per_count(), sensor.read()?);
//!     Ok(core::array::from_fn(|i| f32::from(reading.counts[i]) * scale[i]))
//! }
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod at24c;
mod error;
pub mod lsm303dlhc;
mod magnetometer;

pub use error::Error;
pub use magnetometer::{Magnetometer, Reading};

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
