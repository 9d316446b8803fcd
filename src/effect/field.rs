//! A change of the Earth's field itself.

use super::apart;
use super::built_in::Typed;
use super::code::{CNumber, RustCode};
use super::definition::Effect;
use super::family::{Acts, Advice, Amount, Family, Follows, Subject};
use super::parts::{Form, Parts, Zero};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape};
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

const KIND: &str = "field";

const FORM: Form = Form { tag: 6, column: true, coefficients: 1, zero: Zero::Column, ..Form::PLAIN };

impl<C: Copy, T: Real> Typed<C> for AmbientField<C, T> {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        AmbientField { column: parts.column, reference: T::of(parts.reference) }
    }

    fn parts(&self) -> Parts<C> {
        Parts { form: &FORM, column: self.column, reference: self.reference.as_f64(), parameter: 0.0 }
    }
}

/// All fields whose magnitude follows a column.
pub struct AmbientFields;

impl Family for AmbientFields {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&AmbientField::<&str, f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Column
    }
    fn acts(&self) -> Acts {
        Acts::Field
    }
    fn amount(&self) -> Amount {
        Amount::Share
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        apart::apart(own, other)
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        let (column, reference) = (code.column, code.number(parts.reference));
        write!(out, "BuiltIn::Field(AmbientField {{ column: {column}, reference: {reference} }})")
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["AmbientField", "BuiltIn"]
    }
    fn c(
        &self,
        parts: &Parts<&str>,
        [input, _]: [&str; MAX_INPUTS],
        out: &mut dyn fmt::Write,
    ) -> fmt::Result {
        let reference = CNumber(parts.reference);
        write!(
            out,
            "            const ironout_real value = {input} - {reference};\n            for (i = 0; i < 3; i++) \
             {{\n                \
             sum[i] += theta[0] * value * left[i];\n            }}\n"
        )
    }
}

impl<C: AsRef<str>, T: Real> Effect<T> for AmbientField<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "{KIND}:{}", self.column.as_ref())
    }

    fn name(&self) -> &'static str {
        "field strength proportional to a column"
    }

    fn explanation(&self) -> &'static str {
        "The field of the Earth or of a building is not constant in space and time. Its magnitude changes with this column, \
         independent of the orientation."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(self.column.as_ref())), None]
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
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
