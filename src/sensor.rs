//! What a sensor is to the application: its description, its samples, and the trait of its drivers.
//!
//! They stand in a crate of their own, `ironout-sensor`, so that a driver needs nothing of the calibration and the
//! calibration nothing of the drivers.

pub use ironout_sensor::{Axis, AxisMap, Error, Magnetometer, Reading, Sample, Sensor, Validity};
