//! Logs of other programs that are not a table: PX4 ULog, ArduPilot DataFlash, MAVLink telemetry, Betaflight and INAV blackbox, samples
//! of Betaflight Configurator, MCAP and rosbag2 of ROS.
//!
//! Each is read into a [`Recording`]: streams on time bases of their own, in body axes and the program's units, with the
//! calibration that an autopilot had applied taken out. One join makes a [`Log`](crate::input::log::Log) of it.

mod betaflight_json;
mod blackbox;
mod correction;
mod dataflash;
mod detected;
mod feed;
mod interpolate;
mod inventory;
mod join;
mod mavlink;
mod order;
mod parameters;
mod read;
mod ros;
mod rotation;
mod stream;
mod ulog;

pub use detected::{FIRST_BYTES, Format, detect};
pub use read::read;
pub use rotation::mounting;
pub use stream::{GROUND, Recording};
