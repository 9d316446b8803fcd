//! `ironout` — magnetometer calibration.
#![no_std]
#![forbid(unsafe_code)]

pub mod calibration;
pub mod fit;
pub mod math;
pub mod moments;
pub mod monomial;
pub mod protocol;
mod quadric;
pub mod record;
pub mod scatter;
pub mod store;
