//! Finds the missing effect: compares model and measurement, sees where it fails, learns what is missing.

pub mod alignment;
pub mod base;
pub mod candidates;
pub mod engine;
pub mod faults;
pub(crate) mod fft;
pub mod frequency;
pub mod greedy;
pub mod json;
pub mod outcome;
pub mod quality;
mod rest;
pub mod samples;
pub mod screen;
pub mod search;
pub mod series;
mod shows;
mod study;
pub mod table;
pub mod traces;

pub use outcome::Diagnosis;
pub use study::{Options, Refusal, diagnose};
pub use table::Table;
