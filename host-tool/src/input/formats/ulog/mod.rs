//! PX4 ULog, read from its specification (docs.px4.io, "ULog File Format").

mod collector;
mod layout;
mod magnetometer;
mod read;
mod topics;

pub use read::read;
