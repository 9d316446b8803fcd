//! Soft iron that follows a column.

use super::apart;
use super::built_in::Typed;
use super::code::{CNumber, RustCode};
use super::columns::ColumnKind as Kind;
use super::definition::Effect;
use super::family::{Acts, Advice, Amount, Family, Follows, Group, Subject};
use super::parts::{Form, Parts, Zero};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape};
use crate::math::Real;
use core::fmt;

/// `soft-iron:COLUMN`: `Φ θ = S (ĥ − b)·(u − u₀)` with a symmetric 3×3 matrix `S` of the coefficients xx, yy, zz, xy, xz, yz.
///
/// Steel that comes near and goes away again, with a gripper, a payload or a lid, bends the field by a matrix of its own. What of
/// that matrix is a rotation no magnitude shows: it is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftIron<C, T> {
    /// The column: its name as `&str`, or as a [`super::ColumnName`] that owns it.
    pub column: C,
    /// Value of the column at which the effect vanishes.
    pub reference: T,
}

const KIND: &str = "soft-iron";

// No search offers it: a gain that acts in the field looks like its diagonal.
const FORM: Form =
    Form { tag: 15, column: true, coefficients: 6, zero: Zero::Column, offered: false, ..Form::PLAIN };

/// Row and column of each coefficient in `S`.
#[cfg(test)]
const PLACES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl<C: Copy, T: Real> Typed<C> for SoftIron<C, T> {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        SoftIron { column: parts.column, reference: T::of(parts.reference) }
    }

    fn parts(&self) -> Parts<C> {
        Parts { form: &FORM, column: self.column, reference: self.reference.as_f64(), parameter: 0.0 }
    }
}

/// All soft iron that follows columns.
pub struct SoftIrons;

impl Family for SoftIrons {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&SoftIron::<&str, f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Column
    }
    fn acts(&self) -> Acts {
        Acts::Field
    }
    fn suits(&self, column: &str) -> bool {
        // Warmth moves no steel: what follows it is the sensor's own gain.
        Kind::of(column) != Kind::Temperature
    }
    fn groups(&self, _: &Form) -> &'static [Group] {
        const UNIT: &str = "1 per unit";
        &[
            Group::Row { label: "along axes", names: &["xx", "yy", "zz"], from: 0, unit: UNIT },
            Group::Row { label: "across", names: &["xy", "xz", "yz"], from: 3, unit: UNIT },
        ]
    }
    fn one_scale(&self) -> bool {
        true
    }
    fn amount(&self) -> Amount {
        Amount::Share
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        apart::apart(own, other)
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        let (column, reference) = (code.column, code.number(parts.reference));
        write!(out, "BuiltIn::SoftIron(SoftIron {{ column: {column}, reference: {reference} }})")
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "SoftIron"]
    }
    fn c(
        &self,
        parts: &Parts<&str>,
        [input, _]: [&str; MAX_INPUTS],
        out: &mut dyn fmt::Write,
    ) -> fmt::Result {
        writeln!(out, "            const ironout_real value = {input} - {};", CNumber(parts.reference))?;
        for (axis, [x, y, z]) in [[0, 3, 4], [3, 1, 5], [4, 5, 2]].into_iter().enumerate() {
            writeln!(
                out,
                "            sum[{axis}] += value * (theta[{x}] * left[0] + theta[{y}] * left[1] + theta[{z}] * left[2]);"
            )?;
        }
        Ok(())
    }
}

impl<C: AsRef<str>, T: Real> Effect<T> for SoftIron<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "{KIND}:{}", self.column.as_ref())
    }

    fn name(&self) -> &'static str {
        "soft iron with a column"
    }

    fn explanation(&self) -> &'static str {
        "The amount of steel or ferrite near the sensor changes with this column, or its magnetisation does. \
         It bends and stretches the field by a matrix of its own."
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
        let [x, y, z] = at.centred_ut.map(|axis| axis * (input - self.reference));
        let zero = T::zero();
        let columns =
            [[x, zero, zero], [zero, y, zero], [zero, zero, z], [y, x, zero], [z, zero, x], [zero, z, y]];
        for (slot, column) in shape.iter_mut().zip(columns) {
            *slot = column;
        }
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let [input, _] = at.inputs;
        let [x, y, z] = at.centred_ut.map(|axis| axis * (input - self.reference));
        let [xx, yy, zz, xy, xz, yz, ..] = *coefficients;
        [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
    }
}

#[cfg(test)]
mod tests {
    use super::super::quantities::no_shape;
    use super::{Effect, PLACES, Quantities, SoftIron};

    #[test]
    fn the_matrix_is_symmetric_and_the_shape_says_the_same() {
        let effect = SoftIron { column: "lid", reference: 1.0 };
        let theta = [0.1, -0.2, 0.3, 0.04, -0.05, 0.06, 0.0, 0.0, 0.0];
        let field = [20.0, -10.0, 40.0];
        let at = Quantities { inputs: [3.0, 0.0], ..Quantities::of_vector(field) };
        let mut expected = [0.0; 3];
        for ((row, column), value) in PLACES.into_iter().zip(theta) {
            expected[row] += 2.0 * value * field[column];
            if row != column {
                expected[column] += 2.0 * value * field[row];
            }
        }
        let mut shape = no_shape();
        effect.shape(&at, &mut shape);
        for axis in 0..3 {
            let sum: f64 = shape.iter().zip(theta).map(|(vector, value)| vector[axis] * value).sum();
            let own = effect.disturbance(&at, &theta)[axis];
            assert!((own - expected[axis]).abs() < 1e-12 && (sum - expected[axis]).abs() < 1e-12);
        }
    }
}
