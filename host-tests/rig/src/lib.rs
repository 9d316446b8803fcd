//! What a board is tested on: simulated chips on a simulated bus, a simulated board of them, and the board emulated in QEMU.
#![forbid(unsafe_code)]

pub mod board;
pub mod bus;
pub mod chips;
#[cfg(unix)]
pub mod qemu;
pub mod served;
