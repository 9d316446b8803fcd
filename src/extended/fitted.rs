//! The effects that a calibration carries.

use crate::calibration::Calibration;
use crate::effect::{
    BuiltIn, Coefficients, Effect, MAX_COEFFICIENTS, MAX_INPUTS, Quantities, TIME, no_shape,
};
use crate::math::Real;
use crate::vector::{minus, norm, times};

/// The most effects a calibration carries.
pub const MAX_EFFECTS: usize = 4;

/// An effect goes on beyond the range that it was fitted over by this many times its width: there the errors of its coefficients make three
/// times what they make at the end.
pub const BEYOND: f64 = 1.0;

/// The least and the greatest value of each column of an effect, in the order of [`Effect::columns`], in the column's unit;
/// `None` where it has no such column, or its range is not known.
pub type Ranges<T> = [Option<[T; 2]>; MAX_INPUTS];

/// An effect with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedEffect<T, E = BuiltIn<T>> {
    /// The shape.
    pub effect: E,
    /// The coefficients, in the effect's unit; the first k count.
    pub coefficients: Coefficients<T>,
    /// Their standard errors, from noise; NaN for a coefficient that the data did not show.
    pub std_errors: Coefficients<T>,
    /// Over which values of its columns it was fitted: beyond them by more than [`BEYOND`] times their width it is held.
    pub ranges: Ranges<T>,
}

impl<T, E> FittedEffect<T, E> {
    /// An effect with these coefficients and standard errors, of which it is not known over which values of its columns it
    /// was fitted: [`FittedEffect::over`] says so.
    pub const fn new(effect: E, coefficients: Coefficients<T>, std_errors: Coefficients<T>) -> Self {
        Self { effect, coefficients, std_errors, ranges: [const { None }; MAX_INPUTS] }
    }

    /// The same effect, fitted over these values of its columns; usable in constants.
    pub const fn over(mut self, ranges: Ranges<T>) -> Self
    where
        T: Copy,
    {
        self.ranges = ranges;
        self
    }
}

impl<T: Real, E: Effect<T>> FittedEffect<T, E> {
    /// The values of its columns as it is applied: held where they are beyond the range that it was fitted over by more than [`BEYOND`]
    /// times its width, since nothing is known of how it goes on. An effect that repeats in time is not held.
    pub fn held(&self, mut inputs: [T; MAX_INPUTS]) -> [T; MAX_INPUTS] {
        for (value, [least, most]) in inputs.iter_mut().zip(self.limits()) {
            if *value < least {
                *value = least;
            } else if *value > most {
                *value = most;
            }
        }
        inputs
    }

    /// Where the value of each column is held.
    pub(super) fn limits(&self) -> [[T; 2]; MAX_INPUTS] {
        let (repeats, beyond) = (self.effect.repeats(), T::of(BEYOND));
        self.ranges.map(|range| match range {
            Some([least, most]) if !repeats => {
                let margin = (most - least) * beyond;
                [least - margin, most + margin]
            }
            _ => [T::of(f64::NEG_INFINITY), T::of(f64::INFINITY)],
        })
    }

    /// Error (1σ) of a corrected vector, µT, that the standard errors of the coefficients make, each taken by itself: it is not kept how
    /// they hang together. Outside of the ranges it holds what the effect would change by from the end of the range if it went on in
    /// the same way. `measured_ut` is the measured vector, `inputs` are the values of the effect's columns; what a rate of turn adds is
    /// left out. `None` where it is not known.
    pub fn error_ut(&self, base: &Calibration<T>, measured_ut: [T; 3], inputs: [T; MAX_INPUTS]) -> Option<T> {
        let centred_ut = minus(measured_ut, base.offset_ut);
        let inside = self.held(inputs);
        let at = |inputs| Quantities { centred_ut, inputs, ..Quantities::of_vector(measured_ut) };
        let mut shape = no_shape();
        self.effect.shape(&at(inside), &mut shape);
        let k = self.effect.coefficients().min(MAX_COEFFICIENTS);
        let errors = shape.iter().zip(&self.std_errors).take(k);
        let mut square = errors.fold(T::zero(), |sum, (column, error)| {
            let one = norm(times(&base.matrix, *column)) * *error;
            sum + one * one
        });
        if inside != inputs {
            let disturbance = |inputs| self.effect.disturbance(&at(inputs), &self.coefficients);
            let beyond = norm(times(&base.matrix, minus(disturbance(inputs), disturbance(inside))));
            square += beyond * beyond;
        }
        Some(square.root()).filter(|error| error.is_finite())
    }

    /// The ranges on a clock that shows zero when the other one shows `origin_s`.
    pub(super) fn ranges_on_clock_from(&self, origin_s: f64) -> Ranges<T> {
        let mut ranges = self.ranges;
        for (range, column) in ranges.iter_mut().zip(self.effect.columns()) {
            if column.is_some_and(|column| column.name == TIME) {
                *range = range.map(|ends| ends.map(|end| T::of(end.as_f64() - origin_s)));
            }
        }
        ranges
    }

    /// Whether every range that is known has two ends in their order.
    pub(super) fn has_sound_ranges(&self) -> bool {
        self.ranges.iter().flatten().all(|[least, most]| least <= most)
    }
}

/// Up to [`MAX_EFFECTS`] effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effects<T, E = BuiltIn<T>>(pub(super) [Option<FittedEffect<T, E>>; MAX_EFFECTS]);

impl<T, E> Effects<T, E> {
    /// No effects.
    pub const fn none() -> Self {
        Self([const { None }; MAX_EFFECTS])
    }

    /// These places; for constants.
    pub const fn of(places: [Option<FittedEffect<T, E>>; MAX_EFFECTS]) -> Self {
        Self(places)
    }

    /// Adds one; gives it back if all places are taken.
    ///
    /// # Errors
    /// The effect itself.
    pub fn push(&mut self, effect: FittedEffect<T, E>) -> Result<(), FittedEffect<T, E>> {
        match self.0.iter_mut().find(|place| place.is_none()) {
            Some(place) => {
                *place = Some(effect);
                Ok(())
            }
            None => Err(effect),
        }
    }

    /// The effects.
    pub fn iter(&self) -> impl Iterator<Item = &FittedEffect<T, E>> {
        self.0.iter().flatten()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.iter().count()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
