//! An effect in a model: its shape, its coefficients, and the values of its columns.

use ironout::effect::{Effect, MAX_COEFFICIENTS, MAX_INPUTS};
use ironout::study::{Normal, Term};
use std::sync::Arc;

/// Most columns of one pass.
pub const COLUMNS: usize = 64;
/// Most effects of one pass.
pub const TERMS: usize = 20;
/// Blocks of time for the held-out error.
pub const BLOCKS: usize = 10;

/// A normal matrix of this host.
pub type Matrix = Normal<f64, COLUMNS>;

/// An effect with its coefficients and the values of its columns at every sample.
#[derive(Clone)]
pub struct Piece<'a> {
    /// Its id.
    pub id: String,
    /// The shape.
    pub effect: Arc<dyn Effect<f64> + Send + Sync + 'a>,
    /// Coefficients; the first k count.
    pub coefficients: [f64; MAX_COEFFICIENTS],
    /// What fixes the shape: `reference`, `at_s`, `frequency_hz`, `delay_s`.
    pub fixed: Vec<(&'static str, f64)>,
    /// Values of its columns.
    pub inputs: Arc<Vec<[f64; MAX_INPUTS]>>,
}

impl Piece<'_> {
    /// k.
    pub fn k(&self) -> usize {
        self.effect.coefficients().min(MAX_COEFFICIENTS)
    }

    /// The term of one sample.
    pub fn term(&self, sample: usize) -> Term<'_, f64> {
        Term {
            effect: self.effect.as_ref(),
            coefficients: self.coefficients,
            inputs: self.inputs.get(sample).copied().unwrap_or_default(),
        }
    }
}

/// An effect that gives no rows.
#[derive(Debug, Clone, PartialEq)]
pub enum BadShape {
    /// The shape of this one, an effect of the user's own, is not finite.
    NotFinite(String),
    /// There is no room for this one beside the others.
    NoRoom(String),
}
