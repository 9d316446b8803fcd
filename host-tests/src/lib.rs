//! What ironout is tested on: a simulated world, simulated chips and bus, and the emulated board.
#![forbid(unsafe_code)]

<<<<<<< HEAD
#[cfg(unix)]
pub mod qemu;
=======
pub mod m4;
>>>>>>> 793e55f (Count the core's instructions, flash and stack on the emulated Cortex-M4F)
pub mod world;

pub mod paper;
