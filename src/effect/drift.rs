//! A steady drift of the offset.

use super::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape, TIME, along, isotropic};
use crate::math::Real;
use core::fmt;

/// `drift`: `Φ = I₃·(t − t₀)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift<T> {
    /// Time at which the effect vanishes, s.
    pub reference_s: T,
}

impl<T: Real> Effect<T> for Drift<T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("drift")
    }

    fn name(&self) -> &str {
        "offset drift"
    }

    fn explanation(&self) -> &str {
        "The magnetisation of parts near the sensor, or its electronics, change slowly. \
         The offset drifts steadily with time."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }

    fn coefficients(&self) -> usize {
        3
    }

    fn unit(&self) -> &str {
        "µT/s"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [time, _] = at.inputs;
        isotropic(time - self.reference_s, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let [time, _] = at.inputs;
        along(time - self.reference_s, coefficients)
    }
}
