//! Blackbox logs of Betaflight and INAV, decoded by the crate `blackbox-log`.

mod averages;
mod header;
mod read;

pub use read::read;
