//! The linearised model: what a fit with effects and a study of them both look at.
//!
//! A [`Model`] is offset, matrix and field; at it a sample with its effects (an [`Observation`] and [`Term`]s) becomes rows
//! of a [`Residual`], taken at the closest point. It knows shapes of effects, and neither how rows are added up nor who applies
//! the result.

mod base;
mod closest_point;
mod correct;
mod fixed_point;
mod rows;
mod sample;
mod secant;

pub use base::Model;
pub(crate) use fixed_point::settle;
pub use sample::{NoRow, NotFinite, Observation, Residual, Term};
pub use secant::Secant;
