//! What the base model leaves: its spectrum, its traces, its delay.

pub mod late;
pub mod place;
pub mod spectrum;
pub mod traces;
