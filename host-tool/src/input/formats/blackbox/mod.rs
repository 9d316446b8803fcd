//! Blackbox logs of Betaflight and INAV, decoded by the crate `blackbox-log`.

mod averages;
mod firmware;
mod header;
mod read;

pub use read::read;
