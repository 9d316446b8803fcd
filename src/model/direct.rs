//! The rows of a sample with its shapes at the reading itself.

use super::base::Model;
use super::rows::fill;
use super::sample::{NoRow, NotFinite, Observation, Term};
use crate::effect::no_shape;
use crate::math::Real;
use crate::vector::{minus, norm, scaled, times};

impl<T: Real> Model<T> {
    /// The row of the magnitude with all shapes taken at the measured vector: there the disturbance is linear in the
    /// coefficients, and a fit comes from far where one at the closest point, which moves with what is fitted, does not. Noise
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
        let disturbance = self.shapes(&at, terms.iter(), |_| true, &mut shapes)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{MAX_COEFFICIENTS, Nonlinearity};

    const WIDTH: usize = 15;

    fn model() -> Model<f64> {
        let matrix = [[1.05, 0.03, -0.02], [0.0, 0.97, 0.04], [0.0, 0.0, 1.01]];
        let turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Model::new([4.0, -7.0, 11.0], matrix, 50.0, turned, 0.6).expect("a model")
    }

    fn row(model: &Model<f64>, coefficients: [f64; MAX_COEFFICIENTS]) -> ([f64; WIDTH], f64) {
        let reading = Observation { measured_ut: [31.0, -24.0, 40.0], turn_radps: None, down: None };
        let term = Term { effect: &Nonlinearity, coefficients, inputs: [0.0; 2] };
        let mut out = None;
        model.direct_rows::<1, WIDTH>(&reading, &[term], |row, r| out = Some((*row, r))).expect("a row");
        out.expect("one row")
    }

    #[test]
    fn a_row_holds_the_slopes_of_its_residual() {
        let mut coefficients = [0.0; MAX_COEFFICIENTS];
        coefficients[..6].copy_from_slice(&[2e-4, -1e-4, 3e-4, 4e-6, 2e-6, -3e-6]);
        let (row_here, here) = row(&model(), coefficients);
        for column in 0..WIDTH {
            let step = if column < 9 { 1e-6 } else { 1e-10 };
            let mut delta = [0.0; WIDTH];
            delta[column] = step;
            let mut moved = coefficients;
            (0..6).for_each(|index| moved[index] += delta[9 + index]);
            let (_, there) = row(&model().stepped(&delta).expect("a model"), moved);
            let slope = (there - here) / step;
            assert!((slope - row_here[column]).abs() < 1e-4 * (1.0 + slope.abs()), "{column}: {slope}");
        }
    }

    #[test]
    fn more_terms_than_there_is_room_for_are_refused() {
        let reading = Observation { measured_ut: [31.0, -24.0, 40.0], turn_radps: None, down: None };
        let term = Term { effect: &Nonlinearity, coefficients: [0.0; MAX_COEFFICIENTS], inputs: [0.0; 2] };
        let done = model().direct_rows::<1, WIDTH>(&reading, &[term, term], |_, _| {});
        assert_eq!(done, Err(NoRow::TooManyTerms { terms: 2, most: 1 }));
    }
}
