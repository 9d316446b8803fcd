//! Finds the missing effect: compares model and measurement, sees where it fails, learns what is missing.

pub mod alignment;
mod at_rest;
pub mod base;
pub mod candidates;
pub mod certain;
pub mod dip_errors;
pub mod engine;
mod families;
pub mod faults;
pub(crate) mod fft;
pub mod greedy;
pub mod json;
mod kin;
mod leaders;
mod lower_order;
pub mod outcome;
mod pairs;
pub mod parameter;
pub mod quality;
pub(crate) mod rest;
mod rows;
pub mod samples;
pub mod screen;
pub mod search;
pub mod series;
mod shows;
pub mod spectrum;
mod standing;
mod study;
pub mod table;
pub mod traces;
mod undisturbed;
mod view;

pub use outcome::Diagnosis;
pub use study::{Options, Refusal, diagnose, study};
pub use table::Table;
