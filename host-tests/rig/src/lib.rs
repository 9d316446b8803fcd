//! What a board is tested on: simulated chips on a simulated bus, a simulated board of them, the board emulated in QEMU, and a
//! Raspberry Pi Pico whose emulated RP2040 runs the firmware as it is flashed.
#![forbid(unsafe_code)]

pub mod board;
pub mod bus;
pub mod chips;
#[cfg(unix)]
pub mod pico;
#[cfg(unix)]
pub mod qemu;
pub mod reply;
pub mod served;
