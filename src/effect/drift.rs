//! A steady drift of the offset.

use super::built_in::Typed;
use super::code::{RustCode, c_along};
use super::definition::Effect;
use super::family::{Advice, Amount, Family, Follows, Subject};
use super::parts::{Form, Parts, Zero};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape, TIME, along, isotropic};
use crate::math::Real;
use crate::number::Num;
use core::fmt;

/// `drift`: `Φ = I₃·(t − t₀)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift<T> {
    /// Time at which the effect vanishes, s.
    pub reference_s: T,
}

const KIND: &str = "drift";

const FORM: Form = Form { tag: 7, zero: Zero::Time, ..Form::PLAIN };

impl<C: Copy + Default, T: Real> Typed<C> for Drift<T> {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        Drift { reference_s: T::of(parts.reference) }
    }

    fn parts(&self) -> Parts<C> {
        Parts { reference: self.reference_s.as_f64(), ..Parts::of(&FORM) }
    }
}

/// The steady drift.
pub struct Drifts;

impl Family for Drifts {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Drift::<f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Time
    }
    fn amount(&self) -> Amount {
        Amount::OverTime
    }
    fn apart<'a>(&self, _: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        (other.follows == Follows::Time && other.is_sudden()).then_some(Advice {
            text: "record for at least twice as long: a drift continues, a step stays constant.",
            names: [""; 2],
        })
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "BuiltIn::Drift(Drift {{ reference_s: {} }})", code.number(parts.reference))
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Drift"]
    }
    fn c(&self, parts: &Parts<&str>, [time, _]: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        c_along(out, format_args!("(ironout_real)({time} - {:?})", Num(parts.reference)), "")
    }
}

impl<T: Real> Effect<T> for Drift<T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "offset drift"
    }

    fn explanation(&self) -> &'static str {
        "The magnetisation of parts near the sensor, or its electronics, change slowly. \
         The offset drifts steadily with time."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
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
