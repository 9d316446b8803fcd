//! An effect whose shape is looked at elsewhere than at the measured vector.

use ironout::effect::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape};
use std::fmt;
use std::sync::Arc;

/// Somebody's effect, shared.
pub type Shared<'a> = Arc<dyn Effect<f64> + Send + Sync + 'a>;

/// Where the shape is looked at.
pub trait Place: Send + Sync {
    /// The vector in place of the measured one, µT.
    fn vector_ut(&self, inner: &dyn Effect<f64>, at: &Quantities<f64>) -> [f64; 3];
}

/// A vector that is known: of one sample, µT.
#[derive(Clone, Copy)]
pub struct Seen(pub [f64; 3]);

impl Place for Seen {
    fn vector_ut(&self, _: &dyn Effect<f64>, _: &Quantities<f64>) -> [f64; 3] {
        self.0
    }
}

/// The effect, looked at there.
pub struct LookedAt<'a, P> {
    /// The effect.
    pub inner: Shared<'a>,
    /// Where its shape is looked at.
    pub place: P,
}

impl<P: Place> Effect<f64> for LookedAt<'_, P> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        self.inner.id(out)
    }
    fn name(&self) -> &'static str {
        self.inner.name()
    }
    fn explanation(&self) -> &'static str {
        self.inner.explanation()
    }
    fn columns(&self) -> [Option<Column<'_, f64>>; MAX_INPUTS] {
        self.inner.columns()
    }
    fn needs_gyro(&self) -> bool {
        self.inner.needs_gyro()
    }
    fn coefficients(&self) -> usize {
        self.inner.coefficients()
    }
    fn unit(&self) -> &'static str {
        self.inner.unit()
    }
    fn reads_centre(&self) -> bool {
        self.inner.reads_centre()
    }
    fn delay_s(&self, coefficients: &Coefficients<f64>) -> Option<f64> {
        self.inner.delay_s(coefficients)
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        let measured_ut = self.place.vector_ut(self.inner.as_ref(), at);
        self.inner.shape(&Quantities { measured_ut, ..*at }, shape);
    }
}
