//! A jump of the offset.

use super::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape, TIME, along, isotropic};
use crate::math::Real;
use core::fmt;

/// `step`: `Φ = I₃·[t ≥ t₁]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<T> {
    /// t₁, s.
    pub at_s: T,
}

impl<T: Real> Effect<T> for Step<T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("step")
    }

    fn name(&self) -> &str {
        "offset step"
    }

    fn explanation(&self) -> &str {
        "A magnet or an iron part was attached, moved or magnetised by a shock. \
         From then on the offset is another."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }

    fn coefficients(&self) -> usize {
        3
    }

    fn unit(&self) -> &str {
        "µT"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [time, _] = at.inputs;
        isotropic(if time >= self.at_s { T::one() } else { T::zero() }, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let [time, _] = at.inputs;
        along(if time >= self.at_s { T::one() } else { T::zero() }, coefficients)
    }
}
