//! What ironout is tested on: a simulated world, simulated chips and bus, and the emulated board.
#![forbid(unsafe_code)]

pub mod accuracy;
pub mod board;
pub mod bus;
pub mod chips;
pub mod m4;
#[cfg(unix)]
pub mod qemu;
pub mod world;

pub mod paper;
