//! `ironout live`: the page served next to a board.

#[cfg(feature = "demo")]
mod bench;
mod link;
mod run;
mod server;

pub use run::run;
