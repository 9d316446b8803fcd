//! `ironout` — magnetometer calibration.
#![no_std]
#![forbid(unsafe_code)]

pub mod calibration;
pub mod fit;
pub mod math;
pub mod moments;
pub mod monomial;
mod quadric;
pub mod scatter;
