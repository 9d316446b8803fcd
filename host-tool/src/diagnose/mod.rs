//! Finds the missing effect: compares model and measurement, sees where it fails, learns what is missing.

pub mod alignment;
pub mod base;
pub mod candidates;
pub mod engine;
mod fft;
pub mod greedy;
pub mod samples;
pub mod screen;
pub mod search;
pub mod series;
pub mod table;
