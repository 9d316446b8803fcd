//! The host side of `ironout`: reads logs, hands them to the analysis, and says what came out, in words or as JSON.
//!
//! Everything numeric is the analysis' and the core's; here are files, tables and words. `run` is the whole program; the page in
//! a browser is built without it, and without boards, terminals and signals.

pub mod along;
pub mod atomic;
#[cfg(not(target_arch = "wasm32"))]
pub mod board;
pub mod cal_file;
pub mod chart;
pub mod cli;
#[cfg(not(target_arch = "wasm32"))]
pub mod cli_batch;
#[cfg(not(target_arch = "wasm32"))]
pub mod cli_demo;
pub mod cli_export;
#[cfg(not(target_arch = "wasm32"))]
pub mod cli_help;
#[cfg(not(target_arch = "wasm32"))]
pub mod cli_page;
#[cfg(not(target_arch = "wasm32"))]
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
#[cfg(not(target_arch = "wasm32"))]
pub mod interrupt;
pub mod join;
#[cfg(not(target_arch = "wasm32"))]
pub mod link_args;
pub mod log_args;
pub mod output;
pub mod page;
pub mod paint;
pub mod plausible;
pub mod prior;
#[cfg_attr(target_arch = "wasm32", path = "progress_none.rs")]
pub mod progress;
pub mod read_block;
pub mod reading;
pub mod refusal;
pub mod registry;
pub mod report_text;
pub mod shell;
pub mod source;
pub mod turn;
#[cfg(all(feature = "demo", not(target_arch = "wasm32")))]
pub mod turned;
pub mod wrap;
pub mod written;

#[cfg(not(target_arch = "wasm32"))]
mod program;

#[cfg(not(target_arch = "wasm32"))]
pub use program::run;
