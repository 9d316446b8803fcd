//! An additive field that follows a column.

use super::{Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape, along, isotropic};
use crate::math::Real;
use core::fmt;

/// Power of the column that acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// The column itself.
    Linear,
    /// Its square.
    Squared,
}

/// `offset:COLUMN`: `Φ = I₃·(u − u₀)`.
///
/// Over a temperature: zero drift of the sensor element, magnets that weaken with heat. Over a current: the field of
/// the wiring (Biot–Savart). Over anything else that was logged: whatever stands behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset<C, T> {
    /// The column: its name as `&str`, or as a [`super::ColumnName`] that owns it.
    pub column: C,
    /// Value of the column (or of its square) at which the effect vanishes.
    pub reference: T,
    /// Linear or squared.
    pub power: Power,
    /// How late the column acts, s; `None` for the plain effect.
    pub delay_s: Option<T>,
}

impl<C, T> Offset<C, T> {
    /// The plain effect.
    pub const fn linear(column: C, reference: T) -> Self {
        Offset { column, reference, power: Power::Linear, delay_s: None }
    }
}

pub(super) enum Kind {
    Temperature,
    Current,
    Other,
}

pub(super) fn kind_of(column: &str) -> Kind {
    if column.ends_with("_c") {
        Kind::Temperature
    } else if column.ends_with("_a") {
        Kind::Current
    } else {
        Kind::Other
    }
}

impl<C: AsRef<str>, T: Real> Effect<T> for Offset<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "offset:{}", self.column.as_ref())?;
        if self.delay_s.is_some() {
            out.write_str("@delay")?;
        }
        if self.power == Power::Squared { out.write_str("^2") } else { Ok(()) }
    }

    fn name(&self) -> &str {
        match (kind_of(self.column.as_ref()), self.power, self.delay_s.is_some()) {
            (Kind::Temperature, Power::Linear, false) => "temperature offset",
            (Kind::Temperature, Power::Linear, true) => "late temperature offset",
            (Kind::Temperature, Power::Squared, _) => "squared temperature offset",
            (Kind::Current, Power::Linear, false) => "current offset",
            (Kind::Current, Power::Linear, true) => "late current offset",
            (Kind::Current, Power::Squared, _) => "squared current offset",
            (Kind::Other, Power::Linear, false) => "offset with a column",
            (Kind::Other, Power::Linear, true) => "late offset with a column",
            (Kind::Other, Power::Squared, _) => "offset with a column's square",
        }
    }

    fn explanation(&self) -> &str {
        match (kind_of(self.column.as_ref()), self.power) {
            (Kind::Temperature, _) => {
                "The zero of the sensor element drifts with temperature, and magnets near it weaken with heat. \
                 Both add a vector in proportion to the temperature."
            }
            (Kind::Current, Power::Linear) => {
                "A current in wires near the sensor has a magnetic field of its own (Biot–Savart). \
                 It adds a vector of fixed direction in proportion to the current."
            }
            (Kind::Current, Power::Squared) => {
                "Iron near a current-carrying wire is magnetised in proportion to the current's square, or the logged \
                 value is not linear in the true current. It adds a vector of fixed direction."
            }
            (Kind::Other, Power::Linear) => {
                "Something that this column measures carries a magnetic field or shifts the sensor's zero. \
                 It adds a vector of fixed direction in proportion to the column."
            }
            (Kind::Other, Power::Squared) => {
                "Something behind this column has a magnetic field that grows with the column's square, as iron does \
                 that is magnetised by a coil. It adds a vector of fixed direction."
            }
        }
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column { name: self.column.as_ref(), delay_s: self.delay_s.unwrap_or(T::zero()) }), None]
    }

    fn coefficients(&self) -> usize {
        3
    }

    fn unit(&self) -> &str {
        match (kind_of(self.column.as_ref()), self.power) {
            (Kind::Temperature, Power::Linear) => "µT/°C",
            (Kind::Temperature, Power::Squared) => "µT/°C²",
            (Kind::Current, Power::Linear) => "µT/A",
            (Kind::Current, Power::Squared) => "µT/A²",
            (Kind::Other, Power::Linear) => "µT per unit",
            (Kind::Other, Power::Squared) => "µT per unit²",
        }
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [input, _] = at.inputs;
        let value = if self.power == Power::Squared { input * input } else { input };
        isotropic(value - self.reference, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let [input, _] = at.inputs;
        let value = if self.power == Power::Squared { input * input } else { input };
        along(value - self.reference, coefficients)
    }
}
