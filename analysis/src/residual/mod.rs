//! What the base model leaves: its spectrum, its traces, its delay.

mod autoregression;
pub mod late;
pub mod place;
pub mod spectrum;
pub mod traces;
