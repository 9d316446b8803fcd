//! The correction of one sample, and what it needs to know.

use super::fitted::{Effects, MAX_EFFECTS};
use crate::calibration::Calibration;
use crate::effect::{Bends, Coefficients, Effect, MAX_INPUTS, Quantities};
use crate::math::Real;
use crate::model::settle;
use crate::vector::{cross, inverse_3x3, minus, plus, scaled, times, turned};
use core::fmt;

/// What a sample was measured under, besides its vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<T> {
    /// Rate of turn, rad/s, body axes.
    pub turn_radps: Option<[T; 3]>,
    /// The values of the columns of each effect, in the order of [`Effect::columns`]; NaN where not known.
    pub inputs: [[T; MAX_INPUTS]; MAX_EFFECTS],
}

impl<T: Real> Conditions<T> {
    /// Nothing is known.
    pub fn unknown() -> Self {
        Self { turn_radps: None, inputs: [[T::of(f64::NAN); MAX_INPUTS]; MAX_EFFECTS] }
    }
}

/// Why a vector was not corrected. The number is the effect's place in the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotCorrected {
    /// A column that the effect reads is not known.
    Column(usize),
    /// The effect needs the rate of turn.
    RateOfTurn(usize),
    /// The shape of the effect is not finite.
    Shape(usize),
    /// The measured vector is not finite.
    NotFinite,
    /// The effects make the vector longer than [`MAX_RATIO_TO_FIELD`] allows.
    TooFar,
}

/// A corrected vector longer than this many fields is an error if it is also this many times longer than without the effects: their
/// coefficients then do not apply to this reading.
pub const MAX_RATIO_TO_FIELD: f64 = 2.0;

/// The same of squares.
const LIMIT: f64 = MAX_RATIO_TO_FIELD * MAX_RATIO_TO_FIELD;

impl fmt::Display for NotCorrected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Column(effect) => write!(f, "the value of a column of effect {effect} is unknown"),
            Self::RateOfTurn(effect) => write!(f, "effect {effect} needs the rate of turn"),
            Self::Shape(effect) => write!(f, "the shape of effect {effect} is not finite"),
            Self::TooFar => f.write_str("the effects would make the vector longer than twice the field"),
            Self::NotFinite => f.write_str("the measured vector is not finite"),
        }
    }
}

impl core::error::Error for NotCorrected {}

/// What of a calibration is worked out once: `A = C⁻¹`, and what its effects look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Prepared<T> {
    inverse: [[T; 3]; 3],
    pub(super) turning: bool,
    looks_again: bool,
    bends_field: bool,
    /// The square of the length that effects may give a vector, µT².
    most_square: T,
}

impl<T: Real> Prepared<T> {
    /// `A h`.
    #[inline]
    pub(super) fn undone(&self, corrected: [T; 3]) -> [T; 3] {
        times(&self.inverse, corrected)
    }

    pub(super) fn of<E: Effect<T>>(base: &Calibration<T>, effects: &Effects<T, E>) -> Option<Self> {
        let bends_field = effects.iter().any(|one| one.bends == Bends::Field);
        Some(Self {
            inverse: inverse_3x3(&base.matrix)?,
            turning: effects.iter().any(|one| one.effect.needs_gyro()),
            looks_again: bends_field || effects.iter().any(|one| one.effect.reads_centre()),
            bends_field,
            most_square: T::of(LIMIT) * base.field_ut * base.field_ut,
        })
    }
}

/// An effect of a correction, with its inputs.
pub(super) type Applied<'e, T, E> = (&'e E, &'e Coefficients<T>, [T; MAX_INPUTS], Bends);

/// The correction itself, once everything that the effects need is known to be there. Effects that read the centre are
/// evaluated again until their disturbance stands: the first time with the centre as if there were none.
#[inline]
pub(super) fn correct<'e, T: Real, E: Effect<T> + 'e>(
    base: &Calibration<T>,
    prepared: &Prepared<T>,
    measured_ut: [T; 3],
    turn_radps: Option<[T; 3]>,
    effects: impl Iterator<Item = Applied<'e, T, E>> + Clone,
) -> Result<[T; 3], NotCorrected> {
    let centred = minus(measured_ut, base.offset_ut);
    let mut at = Quantities {
        measured_ut,
        centred_ut: centred,
        turning_ut_per_s: [T::zero(); 3],
        inputs: [T::zero(); MAX_INPUTS],
    };
    let look = |point: [T; 3]| {
        at.centred_ut = point;
        if let (true, Some(turn)) = (prepared.turning, turn_radps) {
            at.turning_ut_per_s = times(&prepared.inverse, cross(turn, times(&base.matrix, at.centred_ut)));
        }
        let mut left = centred;
        for (effect, coefficients, inputs, bends) in effects.clone() {
            at.inputs = inputs;
            if prepared.bends_field {
                at.measured_ut = match bends {
                    Bends::Reading => measured_ut,
                    Bends::Field => plus(point, base.offset_ut),
                };
            }
            left = minus(left, effect.disturbance(&at, coefficients));
        }
        Ok::<_, NotCorrected>(left)
    };
    let left = settle(centred, prepared.looks_again, look)?;
    let mut corrected = times(&base.matrix, left);
    if let (true, Some(turn)) = (prepared.turning, turn_radps) {
        for (effect, coefficients, ..) in effects.clone() {
            // The board turned since what is read now.
            if let Some(delay_s) = effect.delay_s(coefficients) {
                corrected = turned(corrected, scaled(turn, -delay_s));
            }
        }
    }
    if is_finite(corrected) {
        let size = square(corrected);
        if size > prepared.most_square && size > T::of(LIMIT) * square(times(&base.matrix, centred)) {
            return Err(NotCorrected::TooFar);
        }
        return Ok(corrected);
    }
    // Whose fault it is, is looked for only now.
    for (index, (effect, coefficients, inputs, _)) in effects.clone().enumerate() {
        at.inputs = inputs;
        if is_finite(measured_ut) && !is_finite(effect.disturbance(&at, coefficients)) {
            return Err(NotCorrected::Shape(index));
        }
    }
    Err(NotCorrected::NotFinite)
}

#[inline]
fn square<T: Real>([x, y, z]: [T; 3]) -> T {
    x * x + y * y + z * z
}

#[inline]
fn is_finite<T: Real>([x, y, z]: [T; 3]) -> bool {
    (x + y + z).is_finite()
}
