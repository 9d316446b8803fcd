//! One simulated log in the text formats of many programs, each written by a writer of the tests' own.
#![allow(dead_code, unused_imports)] // every test binary uses its own part

mod apps;
mod boards;
mod every;
mod programs;
mod sample;
mod tables;

pub use every::all;
pub use sample::{Row, Sample, lines, rows};
