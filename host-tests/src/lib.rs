//! What ironout is measured with: the tables of accuracy, and the cost on an emulated Cortex-M4F.
#![forbid(unsafe_code)]

pub mod accuracy;
#[cfg(unix)]
pub mod footprint;
pub mod frozen;
pub mod learning;
pub mod m4;
pub mod measured;
pub mod rate;
pub mod symbols;
