//! `servo:COLUMN`: a servo's magnet turns with its arm.

use ironout::effect::{
    Advice, Column, Effect, Family, Follows, Form, Group, MAX_INPUTS, Parts, Quantities, RustCode, Shape,
    Subject, Zero,
};
use ironout::math::{self, Real};
use std::fmt;

/// `servo:COLUMN`, the column the arm's angle in radians: `Φ` turns in the
/// board's x-y plane, along the arm and across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo<C> {
    /// The column: its name as `&str`, or as a `ColumnName` that owns it.
    pub column: C,
}

// The numbers: all that the fit, the study and the live correction see, on a board too.
impl<C: AsRef<str>, T: Real> Effect<T> for Servo<C> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "servo:{}", self.column.as_ref())
    }
    fn name(&self) -> &'static str {
        "servo magnet"
    }
    fn explanation(&self) -> &'static str {
        "The servo's magnet turns with its arm. Its field at the sensor turns with it, at constant strength."
    }
    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(self.column.as_ref())), None]
    }
    fn coefficients(&self) -> usize {
        FORM.coefficients
    }
    fn unit(&self) -> &'static str {
        "µT"
    }
    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [angle, _] = at.inputs;
        let (sin, cos) = (T::of(math::sin(angle.as_f64())), T::of(math::cos(angle.as_f64())));
        let [along, across, ..] = shape;
        *along = [cos, sin, T::zero()];
        *across = [-sin, cos, T::zero()];
    }
    fn reads_centre(&self) -> bool {
        false
    }
}

const FORM: Form = Form { column: true, coefficients: 2, zero: Zero::None, ..Form::PLAIN };

/// All servos.
pub struct Servos;

// Everything else that a program asks.
impl Family for Servos {
    fn kind(&self) -> &'static str {
        "servo"
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Servo { column: parts.column });
    }
    fn follows(&self) -> Follows {
        Follows::Column
    }
    fn groups(&self, _: &Form) -> &'static [Group] {
        &[
            Group::Row { label: "along the arm", names: &[""], from: 0, unit: "µT" },
            Group::Row { label: "across it", names: &[""], from: 1, unit: "µT" },
        ]
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        let text = match other.follows {
            Follows::Column if other.column == own.column => {
                "turn {0} through a whole circle: a magnet on the arm comes back, what is in proportion does not."
            }
            Follows::Column => "log again, turning {0} while {1} stays.",
            _ => "log again, turning {0} to and fro several times while the board turns.",
        };
        Some(Advice { text, names: [own.column, other.column] })
    }
    fn rust(&self, _: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "Servo {{ column: {} }}", code.column)
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["Servo"]
    }
    fn rust_module(&self) -> &'static str {
        "own_effect"
    }
    fn c(&self, _: &Parts<&str>, [angle, _]: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result {
        writeln!(
            out,
            "            const ironout_real s = (ironout_real)sin({angle}), c = (ironout_real)cos({angle});"
        )?;
        writeln!(out, "            sum[0] += theta[0] * c - theta[1] * s;")?;
        writeln!(out, "            sum[1] += theta[0] * s + theta[1] * c;")
    }
    fn c_needs_math(&self) -> bool {
        true
    }
}
