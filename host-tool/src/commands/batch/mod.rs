//! `ironout batch`: many logs, one row each, and what they say together.

mod files;
mod origin;
mod page;
mod row;
pub mod run;
mod state;
mod study;
mod words;
