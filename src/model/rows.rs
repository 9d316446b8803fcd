//! The rows of a sample: residual and derivatives at the closest point.

use super::base::Model;
use super::sample::{NoRow, NotFinite, Observation, Residual, Term, delay_s};
use crate::effect::{Shape, no_shape};
use crate::math::{self, Real};
use crate::vector::{cross, dot, minus, norm, scaled, times, transposed_times, turned};

impl<T: Real> Model<T> {
    /// The rows of one sample: calls `push(row, residual)` once, or for the vector three times. `N` is the most terms, `P` the
    /// most columns. Nothing is pushed for the dip where the sample has no direction down.
    ///
    /// # Errors
    /// [`NoRow`] for a sample or a shape that is not finite, and for terms that there is no room for: a column that is left out
    /// would be a wrong fit.
    pub fn rows<const N: usize, const P: usize>(
        &self,
        residual: Residual,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
        push: impl FnMut(&[T; P], T),
    ) -> Result<(), NoRow> {
        self.rows_within::<N, P>(residual, reading, terms, P, push)
    }

    /// The same with a row's first `width` places.
    pub(crate) fn rows_within<const N: usize, const P: usize>(
        &self,
        residual: Residual,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
        width: usize,
        mut push: impl FnMut(&[T; P], T),
    ) -> Result<(), NoRow> {
        if terms.len() > N {
            return Err(NoRow::TooManyTerms { terms: terms.len(), most: N });
        }
        let mut shapes = [no_shape::<T>(); N];
        let measured = reading.measured_ut;
        if residual == Residual::Vector {
            let at = self.quantities(measured, minus(measured, self.offset_ut), reading.turn_radps);
            let disturbance = self.shapes(&at, terms.iter(), |_| true, &mut shapes)?;
            let left = minus(minus(measured, self.offset_ut), disturbance);
            for (axis, value) in left.into_iter().enumerate() {
                let mut unit = [T::zero(); 3];
                if let Some(entry) = unit.get_mut(axis) {
                    *entry = T::one();
                }
                let mut row = [T::zero(); P];
                fill(&mut row, width, &unit.map(|entry| -entry), unit, terms, &shapes)?;
                push(&row, value);
            }
            return if left.iter().all(|value| value.is_finite()) {
                Ok(())
            } else {
                Err(NotFinite::Sample.into())
            };
        }
        let (at, reaction) = self.at_closest(reading, terms, &mut shapes)?;
        let mut row = [T::zero(); P];
        if residual == Residual::Dip {
            let Some(down) = reading.down else { return Ok(()) };
            let h = times(&self.full, at.centred);
            // What is read now was so before the board turned on; turning `h` on is turning `down` back.
            let down = match (delay_s(terms), reading.turn_radps) {
                (Some(delay_s), Some(turn)) => turned(down, scaled(turn, delay_s)),
                _ => down,
            };
            let length = norm(h);
            let u = scaled(h, T::one() / length);
            let sine = dot(u, down);
            // The angle itself: a residual in sines would weigh the parameter into the scale of the residual.
            let cosine = |sine: T| (T::one() - sine * sine).max(T::of(0.01)).root();
            let (own, mean) = (cosine(sine), cosine(self.sin_dip));
            let [x, y, z] = scaled(cross(u, down), T::one() / own);
            let across = scaled(minus(down, scaled(u, sine)), T::one() / (length * own));
            let pull = reaction.answer(transposed_times(&self.full, across));
            fill(&mut row, width, &[x, y, z, -T::one() / mean], pull, terms, &shapes)?;
            let value = T::of(math::asin(sine.as_f64()) - math::asin(self.sin_dip.as_f64()));
            if !value.is_finite() {
                return Err(NotFinite::Sample.into());
            }
            push(&row, value);
            return Ok(());
        }
        let closest = minus(at.centred, self.closest(&at));
        let at_closest = times(&self.matrix, closest);
        let u = scaled(at_closest, T::one() / norm(at_closest));
        let pull = reaction.answer(transposed_times(&self.matrix, u));
        let grown = reaction.grown(pull);
        let [ax, ay, az, by, bz, cz] = self.through_turning(&reaction, pull, closest, reading.turn_radps);
        let moved = reaction.with_the_ellipsoid(pull);
        let pull = scaled(pull, grown);
        let [p, q, r] = reaction.of_offset(pull);
        let [a, b, c] = u;
        let [x, y, z] = closest;
        let still = [a * x, a * y, a * z, b * y, b * z, c * z].map(|column| column * moved);
        let turning = [ax, ay, az, by, bz, cz];
        let [ax, ay, az, by, bz, cz] = core::array::from_fn(|slot| (still[slot] + turning[slot]) * grown);
        fill(&mut row, width, &[-p, -q, -r, ax, ay, az, by, bz, cz], pull, terms, &shapes)?;
        push(&row, at.residual);
        Ok(())
    }
}

/// Base columns, then `−pull·Φ` of every term, into the first `width` places.
pub(super) fn fill<T: Real, const N: usize, const P: usize>(
    row: &mut [T; P],
    width: usize,
    base: &[T],
    pull: [T; 3],
    terms: &[Term<'_, T>],
    shapes: &[Shape<T>; N],
) -> Result<(), NoRow> {
    let columns = terms
        .iter()
        .zip(shapes)
        .flat_map(|(term, shape)| shape.iter().take(term.effect.coefficients()))
        .map(|vector| -dot(pull, *vector));
    let mut columns = base.iter().copied().chain(columns);
    for (slot, value) in row.iter_mut().take(width).zip(&mut columns) {
        *slot = value;
    }
    // Asked only afterwards, where it costs nothing.
    match columns.count() {
        0 => Ok(()),
        more => Err(NoRow::TooWide { columns: width.min(P).saturating_add(more), width: width.min(P) }),
    }
}
