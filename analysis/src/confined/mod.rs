//! Logs of boards that are not turned over: cars, boats, aircraft, a large drone moved by hand.
//!
//! The ellipsoid needs all directions; a vehicle shows a band of them. What it does show is used at once, in one linearised Gaussian model:
//! the magnitude, the dip against the accelerometer, the turning of the field against the gyro, and what is known before (how
//! magnetometers are, an earlier calibration, the field of the place). The covariance then says what the calibration is good for:
//! the error of a heading while level, and while tilted.

pub mod channels;
pub mod guided;
pub mod heading;
pub mod known;
pub mod log;
pub mod solve;
pub mod state;
