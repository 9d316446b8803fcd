//! `ironout report`: one page about a log, and its plots as files.

mod plots;
mod run;

pub use run::run;
