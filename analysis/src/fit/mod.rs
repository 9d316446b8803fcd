//! What a fit says.

pub mod allowed;
pub mod confined;
mod confined_effects;
pub mod diagnosed;
pub mod extended;
pub mod fitted;
pub mod ids;
pub mod pair;
mod recordings;
pub mod run;
pub(crate) mod turn;
mod vehicle;
