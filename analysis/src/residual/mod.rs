//! What the base model leaves: its spectrum, its traces, its delay.

pub mod late;
pub mod spectrum;
pub mod traces;
