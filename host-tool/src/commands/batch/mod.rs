//! `ironout batch`: many logs, one row each, and what they say together.

mod files;
mod origin;
mod page;
#[cfg(feature = "parquet")]
mod parquet;
mod row;
pub mod run;
mod state;
mod study;
mod words;
