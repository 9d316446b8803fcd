//! The noise of a sensor: white, filtered, 1/f, or a vector that wanders in its axes, and what is none.

pub mod autoregression;
pub mod cause;
pub mod model;
pub mod own;
