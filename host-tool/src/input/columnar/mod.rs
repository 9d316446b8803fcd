//! Parquet files, and Arrow files (Feather, version 2).

mod cells;
mod read;

pub use read::{Container, read};
