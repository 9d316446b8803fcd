//! Parquet files, and Arrow files (Feather, version 2).

mod caught;
mod cells;
mod read;

pub use read::{Container, read};
