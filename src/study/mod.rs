//! The study of what the base model leaves over.
//!
//! One pass over a log linearises a residual (magnitude, dip, or at rest the vector) at a fixed [`Model`] and adds each
//! row to the [`Normal`] matrix of its block of time. From the blocks alone, without the samples, follow
//!
//! - the fit and its standard errors ([`Normal::factor`]),
//! - the error on held-out blocks of time ([`held_out`]),
//! - the test of a candidate effect ([`Normal::test`], [`f_tail`]),
//! - which candidates cannot be told apart ([`Normal::canonical_correlations`]).
//!
//! What is concluded from that is the [`rule`].
//!
//! The order of columns is: base (nine for the magnitude, four for the dip, three for the vector), effects in the model,
//! candidates. Residuals are `r(p)`, `J = ∂r/∂p`, `g = Jᵀr`, so a step is `δ = −N⁻¹g`.

mod holdout;
mod normal;
mod pass;
mod prior;
mod refit;
pub mod rule;
mod schur;

pub use crate::fdist::f_tail;
pub use crate::model::{Model, NoRow, NotFinite, Observation, Residual, Term};
pub use holdout::{HeldOut, held_out};
pub use normal::{Factor, Normal};
pub use pass::Study;
pub use prior::{PhysicalPrior, base_prior};
pub use refit::refit;
pub use schur::{Improvement, MIN_EIGENVALUE};

#[cfg(test)]
mod tests;
