//! The search for what is missing: candidates, their tests, and which of them are added.

pub mod candidates;
pub mod certain;
pub mod collinear;
pub mod conditional;
pub mod gains;
pub mod greedy;
pub mod leaders;
pub mod pairs;
pub mod parameter;
pub mod physics;
pub mod screen;
pub mod search;
pub mod several;
pub mod shifted;
pub mod shown;
pub mod slowly;
pub mod state;
pub mod step_evidence;
pub mod thinned;
pub mod tone;
pub mod true_field;
