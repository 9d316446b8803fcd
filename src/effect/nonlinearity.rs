//! Nonlinearity of each axis.

use super::attitude;
use super::built_in::Typed;
use super::code::RustCode;
use super::definition::Effect;
use super::family::{AXES, Acts, Advice, Family, Follows, Group, Subject};
use super::parts::{Form, Parts};
use super::quantities::{MAX_INPUTS, Quantities, Shape, diagonal};
use crate::math::Real;
use core::fmt;

/// `nonlinearity`: `Φ = [diag(ĥ²) | diag(ĥ³)]`: a core or an amplifier that saturates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Nonlinearity;

const KIND: &str = "nonlinearity";

const FORM: Form = Form { tag: 11, coefficients: 6, ..Form::PLAIN };

impl<C: Copy + Default> Typed<C> for Nonlinearity {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(_: &Parts<C>) -> Self {
        Nonlinearity
    }

    fn parts(&self) -> Parts<C> {
        Parts::of(&FORM)
    }
}

/// The nonlinearity of the axes.
pub struct Nonlinearities;

impl Family for Nonlinearities {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, _: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Nonlinearity);
    }
    fn follows(&self) -> Follows {
        Follows::Attitude
    }
    fn acts(&self) -> Acts {
        Acts::Measured
    }
    fn groups(&self, _: &Form) -> &'static [Group] {
        &[
            Group::Row { label: "squares", names: AXES, from: 0, unit: "1/µT" },
            Group::Row { label: "cubes", names: AXES, from: 3, unit: "1/µT²" },
        ]
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        attitude::apart(own, other)
    }
    fn rust(&self, _: &Parts<&str>, _: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("BuiltIn::Nonlinearity(Nonlinearity)")
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Nonlinearity"]
    }
    fn c(&self, _: &Parts<&str>, _: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(
            "            for (i = 0; i < 3; i++) {\n                const ironout_real square = measured_ut[i] * \
             measured_ut[i];\n                sum[i] += theta[i] * square + theta[3 + i] * square * measured_ut[i];\n            }\n",
        )
    }
}

impl<T: Real> Effect<T> for Nonlinearity {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "nonlinearity"
    }

    fn explanation(&self) -> &'static str {
        "The core or the amplifier of an axis begins to saturate. \
         The error of each axis depends on the square and the cube of its own reading."
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
        "1/µT (squares), 1/µT² (cubes)"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let square = at.measured_ut.map(|axis| axis * axis);
        let [x, y, z] = at.measured_ut;
        let [xx, yy, zz] = square;
        diagonal(square, 0, shape);
        diagonal([xx * x, yy * y, zz * z], 3, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }
}
