//! Gains that follow a column.

use super::apart;
use super::built_in::Typed;
use super::code::{CNumber, RustCode, c_along};
use super::columns::{ColumnKind as Kind, Usual};
use super::definition::Effect;
use super::family::{Acts, Advice, Amount, Family, Follows, Subject};
use super::parts::{Form, Parts, Zero};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape, diagonal};
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

const KIND: &str = "gain";

const FORM: Form = Form { tag: 5, column: true, zero: Zero::Column, ..Form::PLAIN };

impl<C: Copy, T: Real> Typed<C> for Gain<C, T> {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        Gain { column: parts.column, reference: T::of(parts.reference) }
    }

    fn parts(&self) -> Parts<C> {
        Parts { form: &FORM, column: self.column, reference: self.reference.as_f64(), parameter: 0.0 }
    }
}

/// All gains that follow columns.
pub struct Gains;

impl Family for Gains {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Gain::<&str, f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Column
    }
    fn acts(&self) -> Acts {
        Acts::Measured
    }
    fn usual_columns(&self) -> &'static [Usual] {
        &[Usual::TEMPERATURE]
    }
    fn amount(&self) -> Amount {
        Amount::Share
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        apart::apart(own, other)
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        let (column, reference) = (code.column, code.number(parts.reference));
        write!(out, "BuiltIn::Gain(Gain {{ column: {column}, reference: {reference} }})")
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Gain"]
    }
    fn c(
        &self,
        parts: &Parts<&str>,
        [input, _]: [&str; MAX_INPUTS],
        out: &mut dyn fmt::Write,
    ) -> fmt::Result {
        c_along(out, format_args!("{input} - {}", CNumber(parts.reference)), "measured_ut[i] * ")
    }
}

impl<C: AsRef<str>, T: Real> Effect<T> for Gain<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "{KIND}:{}", self.column.as_ref())
    }

    fn name(&self) -> &'static str {
        match Kind::of(self.column.as_ref()) {
            Kind::Temperature => "gain proportional to temperature",
            Kind::Current => "gain proportional to current",
            Kind::Other => "gain proportional to a column",
        }
    }

    fn explanation(&self) -> &'static str {
        match Kind::of(self.column.as_ref()) {
            Kind::Temperature => {
                "The sensitivity of each sensor axis changes with temperature. \
                 The error grows with the reading and with the temperature's distance from its reference."
            }
            Kind::Current | Kind::Other => {
                "The sensitivity of each sensor axis changes with this column, as with a falling supply voltage. The error \
                 grows with the reading and with the column's distance from its reference."
            }
        }
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(self.column.as_ref())), None]
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
        match Kind::of(self.column.as_ref()) {
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
