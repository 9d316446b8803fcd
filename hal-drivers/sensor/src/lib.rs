//! What a magnetometer is to an application, whichever chip it is: no bus, no chip, no calibration.
//!
//! A driver implements [`Magnetometer`] and describes its chip with one value, [`Sensor`]; the application turns each
//! [`Reading`] (chip axes) into a [`Sample`] (board axes) with it. Everything behind that knows the board's axes only.
//!
//! ```
//! use ironout_sensor::{Axis, AxisMap, Reading, Sample, Sensor};
//!
//! // A chip whose x axis points to the right of the board, and y to its back.
//! let axes = AxisMap::new([Axis::MinusY, Axis::X, Axis::Z]).ok_or("each axis once")?;
//! let sensor = Sensor { ut_per_count: [0.1, 0.1, 0.2], axes, ..Sensor::uniform("a chip", 0.1, 75.0) };
//! let sample = sensor.sample(&Reading { counts: [10, 20, 30], overflow: [false; 3] });
//! assert_eq!(sample, Sample::valid([-20, 10, 30]));
//! assert_eq!(sensor.measured_ut(sample), Some([-2.0, 1.0, 6.0]));
//! # Ok::<(), &str>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

mod axes;
mod description;
mod error;
mod inertial;
mod inertial_async;
mod magnetometer;
mod magnetometer_async;
mod sample;

pub use axes::{Axis, AxisMap};
pub use description::Sensor;
pub use error::Error;
pub use inertial::{Accelerometer, Gyroscope};
pub use inertial_async::{AsyncAccelerometer, AsyncGyroscope};
pub use magnetometer::Magnetometer;
pub use magnetometer_async::AsyncMagnetometer;
pub use sample::{Reading, Sample, Validity};
