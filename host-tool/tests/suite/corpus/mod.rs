//! One simulated log in the text formats of many programs, each written by a writer of the tests' own.

mod apps;
mod boards;
mod every;
mod programs;
mod sample;
mod tables;

pub use every::all;
pub use sample::{Row, Sample, lines, rows};
