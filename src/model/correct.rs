//! The correction, as the model has it.

use super::base::Model;
use super::fixed_point::settle;
use super::sample::{NotFinite, Observation, Term, delay_s};
use crate::effect::no_shape;
use crate::math::Real;
use crate::vector::{minus, scaled, times, turned};

impl<T: Real> Model<T> {
    /// The corrected field of one sample in the accelerometer's frame, µT: what
    /// [`ExtendedCalibration::apply`](crate::extended::ExtendedCalibration::apply) gives. Where an effect reads the centre,
    /// the disturbance is looked at until it stands, as there.
    pub fn correct(&self, reading: &Observation<T>, terms: &[Term<'_, T>]) -> Result<[T; 3], NotFinite> {
        let measured = reading.measured_ut;
        let centred = minus(measured, self.offset_ut);
        let mut shape = [no_shape::<T>(); 1];
        let again = terms.iter().any(Term::reads_centre);
        let left = settle(centred, again, |point| {
            let at = self.quantities(measured, point, reading.turn_radps);
            let mut left = centred;
            for (index, term) in terms.iter().enumerate() {
                let one = self
                    .shapes(&at, core::iter::once(term), |_| true, &mut shape)
                    .map_err(|_| NotFinite::Effect(index))?;
                left = minus(left, one);
            }
            Ok(left)
        })?;
        let corrected = times(&self.full, left);
        // The board turned since what is read now.
        Ok(match (delay_s(terms), reading.turn_radps) {
            (Some(delay_s), Some(turn)) => turned(corrected, scaled(turn, -delay_s)),
            _ => corrected,
        })
    }
}
