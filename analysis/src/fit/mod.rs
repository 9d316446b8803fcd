//! What a fit says.

pub mod allowed;
pub mod confined;
pub mod diagnosed;
pub mod extended;
pub mod fitted;
pub mod ids;
pub mod run;
pub(crate) mod turn;
