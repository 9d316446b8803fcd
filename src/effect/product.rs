//! An additive field that follows the product of two columns.

use super::apart;
use super::built_in::Typed;
use super::code::{CNumber, RustCode, c_along};
use super::definition::Effect;
use super::family::{Advice, Amount, Family, Follows, Subject};
use super::parts::{Form, Parts, Zero};
use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape, along, isotropic};
use crate::math::Real;
use core::fmt;

/// `product:ONE*OTHER`: `Φ = I₃·(u − u₀)·v`, `u` the first column and `v` the second.
///
/// A current in a wire that moves with a gimbal: the vector per ampere changes with the angle. `offset:OTHER` is the field at the reference
/// angle, and this effect is what each unit of the first column adds to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Product<C, T> {
    /// Both columns, with a `*` between them: as `&str`, or as a [`super::ColumnName`] that owns it.
    pub columns: C,
    /// Value of the first column at which the effect vanishes.
    pub reference: T,
}

const KIND: &str = "product";

/// What stands between two columns.
const TIMES: u8 = b'*';

// A search offers it by heredity only, for pairs of columns.
const FORM: Form = Form { tag: 16, column: true, zero: Zero::Column, offered: false, ..Form::PLAIN };

/// The two columns of `ONE*OTHER`.
fn pair(columns: &str) -> Option<(&str, &str)> {
    // By bytes: a search for a character is three kilobytes on a board.
    let at = columns.bytes().position(|byte| byte == TIMES)?;
    let (one, other) = (columns.get(..at)?, columns.get(at + 1..)?);
    (!one.is_empty() && !other.is_empty() && !other.bytes().any(|byte| byte == TIMES)).then_some((one, other))
}

fn both<T: Real>(columns: &str) -> [Option<Column<'_, T>>; MAX_INPUTS] {
    pair(columns).map_or([None, None], |(one, other)| [Some(Column::now(one)), Some(Column::now(other))])
}

impl<C: Copy, T: Real> Typed<C> for Product<C, T> {
    const FORMS: &'static [&'static Form] = &[&FORM];

    fn of(parts: &Parts<C>) -> Self {
        Product { columns: parts.column, reference: T::of(parts.reference) }
    }

    fn parts(&self) -> Parts<C> {
        Parts { form: &FORM, column: self.columns, reference: self.reference.as_f64(), parameter: 0.0 }
    }
}

/// All products of two columns.
pub struct Products;

impl Family for Products {
    fn kind(&self) -> &'static str {
        KIND
    }
    fn forms(&self) -> &'static [&'static Form] {
        &[&FORM]
    }
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>)) {
        use_it(&Product::<&str, f64>::of(parts));
    }
    fn follows(&self) -> Follows {
        Follows::Column
    }
    fn columns<'p>(&self, parts: &Parts<&'p str>) -> [Option<Column<'p, f64>>; MAX_INPUTS] {
        both(parts.column)
    }
    fn suits(&self, column: &str) -> bool {
        pair(column).is_some()
    }
    fn amount(&self) -> Amount {
        Amount::Untold
    }
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        apart::apart(own, other)
    }
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result {
        let (columns, reference) = (code.column, code.number(parts.reference));
        write!(out, "BuiltIn::Product(Product {{ columns: {columns}, reference: {reference} }})")
    }
    fn rust_names(&self, _: &Parts<&str>) -> &'static [&'static str] {
        &["BuiltIn", "Product"]
    }
    fn c(
        &self,
        parts: &Parts<&str>,
        [one, other]: [&str; MAX_INPUTS],
        out: &mut dyn fmt::Write,
    ) -> fmt::Result {
        c_along(out, format_args!("({one} - {}) * {other}", CNumber(parts.reference)), "")
    }
}

impl<C: AsRef<str>, T: Real> Effect<T> for Product<C, T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "{KIND}:{}", self.columns.as_ref())
    }

    fn name(&self) -> &'static str {
        "offset proportional to a product of two columns"
    }

    fn explanation(&self) -> &'static str {
        "The field of one column depends on the other, as the field of a current in a wire that moves with a gimbal. \
         It adds a vector of fixed direction, proportional to the product."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        both(self.columns.as_ref())
    }

    fn coefficients(&self) -> usize {
        FORM.coefficients
    }

    fn unit(&self) -> &'static str {
        "µT per unit²"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [one, other] = at.inputs;
        isotropic((one - self.reference) * other, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let [one, other] = at.inputs;
        along((one - self.reference) * other, coefficients)
    }
}

#[cfg(test)]
mod tests {
    use super::{Effect, Product, Quantities};

    #[test]
    fn it_reads_two_columns_and_vanishes_at_the_reference_of_the_first() {
        let effect = Product { columns: "servo*current_a", reference: 30.0 };
        let names = Effect::<f64>::columns(&effect).map(|column| column.map(|column| column.name));
        assert_eq!(names, [Some("servo"), Some("current_a")]);
        let theta = [0.5, -1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let at = |inputs| Quantities { inputs, ..Quantities::of_vector([20.0, 5.0, -40.0]) };
        assert_eq!(effect.disturbance(&at([33.0, 4.0]), &theta), [6.0, -12.0, 24.0]);
        assert_eq!(effect.disturbance(&at([30.0, 4.0]), &theta), [0.0; 3]);
        for name in ["servo", "*servo", "servo*", "a*b*c"] {
            let one = Product { columns: name, reference: 0.0 };
            assert_eq!(Effect::<f64>::columns(&one), [None, None], "{name}");
        }
    }
}
