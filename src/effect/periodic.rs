//! Periodic interference.

use super::built_in::Typed;
use super::code::RustCode;
use super::definition::Effect;
use super::family::{Advice, Family, Follows, Group, Subject};
use super::parts::{Form, Parts, Searched, Zero};
use super::quantities::{Column, MAX_INPUTS, Quantities, Shape, TIME, diagonal};
use crate::math::{self, Real};
use crate::number::Num;
use core::f64::consts::TAU;
use core::fmt;

/// `periodic`: `Φ = [I₃ sin ω(t − t₀) | I₃ cos ω(t − t₀)]`: mains, or a motor's fundamental, aliased by sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// ω/2π, Hz.
    pub frequency_hz: f64,
    /// t₀, s.
    pub reference_s: f64,
}

const KIND: &str = "periodic";

const FORM: Form =
    Form { tag: 13, coefficients: 6, zero: Zero::Time, searched: Some(Searched::Frequency), ..Form::PLAIN };

impl<C: Copy + Default> Typed<C> for Periodic {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        Periodic { frequency_hz: parts.parameter, reference_s: parts.reference }
    }

    fn parts(&self) -> Parts<C> {
        Parts { reference: self.reference_s, parameter: self.frequency_hz, ..Parts::of(&FORM) }
    }
}

/// The tone.
pub struct Tones;

impl Family for Tones {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&<Periodic as Typed<&str>>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Tone
    }
    fn groups(&self, _: &Form) -> &'static [Group] {
        &[Group::Amplitude { label: "amplitude", sines: 0, cosines: 3, unit: "µT" }]
    }
    fn word(&self) -> &'static str {
        "tone"
    }
    fn apart<'a>(&self, _: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        let text = match other.follows {
            Follows::Column => {
                "log {0} and the field at another sampling rate: an aliased frequency moves, {0} does not."
            }
            Follows::Turning => return None,
            _ => "record again at another sampling rate: an aliased frequency moves.",
        };
        Some(Advice { text, names: [other.column, ""] })
    }
    fn rust(&self, parts: &Parts<&str>, _: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        let (reference, parameter) = (Num(parts.reference), Num(parts.parameter));
        write!(
            out,
            "BuiltIn::Periodic(Periodic {{ frequency_hz: {parameter:?}, reference_s: {reference:?} }})"
        )
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Periodic"]
    }
    fn c(&self, parts: &Parts<&str>, [time, _]: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        let (reference, parameter) = (Num(parts.reference), Num(parts.parameter));
        write!(
            out,
            "            const double turns = {parameter:?} * ({time} - {reference:?});\n            const double phase = \
             6.283185307179586 * (turns - floor(turns));\n            for (i = 0; i < 3; i++) {{\n                \
             sum[i] += theta[i] * (ironout_real)sin(phase) + theta[3 + i] * (ironout_real)cos(phase);\n            }}\n"
        )
    }
    fn c_needs_math(&self) -> bool {
        true
    }
}

impl<T: Real> Effect<T> for Periodic {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(KIND)
    }

    fn name(&self) -> &'static str {
        "periodic interference"
    }

    fn explanation(&self) -> &'static str {
        "Mains wiring or a rotating motor adds an alternating field. In the log it appears at its own frequency, or aliased \
         below half the sampling rate."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
        "µT (sine, then cosine)"
    }

    /// The time of the same phase in the first period of the clock.
    fn time_s(&self, now_s: f64) -> f64 {
        let turns = self.frequency_hz * now_s;
        let first = (turns - math::floor(turns)) / self.frequency_hz;
        // A frequency of zero has no period.
        if first.is_finite() { first } else { now_s }
    }

    fn repeats(&self) -> bool {
        true
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [time, _] = at.inputs;
        // Whole turns removed in double precision before the sine.
        let turns = self.frequency_hz * (time.as_f64() - self.reference_s);
        let phase = TAU * (turns - math::floor(turns));
        let (sine, cosine) = math::sin_cos(phase);
        diagonal([T::of(sine); 3], 0, shape);
        diagonal([T::of(cosine); 3], 3, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }
}
