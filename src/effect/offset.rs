//! An additive field that follows a column.

use super::apart;
use super::built_in::Typed;
use super::code::{CNumber, RustCode, c_along};
use super::columns::{ColumnKind as Kind, Usual};
use super::definition::Effect;
use super::family::{Advice, Amount, Family, Follows, Subject};
use super::parts::{Form, Parts, Searched, Zero};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Past, Quantities, Shape, along, isotropic};
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
    /// Which past of the column acts.
    pub past: Past<T>,
}

impl<C, T> Offset<C, T> {
    /// The plain effect.
    pub const fn linear(column: C, reference: T) -> Self {
        Offset { column, reference, power: Power::Linear, past: Past::Now }
    }
}

const KIND: &str = "offset";

const PLAIN: Form = Form { tag: 1, column: true, zero: Zero::Column, ..Form::PLAIN };
const SQUARED: Form = Form { tag: 2, suffix: "^2", zero: Zero::Square, ..PLAIN };
const LATE: Form = Form { tag: 3, suffix: "@delay", searched: Some(Searched::Delay), ..PLAIN };
const SLOW: Form = Form { tag: 14, suffix: "~tau", searched: Some(Searched::TimeConstant), ..PLAIN };
const BOTH: Form = Form { tag: 4, suffix: "@delay^2", zero: Zero::Square, offered: false, ..LATE };

impl<C, T> Offset<C, T> {
    const fn form(&self) -> &'static Form {
        match (self.power, &self.past) {
            (Power::Linear, Past::Now) => &PLAIN,
            (Power::Linear, Past::Delayed(_)) => &LATE,
            (Power::Linear, Past::LowPass(_)) => &SLOW,
            (Power::Squared, Past::Now) => &SQUARED,
            (Power::Squared, _) => &BOTH,
        }
    }
}

impl<C: Copy, T: Real> Typed<C> for Offset<C, T> {
    const FORMS: &'static [&'static Form] = &[&PLAIN, &SQUARED, &LATE, &BOTH, &SLOW];

    fn of(parts: &Parts<C>) -> Self {
        Offset {
            column: parts.column,
            reference: T::of(parts.reference),
            power: if parts.form.is_squared() { Power::Squared } else { Power::Linear },
            past: parts.past().cast(),
        }
    }

    fn parts(&self) -> Parts<C> {
        let parameter = self.past.seconds().as_f64();
        Parts { form: self.form(), column: self.column, reference: self.reference.as_f64(), parameter }
    }
}

/// All offsets that follow columns.
pub struct Offsets;

impl Family for Offsets {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        <Offset<&str, f64> as Typed<&str>>::FORMS
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Offset::<&str, f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Column
    }
    fn is_proportional(&self, parts: &Parts<&str>) -> bool {
        *parts.form == PLAIN
    }
    fn usual_columns(&self) -> &'static [Usual] {
        &[Usual::TEMPERATURE, Usual::CURRENT]
    }
    fn amount(&self) -> Amount {
        Amount::Field
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        apart::apart(own, other)
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        let power = if parts.form.is_squared() { Power::Squared } else { Power::Linear };
        let (column, reference) = (code.column, code.number(parts.reference));
        write!(
            out,
            "BuiltIn::Offset(Offset {{ column: {column}, reference: {reference}, power: Power::{power:?}, past: Past::"
        )?;
        match parts.past() {
            Past::Now => out.write_str("Now })"),
            Past::Delayed(s) => write!(out, "Delayed({}) }})", code.number(s)),
            Past::LowPass(s) => write!(out, "LowPass({}) }})", code.number(s)),
        }
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Offset", "Past", "Power"]
    }
    fn c(
        &self,
        parts: &Parts<&str>,
        [input, _]: [&str; MAX_INPUTS],
        out: &mut dyn fmt::Write,
    ) -> fmt::Result {
        let reference = CNumber(parts.reference);
        match parts.form.is_squared() {
            true => c_along(out, format_args!("{input} * {input} - {reference}"), ""),
            false => c_along(out, format_args!("{input} - {reference}"), ""),
        }
    }
}

impl<C: AsRef<str>, T: Real> Effect<T> for Offset<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "{KIND}:{}{}", self.column.as_ref(), self.form().suffix)
    }

    fn name(&self) -> &'static str {
        match (Kind::of(self.column.as_ref()), self.power, self.past.word()) {
            (Kind::Temperature, Power::Linear, "") => "offset proportional to temperature",
            (Kind::Temperature, Power::Linear, "ahead") => "offset proportional to temperature, logged late",
            (Kind::Temperature, Power::Linear, "late") => "delayed offset proportional to temperature",
            (Kind::Temperature, Power::Linear, _) => "low-pass filtered offset proportional to temperature",
            (Kind::Temperature, Power::Squared, _) => "offset proportional to temperature squared",
            (Kind::Current, Power::Linear, "") => "offset proportional to current",
            (Kind::Current, Power::Linear, "ahead") => "offset proportional to current, logged late",
            (Kind::Current, Power::Linear, "late") => "delayed offset proportional to current",
            (Kind::Current, Power::Linear, _) => "low-pass filtered offset proportional to current",
            (Kind::Current, Power::Squared, _) => "offset proportional to current squared",
            (Kind::Other, Power::Linear, "") => "offset proportional to a column",
            (Kind::Other, Power::Linear, "ahead") => "offset proportional to a column, logged late",
            (Kind::Other, Power::Linear, "late") => "delayed offset proportional to a column",
            (Kind::Other, Power::Linear, _) => "low-pass filtered offset proportional to a column",
            (Kind::Other, Power::Squared, _) => "offset proportional to a column squared",
        }
    }

    fn explanation(&self) -> &'static str {
        match (Kind::of(self.column.as_ref()), self.power) {
            (Kind::Temperature, _) => {
                "The offset of the sensor element drifts with temperature, and magnets near it weaken with heat. Both add a \
                 vector proportional to the temperature."
            }
            (Kind::Current, Power::Linear) => {
                "A current in wires near the sensor has a magnetic field of its own (Biot–Savart). \
                 It adds a vector of fixed direction, proportional to the current."
            }
            (Kind::Current, Power::Squared) => {
                "The magnetisation of iron near a current-carrying wire grows with the current squared, or the logged value \
                 is not linear in the true current. It adds a vector of fixed direction."
            }
            (Kind::Other, Power::Linear) => {
                "The quantity in this column generates a magnetic field, or changes the sensor's offset. It adds a vector \
                 of fixed direction, proportional to the column."
            }
            (Kind::Other, Power::Squared) => {
                "The field grows with the column squared, as from iron magnetised by a coil. It adds a vector of fixed \
                 direction."
            }
        }
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column { name: self.column.as_ref(), past: self.past }), None]
    }

    fn coefficients(&self) -> usize {
        PLAIN.coefficients
    }

    fn unit(&self) -> &'static str {
        match (Kind::of(self.column.as_ref()), self.power) {
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
