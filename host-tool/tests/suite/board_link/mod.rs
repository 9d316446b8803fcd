//! A board on a wire: a calibration onto it and off it, its stream as a log. The board is the device on the simulated bus,
//! behind a TCP port; its clock goes by what is said to it, so that nothing here depends on how fast the machine is.

mod calibration;
mod log;
mod refusals;
mod support;
