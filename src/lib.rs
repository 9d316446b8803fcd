//! `ironout` — magnetometer calibration.
#![no_std]
#![forbid(unsafe_code)]

pub mod calibration;
pub mod coverage;
pub mod device;
pub mod fit;
pub mod gate;
pub mod math;
pub mod moments;
pub mod monomial;
pub mod protocol;
mod quadric;
pub mod quality;
pub mod record;
pub mod scatter;
pub mod session;
pub mod store;
pub mod whiteness;
