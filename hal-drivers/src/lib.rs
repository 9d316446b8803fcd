//! Magnetometer drivers over embedded-hal 1.0 I2c.
#![no_std]
#![forbid(unsafe_code)]
