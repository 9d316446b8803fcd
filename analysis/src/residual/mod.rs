//! What the base model leaves: its traces, its delay.

pub mod late;
pub mod traces;
