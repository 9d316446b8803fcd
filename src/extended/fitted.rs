//! The effects that a calibration carries.

use crate::calibration::Calibration;
use crate::effect::{
    Bends, BuiltIn, Coefficients, Effect, MAX_COEFFICIENTS, MAX_INPUTS, Quantities, TIME, no_shape,
};
use crate::math::Real;
use crate::vector::{minus, norm, times};

/// The most effects a calibration carries.
pub const MAX_EFFECTS: usize = 4;

/// An effect is extrapolated up to this many widths of its range outside the range. The standard error of a line there is three times that at
/// the end of the range.
pub const MAX_WIDTHS_OUTSIDE: f64 = 1.0;

/// The least and the greatest value of each column of an effect, in the order of [`Effect::columns`], in the column's unit;
/// `None` where it has no such column, or its range is not known.
pub type Ranges<T> = [Option<[T; 2]>; MAX_INPUTS];

/// The least and the greatest value of each column that a correction uses.
pub(super) type Limits<T> = [[T; 2]; MAX_INPUTS];

/// The inputs within their limits.
#[inline]
pub(super) fn held<T: Real>(limits: &Limits<T>, mut inputs: [T; MAX_INPUTS]) -> [T; MAX_INPUTS] {
    for (value, [least, most]) in inputs.iter_mut().zip(limits) {
        // Not `clamp`: NaN means unknown and stays NaN.
        if *value < *least {
            *value = *least;
        } else if *value > *most {
            *value = *most;
        }
    }
    inputs
}

/// An effect with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedEffect<T, E = BuiltIn<T>> {
    /// The shape.
    pub effect: E,
    /// The coefficients, in the effect's unit; the first k count.
    pub coefficients: Coefficients<T>,
    /// Their standard errors, from noise; NaN for a coefficient that the data did not show.
    pub std_errors: Coefficients<T>,
    /// The ranges of its columns in the log of the fit. Far outside of them the effect is held ([`FittedEffect::held`]).
    pub ranges: Ranges<T>,
    /// What it bends.
    pub bends: Bends,
}

impl<T, E> FittedEffect<T, E> {
    /// An effect with these coefficients and standard errors, of which it is not known over which values of its columns it
    /// was fitted: [`FittedEffect::over`] says so.
    pub const fn new(effect: E, coefficients: Coefficients<T>, std_errors: Coefficients<T>) -> Self {
        Self { effect, coefficients, std_errors, ranges: [const { None }; MAX_INPUTS], bends: Bends::Reading }
    }

    /// The same effect, bending this; usable in constants.
    pub const fn bending(mut self, bends: Bends) -> Self
    where
        T: Copy,
    {
        self.bends = bends;
        self
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
    /// The values of its columns that the correction uses: a column further outside its range than [`MAX_WIDTHS_OUTSIDE`] widths is held at
    /// that limit. A shape that repeats in time has no limit.
    pub fn held(&self, inputs: [T; MAX_INPUTS]) -> [T; MAX_INPUTS] {
        held(&self.limits(), inputs)
    }

    /// The least and the greatest value of each column that the correction uses.
    pub(super) fn limits(&self) -> Limits<T> {
        self.ranges.map(|range| match range {
            Some([least, most]) if !self.effect.repeats() => {
                let margin = (most - least) * T::of(MAX_WIDTHS_OUTSIDE);
                [least - margin, most + margin]
            }
            _ => [T::of(f64::NEG_INFINITY), T::of(f64::INFINITY)],
        })
    }

    /// Error (1σ) of a corrected vector, µT, from the standard errors of the coefficients, each taken by itself: their correlations are not
    /// kept. If a column is held ([`FittedEffect::held`]), the change of the effect from the limit to the column's value counts too.
    /// `measured_ut` is the measured vector, `inputs` are the values of the effect's columns; a rate of turn is left out. `None` if it is
    /// not known.
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

    /// Moves the ranges of the time to a clock that shows zero when the other one shows `origin_s`.
    pub(super) fn move_clock(&mut self, origin_s: f64) {
        for (range, column) in self.ranges.iter_mut().zip(self.effect.columns()) {
            if let (Some(ends), Some(column)) = (range, column)
                && column.name == TIME
            {
                for end in ends {
                    *end = T::of(end.as_f64() - origin_s);
                }
            }
        }
    }

    /// Whether every range that is known has two ends in their order.
    pub(super) fn has_sound_ranges(&self) -> bool {
        self.ranges.iter().flatten().all(|[least, most]| least <= most)
    }
}

/// Up to [`MAX_EFFECTS`] effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effects<T, E = BuiltIn<T>>(pub(super) [Option<FittedEffect<T, E>>; MAX_EFFECTS]);

/// How many: their numbers are more than a line of a log.
#[cfg(feature = "defmt")]
impl<T, E> defmt::Format for Effects<T, E> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{} effects", self.len());
    }
}

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
