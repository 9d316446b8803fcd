//! A jump of the offset.

use super::built_in::Typed;
use super::code::{RustCode, c_along};
use super::definition::Effect;
use super::family::{Amount, Family, Follows};
use super::parts::{Form, Parts, Searched};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape, TIME, along, isotropic};
use crate::math::Real;
use crate::number::Num;
use core::fmt;

/// `step`: `Φ = I₃·[t ≥ t₁]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<T> {
    /// t₁, s.
    pub at_s: T,
}

const KIND: &str = "step";

const FORM: Form = Form { tag: 8, searched: Some(Searched::At), ..Form::PLAIN };

impl<C: Copy + Default, T: Real> Typed<C> for Step<T> {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        Step { at_s: T::of(parts.parameter) }
    }

    fn parts(&self) -> Parts<C> {
        Parts { parameter: self.at_s.as_f64(), ..Parts::of(&FORM) }
    }
}

/// The jump.
pub struct Steps;

impl Family for Steps {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Step::<f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Time
    }
    fn amount(&self) -> Amount {
        Amount::Itself
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "BuiltIn::Step(Step {{ at_s: {} }})", code.number(parts.parameter))
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Step"]
    }
    fn c(&self, parts: &Parts<&str>, [time, _]: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        c_along(out, format_args!("{time} >= {:?} ? 1 : 0", Num(parts.parameter)), "")
    }
}

impl<T: Real> Effect<T> for Step<T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "offset step"
    }

    fn explanation(&self) -> &'static str {
        "A magnet or an iron part was attached, moved or magnetised by a shock. The offset changed at that moment."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
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
