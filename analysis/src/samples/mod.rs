//! The samples of a log, and what is wrong with them.

pub mod accelerometer;
pub mod clock;
pub mod common;
pub mod copied;
pub mod data;
pub mod detected;
pub mod faults;
pub mod fft;
pub mod gravity;
pub mod pairs;
pub mod samples;
pub mod scores;
pub mod series;
pub mod work;
