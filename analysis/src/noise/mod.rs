//! The colours that a sensor's noise has, and which of them a residual has.

pub mod colour;
pub mod power;
pub mod shared;
pub mod still;
pub mod stretches;
pub mod turning;

#[cfg(test)]
mod tests;
