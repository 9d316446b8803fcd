//! From a table of columns to a calibration or a diagnosis.
//!
//! No files, no arguments, no printing, no clock: a log comes in as a [`Table`] of borrowed columns, and plain data go out.
//!
//! - [`fit()`] gives offset, matrix and effects with their errors, and a verdict;
//! - [`diagnose`] compares model and measurement and names what is missing;
//! - [`plausible`] says whether the columns can be what they are read as;
//! - [`look()`] does both at once, with series to be drawn; [`look_with`] draws a log under a calibration that there is already;
//! - [`Corrector`] applies a calibration to the rows of a log, [`export`] writes it as code and as the parameters of other programs.
//!
//! Effects of one's own are named in [`Options::registry`]; everything here asks them as it asks those of the library.
//!
//! The rooms follow the data; each imports only what stands before it: [`samples`] → [`base`] → [`residual`] → [`search`] →
//! [`outcome`] → [`mod@fit`] → [`picture`]. Next to them stand [`effects`], [`correct`] and [`export`], which know calibrations only.

pub mod base;
pub mod blocks;
pub mod calibration;
pub mod confined;
pub mod correct;
pub mod effects;
pub mod evidence;
pub mod export;
pub mod fit;
pub mod fleet;
pub mod frame;
pub mod noise;
pub mod outcome;
pub mod outside;
pub mod picture;
mod plain;
pub mod plausible;
pub mod reason;
pub mod report;
pub mod residual;
pub mod samples;
pub mod search;
pub mod similar;
pub mod table;
mod threads;
pub mod track;
pub mod unlogged;

pub use correct::{CannotCorrect, Corrector, on_another_clock};
pub use fit::allowed::{Allowed, allowed};
pub use fit::diagnosed::{diagnose, fit_and_diagnose};
pub use fit::fitted::Fitted;
pub use fit::run::fit;
pub use outcome::outcome::Diagnosis;
pub use outcome::request::{Options, Refusal};
pub use outside::{Extrapolation, Outside};
pub use picture::look::{Look, look, look_with};
pub use report::Report;
pub use table::{BadTable, Named, Table};

/// The examples of the readme, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
