//! Candidates of a log, their tests, and the fits of the terms that were selected.

pub mod candidates;
pub mod collinear;
pub mod conditional;
pub mod gains;
pub mod leaders;
pub mod parameter;
pub mod parts;
pub mod screen;
pub mod search;
pub mod selected;
pub mod several;
pub mod shown;
pub mod state;
pub mod step_evidence;
pub mod tone;
pub mod true_field;
