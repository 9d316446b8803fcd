//! Gains that follow a column.

use super::offset::{Kind, kind_of};
use super::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape, diagonal};
use crate::math::Real;
use core::fmt;

/// `gain:COLUMN`: `Φ = diag(ĥ)·(u − u₀)`. Over a temperature this is sensitivity drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain<C, T> {
    /// The column: its name as `&str`, or as a [`super::ColumnName`] that owns it.
    pub column: C,
    /// Value of the column at which the effect vanishes.
    pub reference: T,
}

impl<C: AsRef<str>, T: Real> Effect<T> for Gain<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "gain:{}", self.column.as_ref())
    }

    fn name(&self) -> &str {
        match kind_of(self.column.as_ref()) {
            Kind::Temperature => "temperature gain",
            Kind::Current => "gain with a current",
            Kind::Other => "gain with a column",
        }
    }

    fn explanation(&self) -> &str {
        match kind_of(self.column.as_ref()) {
            Kind::Temperature => {
                "The sensitivity of each sensor axis changes with temperature. \
                 The error grows with the reading and with the temperature's distance from its reference."
            }
            Kind::Current | Kind::Other => {
                "The sensitivity of each sensor axis follows this column, as with a sagging supply voltage. \
                 The error grows with the reading and with the column's distance from its reference."
            }
        }
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(self.column.as_ref())), None]
    }

    fn coefficients(&self) -> usize {
        3
    }

    fn unit(&self) -> &str {
        match kind_of(self.column.as_ref()) {
            Kind::Temperature => "1/°C",
            Kind::Current => "1/A",
            Kind::Other => "1 per unit",
        }
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [input, _] = at.inputs;
        let value = input - self.reference;
        diagonal(at.measured_ut.map(|axis| axis * value), 0, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, [a, b, c, ..]: &Coefficients<T>) -> [T; 3] {
        let [input, _] = at.inputs;
        let value = input - self.reference;
        let [x, y, z] = at.measured_ut;
        [*a * x * value, *b * y * value, *c * z * value]
    }
}
