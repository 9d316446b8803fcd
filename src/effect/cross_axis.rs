//! Cross-axis sensitivity.

use super::attitude;
use super::built_in::Typed;
use super::code::RustCode;
use super::definition::Effect;
use super::family::{Acts, Advice, Family, Follows, Group, Subject};
use super::parts::{Form, Parts};
use super::quantities::{MAX_INPUTS, Quantities, Shape};
use crate::math::Real;
use core::fmt;

/// `cross-axis`: products of axes, the cross-field effect of magnetoresistive bridges.
///
/// Seven shapes, as many quadratic ones as the magnitude can tell apart: `xy` and `xz` on x, `xy` and `yz` on y, `xz`
/// and `yz` on z, and `yz` on x. They contain most of the squares of the nonlinearity as far as the magnitude
/// sees them; of the two the one with fewer coefficients is preferred.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CrossAxis;

const KIND: &str = "cross-axis";

const FORM: Form = Form { tag: 12, coefficients: 7, ..Form::PLAIN };

impl<C: Copy + Default> Typed<C> for CrossAxis {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(_: &Parts<C>) -> Self {
        CrossAxis
    }

    fn parts(&self) -> Parts<C> {
        Parts::of(&FORM)
    }
}

/// The products of axes.
pub struct CrossAxes;

impl Family for CrossAxes {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, _: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&CrossAxis);
    }
    fn follows(&self) -> Follows {
        Follows::Attitude
    }
    fn acts(&self) -> Acts {
        Acts::Measured
    }
    fn groups(&self, _: &Form) -> &'static [Group] {
        &[
            Group::Row { label: "on x", names: &["xy", "xz"], from: 0, unit: "1/µT" },
            Group::Row { label: "on y", names: &["xy", "yz"], from: 2, unit: "1/µT" },
            Group::Row { label: "on z", names: &["xz", "yz"], from: 4, unit: "1/µT" },
            Group::Row { label: "on x too", names: &["yz"], from: 6, unit: "1/µT" },
        ]
    }
    fn one_scale(&self) -> bool {
        true
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        attitude::apart(own, other)
    }
    fn rust(&self, _: &Parts<&str>, _: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("BuiltIn::CrossAxis(CrossAxis)")
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "CrossAxis"]
    }
    fn c(&self, _: &Parts<&str>, _: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(
            "            const ironout_real xy = measured_ut[0] * measured_ut[1], xz = measured_ut[0] * measured_ut[2], yz \
             = \
             measured_ut[1] * measured_ut[2];\n            sum[0] += theta[0] * xy + theta[1] * xz + theta[6] * yz;\n            \
             sum[1] += theta[2] * xy + theta[3] * yz;\n            sum[2] += theta[4] * xz + theta[5] * yz;\n",
        )
    }
}

impl<T: Real> Effect<T> for CrossAxis {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "cross-axis sensitivity"
    }

    fn explanation(&self) -> &'static str {
        "The field across a magnetoresistive bridge changes its sensitivity along it. \
         The error of each axis is a sum of products of the readings of different axes."
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
        "1/µT"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let zero = T::zero();
        let [x, y, z] = at.measured_ut;
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let [a, b, c, d, e, f, g, ..] = shape;
        *a = [xy, zero, zero];
        *b = [xz, zero, zero];
        *c = [zero, xy, zero];
        *d = [zero, yz, zero];
        *e = [zero, zero, xz];
        *f = [zero, zero, yz];
        *g = [yz, zero, zero];
    }

    fn reads_centre(&self) -> bool {
        false
    }
}
