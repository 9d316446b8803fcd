//! The host side of `ironout`: reads logs, hands them to the analysis, and says what came out, in words or as JSON.
//!
//! Everything numeric is the analysis' and the core's; here are files, tables and words. `run` is the whole program; the page in
//! a browser and the Python package are built without it (feature `program`), and so without boards, terminals and signals.

pub mod along;
pub mod atomic;
#[cfg(feature = "program")]
pub mod board;
pub mod cal_file;
pub mod chart;
pub mod checked;
pub mod cli;
#[cfg(feature = "program")]
pub mod cli_batch;
#[cfg(feature = "program")]
pub mod cli_demo;
pub mod cli_export;
#[cfg(feature = "program")]
pub mod cli_help;
#[cfg(feature = "program")]
pub mod cli_page;
#[cfg(feature = "program")]
pub mod commands;
pub mod corrected;
pub mod derive;
pub mod diagnosis_words;
pub mod exported;
pub mod failure;
pub mod field_unit;
pub mod fit_words;
pub mod geomag;
pub mod headings;
pub mod input;
#[cfg(feature = "program")]
pub mod interrupt;
pub mod join;
#[cfg(feature = "program")]
pub mod link_args;
pub mod log_args;
pub mod output;
pub mod page;
pub mod paint;
pub mod plausible;
pub mod prior;
#[cfg_attr(not(feature = "program"), path = "progress_none.rs")]
pub mod progress;
pub mod read_block;
pub mod reading;
pub mod refusal;
pub mod registry;
pub mod report_text;
pub mod shell;
pub mod simulated;
pub mod source;
pub mod turn;
#[cfg(all(feature = "demo", feature = "program"))]
pub mod turned;
pub mod wrap;
pub mod written;

#[cfg(feature = "program")]
mod program;

#[cfg(feature = "program")]
pub use program::run;
