//! An effect whose shape is looked at elsewhere than at the measured vector.

use ironout::effect::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape};
use std::fmt;
use std::sync::Arc;

/// Somebody's effect, shared.
pub type Shared<'a> = Arc<dyn Effect<f64> + Send + Sync + 'a>;

/// The effect, looked at a vector that is known: of one sample.
pub struct LookedAt<'a> {
    /// The effect.
    pub inner: Shared<'a>,
    /// The vector in place of the measured one, µT.
    pub vector_ut: [f64; 3],
}

impl Effect<f64> for LookedAt<'_> {
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
        self.inner.shape(&Quantities { measured_ut: self.vector_ut, ..*at }, shape);
    }
}
