//! `ironout` — magnetometer calibration.
#![no_std]
#![forbid(unsafe_code)]
