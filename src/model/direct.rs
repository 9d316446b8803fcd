//! The rows of a sample with its shapes at the reading itself.

use super::base::Model;
use super::rows::fill;
use super::sample::{NoRow, NotFinite, Observation, Term};
use crate::effect::no_shape;
use crate::math::Real;
use crate::vector::{minus, norm, scaled, times};

impl<T: Real> Model<T> {
    /// The row of the magnitude with all shapes taken at the measured vector: there the disturbance is linear in the
    /// coefficients, and a fit comes from far where one at the foot point, which moves with what is fitted, does not. Noise
    /// correlates with these columns, so that what they end at is a place to begin, and no test.
    ///
    /// # Errors
    /// As [`Model::rows`].
    pub fn direct_rows<const N: usize, const P: usize>(
        &self,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
        mut push: impl FnMut(&[T; P], T),
    ) -> Result<(), NoRow> {
        if terms.len() > N {
            return Err(NoRow::TooManyTerms { terms: terms.len(), most: N });
        }
        let mut shapes = [no_shape::<T>(); N];
        let measured = reading.measured_ut;
        let at = self.quantities(measured, minus(measured, self.offset_ut), reading.turn_radps);
        let disturbance = self.shapes(&at, terms.iter(), &mut shapes)?;
        let at = self.linearise(measured, disturbance).ok_or(NotFinite::Sample)?;
        let h = times(&self.matrix, at.centred);
        let [a, b, c] = scaled(h, T::one() / norm(h));
        let ([x, y, z], [p, q, r]) = (at.centred, at.pull);
        let base = [-p, -q, -r, a * x, a * y, a * z, b * y, b * z, c * z];
        let mut row = [T::zero(); P];
        fill(&mut row, P, &base, at.pull, terms, &shapes)?;
        push(&row, at.residual);
        Ok(())
    }
}
