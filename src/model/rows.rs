//! The rows of a sample: residual and derivatives at the foot point.

use super::base::Model;
use super::sample::{NotFinite, Observation, Residual, Term};
use crate::effect::{Shape, no_shape};
use crate::math::{self, Real};
use crate::vector::{cross, dot, minus, norm, scaled, times, transposed_times};

impl<T: Real> Model<T> {
    /// The rows of one sample: calls `push(row, residual)` once, or for the vector three times. `N` is the most terms
    /// that are read. Nothing is pushed for the dip where the sample has no direction down.
    pub fn rows<const N: usize, const P: usize>(
        &self,
        residual: Residual,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
        mut push: impl FnMut(&[T; P], T),
    ) -> Result<(), NotFinite> {
        let mut shapes = [no_shape::<T>(); N];
        let measured = reading.measured_ut;
        if residual == Residual::Vector {
            let at = self.quantities(measured, minus(measured, self.offset_ut), reading.turn_radps);
            let disturbance = self.shapes(&at, terms.iter(), &mut shapes)?;
            let left = minus(minus(measured, self.offset_ut), disturbance);
            for (axis, value) in left.into_iter().enumerate() {
                let mut unit = [T::zero(); 3];
                if let Some(entry) = unit.get_mut(axis) {
                    *entry = T::one();
                }
                let mut row = [T::zero(); P];
                fill(&mut row, &unit.map(|entry| -entry), unit, terms, &shapes);
                push(&row, value);
            }
            return if left.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(NotFinite::Sample) };
        }
        let (at, reaction) = self.at_foot(reading, terms, &mut shapes)?;
        let mut row = [T::zero(); P];
        if residual == Residual::Dip {
            let Some(down) = reading.down else { return Ok(()) };
            let h = times(&self.full, at.centred);
            let length = norm(h);
            let u = scaled(h, T::one() / length);
            let sine = dot(u, down);
            // The angle itself: a residual in sines would weigh the parameter into the scale of the residual.
            let cosine = |sine: T| (T::one() - sine * sine).max(T::of(0.01)).root();
            let (own, mean) = (cosine(sine), cosine(self.sin_dip));
            let [x, y, z] = scaled(cross(u, down), T::one() / own);
            let across = scaled(minus(down, scaled(u, sine)), T::one() / (length * own));
            let pull = reaction.answer(transposed_times(&self.full, across));
            fill(&mut row, &[x, y, z, -T::one() / mean], pull, terms, &shapes);
            let value = T::of(math::asin(sine.as_f64()) - math::asin(self.sin_dip.as_f64()));
            if !value.is_finite() {
                return Err(NotFinite::Sample);
            }
            push(&row, value);
            return Ok(());
        }
        let foot = minus(at.centred, self.foot(&at));
        let at_foot = times(&self.matrix, foot);
        let u = scaled(at_foot, T::one() / norm(at_foot));
        let pull = reaction.answer(transposed_times(&self.matrix, u));
        let grown = reaction.grown(pull);
        let [ax, ay, az, by, bz, cz] = self.through_turning(&reaction, pull, foot, reading.turn_radps);
        let pull = scaled(pull, grown);
        let [p, q, r] = pull;
        let [a, b, c] = u;
        let [x, y, z] = foot;
        let triangle = [a * x + ax, a * y + ay, a * z + az, b * y + by, b * z + bz, c * z + cz];
        let [ax, ay, az, by, bz, cz] = triangle.map(|column| column * grown);
        fill(&mut row, &[-p, -q, -r, ax, ay, az, by, bz, cz], pull, terms, &shapes);
        push(&row, at.residual);
        Ok(())
    }
}

/// Base columns, then `−pull·Φ` of every term.
fn fill<T: Real, const N: usize, const P: usize>(
    row: &mut [T; P],
    base: &[T],
    pull: [T; 3],
    terms: &[Term<'_, T>],
    shapes: &[Shape<T>; N],
) {
    let columns = terms
        .iter()
        .zip(shapes)
        .flat_map(|(term, shape)| shape.iter().take(term.effect.coefficients()))
        .map(|vector| -dot(pull, *vector));
    for (slot, value) in row.iter_mut().zip(base.iter().copied().chain(columns)) {
        *slot = value;
    }
}
