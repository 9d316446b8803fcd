//! `ironout record`: a board's stream as a log.

mod follow;
mod rows;
mod run;
mod spool;

pub use run::run;
