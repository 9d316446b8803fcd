//! `ironout export`: a calibration as code, or as the parameters of an autopilot, a ROS node or a driver.

mod log;
pub mod run;
