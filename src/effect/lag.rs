//! The sensor is late: as a pure delay, or with eddy currents through a coupling of the axes.

use super::built_in::Typed;
use super::code::RustCode;
use super::definition::Effect;
use super::family::{AXES, Acts, Advice, Family, Follows, Group, Subject};
use super::parts::{Form, Parts};
use super::quantities::{Coefficients, MAX_INPUTS, Quantities, Shape};
use crate::math::Real;
use crate::vector::dot;
use core::fmt;

const KIND: &str = "lag";

const DELAY: Form = Form { tag: 9, coefficients: 1, dip_only: true, ..Form::PLAIN };
const COUPLING: Form = Form { tag: 10, coefficients: 9, ..Form::PLAIN };

/// `lag`: `ĥ(t) = A h(t − τ) + b` with `h(t − τ) = exp([ω]τ) h(t)`, k = 1, the coefficient is τ; its derivative is
/// `Φ = A (ω × h)`.
///
/// The correction turns the vector back by what the board turned meanwhile: every late point still lies on the ellipsoid,
/// so the magnitude cannot see it; the dip can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Lag;

impl<T: Real> Effect<T> for Lag {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "sensor lag"
    }

    fn explanation(&self) -> &'static str {
        "The sensor's filter or its bus delays the reading relative to the other sensors. During rotation the measured \
         direction trails the true one."
    }

    fn needs_gyro(&self) -> bool {
        true
    }

    fn coefficients(&self) -> usize {
        DELAY.coefficients
    }

    fn unit(&self) -> &'static str {
        "s"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [first, ..] = shape;
        *first = at.turning_ut_per_s;
    }

    fn reads_centre(&self) -> bool {
        // It takes nothing off the vector that it turns.
        false
    }

    #[inline]
    fn delay_s(&self, [delay, ..]: &Coefficients<T>) -> Option<T> {
        Some(*delay)
    }

    #[inline]
    fn disturbance(&self, _: &Quantities<T>, _: &Coefficients<T>) -> [T; 3] {
        [T::zero(); 3]
    }
}

impl<C: Copy + Default> Typed<C> for Lag {
    const FORMS: &'static [&'static Form] = &[&DELAY];

    fn of(_: &Parts<C>) -> Self {
        Lag
    }

    fn parts(&self) -> Parts<C> {
        Parts::of(&DELAY)
    }
}

/// `lag` too: a 3×3 coupling `E` to the turning field, `Φ θ = E·A (ω × h)`, rows first. Its share along the identity is
/// a pure delay ([`Lag`]), which only the dip sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Eddy;

impl<T: Real> Effect<T> for Eddy {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "lag and eddy currents"
    }

    fn explanation(&self) -> &'static str {
        "A rotating field induces eddy currents in metal plates near the sensor, and filters delay it. The error is \
         proportional to the rotation rate of the field, through a 3×3 coupling."
    }

    fn needs_gyro(&self) -> bool {
        true
    }

    fn coefficients(&self) -> usize {
        COUPLING.coefficients
    }

    fn unit(&self) -> &'static str {
        "s"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let zero = T::zero();
        let [x, y, z] = at.turning_ut_per_s;
        *shape = [
            [x, zero, zero],
            [y, zero, zero],
            [z, zero, zero],
            [zero, x, zero],
            [zero, y, zero],
            [zero, z, zero],
            [zero, zero, x],
            [zero, zero, y],
            [zero, zero, z],
        ];
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let [a, b, c, d, e, f, g, h, i] = *coefficients;
        let turning = at.turning_ut_per_s;
        [[a, b, c], [d, e, f], [g, h, i]].map(|row| dot(row, turning))
    }
}

impl<C: Copy + Default> Typed<C> for Eddy {
    const FORMS: &'static [&'static Form] = &[&COUPLING];

    fn of(_: &Parts<C>) -> Self {
        Eddy
    }

    fn parts(&self) -> Parts<C> {
        Parts::of(&COUPLING)
    }
}

/// Both shapes of a late sensor: the coupling first, of which the delay is the share that the magnitude hides.
pub struct Lags;

impl Family for Lags {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&COUPLING, &DELAY]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        if parts.form.dip_only { use_it(&Lag) } else { use_it(&Eddy) }
    }
    fn follows(&self) -> Follows {
        Follows::Turning
    }
    fn acts(&self) -> Acts {
        Acts::Turning
    }
    fn without_down(&self) -> &'static str {
        "a pure delay does not change the magnitude, so it needs an accelerometer: log ax_mps2,ay_mps2,az_mps2 (eddy \
         currents were tested)"
    }
    fn delay_coefficients(&self, form: &Form) -> &'static [usize] {
        if form.dip_only { &[0] } else { &[0, 4, 8] }
    }
    fn groups(&self, form: &Form) -> &'static [Group] {
        const DELAYED: &[Group] = &[Group::Row { label: "delay", names: &[""], from: 0, unit: "s" }];
        const COUPLED: &[Group] = &[
            Group::Row { label: "coupled to x", names: AXES, from: 0, unit: "s" },
            Group::Row { label: "to y", names: AXES, from: 3, unit: "s" },
            Group::Row { label: "to z", names: AXES, from: 6, unit: "s" },
            Group::Mean {
                label: "delay",
                of: &[0, 4, 8],
                factor: 1e3,
                unit: "ms (the part that is a pure delay)",
            },
        ];
        if form.dip_only { DELAYED } else { COUPLED }
    }
    fn one_scale(&self) -> bool {
        true
    }
    fn apart<'a>(&self, _: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        let text = match other.follows {
            Follows::Attitude => {
                "move through the same directions once slowly and once fast: only lag and eddy currents depend on the speed."
            }
            _ => {
                "rotate once slowly and once fast, in both directions: only lag and eddy currents change with the speed."
            }
        };
        Some(Advice { text, names: [""; 2] })
    }
    fn rust(&self, parts: &Parts<&str>, _: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(if parts.form.dip_only { "BuiltIn::Lag(Lag)" } else { "BuiltIn::Eddy(Eddy)" })
    }
    fn rust_names(&self, parts: &Parts<&str>) -> &'static [&'static str] {
        if parts.form.dip_only { &["BuiltIn", "Lag"] } else { &["BuiltIn", "Eddy"] }
    }
    fn c(&self, parts: &Parts<&str>, _: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        if parts.form.dip_only {
            // Nothing is taken off: the corrected vector is turned.
            return Ok(());
        }
        out.write_str(
            "            for (i = 0; i < 3; i++) \
             {\n                sum[i] += theta[3 * i] * turning[0] + theta[3 * i + 1] * \
             turning[1] + theta[3 * i + 2] * turning[2];\n            }\n",
        )
    }
}
