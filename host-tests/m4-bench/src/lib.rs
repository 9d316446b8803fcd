//! What the measuring images share: the clock, the stack paint, the console and the samples.
#![no_std]

pub mod samples;

#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod board;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod linked;
