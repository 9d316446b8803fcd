//! `--derive NAME=EXPRESSION`: columns computed from others, so that a hypothesis needs no program.

mod columns;
mod definition;
mod expression;
mod rows;
mod tokens;

pub use columns::add;
pub use definition::{Definition, needed};
