//! What the base model leaves: its spectrum, its traces, its headings, its delay.

pub mod heading;
pub mod late;
pub mod spectrum;
pub mod traces;
