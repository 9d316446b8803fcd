//! Offset, matrix and effects together.

use super::correction::{Conditions, NotCorrected, Prepared, correct};
use super::fitted::{Effects, FittedEffect};
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, Effect, InParts};
use crate::math::Real;
use crate::model::Model;

/// A calibration with the effects that belong to it. See the [module](super).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtendedCalibration<T = f64, E = BuiltIn<T>> {
    /// Offset, matrix and field.
    pub base: Calibration<T>,
    /// The effects.
    pub effects: Effects<T, E>,
}

impl<T: Real, E: Effect<T>> ExtendedCalibration<T, E> {
    /// A calibration without effects.
    pub const fn plain(base: Calibration<T>) -> Self {
        Self { base, effects: Effects::none() }
    }

    /// The calibration of a fitted model; `None` for more than [`MAX_EFFECTS`](super::MAX_EFFECTS) effects.
    pub fn from_model(model: &Model<T>, effects: &[FittedEffect<T, E>]) -> Option<Self>
    where
        E: Clone,
    {
        let base =
            Calibration { offset_ut: model.offset_ut, matrix: model.full_matrix(), field_ut: model.field_ut };
        let mut calibration = Self::plain(base);
        for effect in effects {
            calibration.effects.push(effect.clone()).ok()?;
        }
        Some(calibration)
    }

    /// The corrected field of one sample, µT.
    ///
    /// # Errors
    /// [`NotCorrected`] where something that an effect needs is not known: there is no silent fallback. Who wants one uses
    /// [`Calibration::apply`] of `base`, which is right where every column is at its reference.
    pub fn apply(&self, measured_ut: [T; 3], conditions: &Conditions<T>) -> Result<[T; 3], NotCorrected> {
        let prepared = Prepared::of(&self.base, &self.effects).ok_or(NotCorrected::NotFinite)?;
        let Conditions { turn_radps, inputs } = conditions;
        let list = || {
            self.effects.0.iter().zip(inputs).filter_map(|(place, inputs)| Some((place.as_ref()?, inputs)))
        };
        for (index, (fitted, inputs)) in list().enumerate() {
            let columns = fitted.effect.columns();
            if columns.iter().zip(inputs).any(|(column, value)| column.is_some() && !value.is_finite()) {
                return Err(NotCorrected::Column(index));
            }
            if turn_radps.is_none() && fitted.effect.needs_gyro() {
                return Err(NotCorrected::RateOfTurn(index));
            }
        }
        let list = list().map(|(fitted, inputs)| {
            (&fitted.effect, &fitted.coefficients, fitted.held(*inputs), fitted.bends)
        });
        correct(&self.base, &prepared, measured_ut, *turn_radps, list)
    }

    /// `‖corrected‖ − F`, µT.
    pub fn residual_ut(&self, corrected_ut: [T; 3]) -> T {
        self.base.residual_ut(corrected_ut)
    }
}

impl<T: Real> ExtendedCalibration<T> {
    /// The same calibration in another precision.
    #[inline(never)]
    pub fn cast<U: Real>(&self) -> ExtendedCalibration<U> {
        // Number by number into their places: arrays that are mapped are written out, each time anew.
        #[inline(never)]
        fn cast_all<T: Real, U: Real>(from: &[T], to: &mut [U]) {
            for (from, to) in from.iter().zip(to) {
                *to = U::of(from.as_f64());
            }
        }
        let mut effects = Effects::none();
        for fitted in self.effects.iter() {
            let mut cast =
                FittedEffect::new(fitted.effect.cast(), [U::zero(); 9], [U::zero(); 9]).bending(fitted.bends);
            cast_all(&fitted.coefficients, &mut cast.coefficients);
            cast_all(&fitted.std_errors, &mut cast.std_errors);
            for (from, to) in fitted.ranges.iter().zip(&mut cast.ranges) {
                if let Some(from) = from {
                    let mut ends = [U::zero(); 2];
                    cast_all(from, &mut ends);
                    *to = Some(ends);
                }
            }
            // As many places as there were.
            let _ = effects.push(cast);
        }
        ExtendedCalibration { base: self.base.cast(), effects }
    }
}

impl<T: Real, E: Effect<T> + InParts + Clone> ExtendedCalibration<T, E> {
    /// The same calibration on a clock of its own, and what the old one shows when that is zero, s. To be done in double
    /// precision before [`ExtendedCalibration::cast`]: a single has lost the phase of an interference, or the second itself,
    /// where times count from long ago.
    #[inline(never)]
    pub fn on_own_clock(&self) -> (Self, f64) {
        let reference = |fitted: &FittedEffect<T, E>| fitted.effect.parts().time_reference_s();
        let origin_s = self.effects.iter().find_map(reference).unwrap_or(0.0);
        // In place: an array of effects that is mapped stands on the stack several times over.
        let mut moved = self.clone();
        for fitted in moved.effects.0.iter_mut().flatten() {
            fitted.move_clock(origin_s);
            fitted.effect = fitted.effect.with_numbers(&fitted.effect.parts().on_clock_from(origin_s));
        }
        (moved, origin_s)
    }

    /// Whether every number but the standard errors is finite, the matrix invertible and no range ends before it begins: what
    /// a record or a file must hold.
    pub fn is_sound(&self) -> bool {
        let sound = |fitted: &FittedEffect<T, E>| {
            let k = fitted.effect.coefficients();
            fitted.effect.parts().is_sound()
                && fitted.coefficients.iter().take(k).all(|value| value.is_finite())
                && fitted.has_sound_ranges()
        };
        self.base.is_sound() && self.effects.iter().all(sound)
    }
}
