//! A change of the Earth's field itself.

use super::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape};
use crate::math::Real;
use core::fmt;

/// `field:COLUMN`: `Φ = (ĥ − b)·(u − u₀)`, the vector about the centre without the disturbance: the magnitude is
/// `F (1 + θ (u − u₀))`, it follows place, height or time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientField<C, T> {
    /// The column: its name as `&str`, or as a [`super::ColumnName`] that owns it.
    pub column: C,
    /// Value of the column at which the effect vanishes.
    pub reference: T,
}

impl<C: AsRef<str>, T: Real> Effect<T> for AmbientField<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "field:{}", self.column.as_ref())
    }

    fn name(&self) -> &str {
        "ambient field"
    }

    fn explanation(&self) -> &str {
        "The Earth's field, or that of a building, is not the same everywhere and always. \
         Its magnitude follows this column, whatever the attitude."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(self.column.as_ref())), None]
    }

    fn coefficients(&self) -> usize {
        1
    }

    fn unit(&self) -> &str {
        "1 per unit"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [input, _] = at.inputs;
        let value = input - self.reference;
        let [first, ..] = shape;
        *first = at.centred_ut.map(|axis| axis * value);
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, [gain, ..]: &Coefficients<T>) -> [T; 3] {
        let [input, _] = at.inputs;
        let value = *gain * (input - self.reference);
        at.centred_ut.map(|axis| axis * value)
    }
}
