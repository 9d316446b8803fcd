//! Candidates of a log, their tests, and the fits of the terms that were selected.

pub mod candidates;
pub mod conditional;
pub mod parameter;
pub mod screen;
pub mod selected;
pub mod several;
pub mod shown;
pub mod state;
