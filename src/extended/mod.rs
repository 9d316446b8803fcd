//! A calibration that carries effects: offset and matrix, and up to four causes of error with their fitted coefficients.
//!
//! `corrected = matrix · (measured − offset − Σ Φθ)`. [`ExtendedCalibration`] is what a fit makes and what is stored;
//! [`Live`] is what runs on every sample: it knows which column goes to which effect, keeps the late ones, and says so
//! when a column that an effect needs is not known, instead of correcting with something else.
//!
//! # An effect of one's own, from the fit to the correction
//!
//! One type and nothing else: the same `Study`, the same fit, the same correction.
//!
//! ```
//! use ironout::effect::{Column, Effect, Quantities, Shape};
//! use ironout::extended::{ExtendedCalibration, FittedEffect, Live};
//! use ironout::study::{Model, Normal, PhysicalPrior, Observation, Residual, Study, Term, base_prior, refit};
//!
//! /// A servo whose magnet turns with its arm: its field turns in the board's x-y plane.
//! #[derive(Clone, Copy)]
//! struct Servo;
//!
//! impl Effect<f64> for Servo {
//!     fn id(&self, out: &mut dyn core::fmt::Write) -> core::fmt::Result {
//!         out.write_str("servo")
//!     }
//!     fn name(&self) -> &str {
//!         "servo magnet"
//!     }
//!     fn explanation(&self) -> &str {
//!         "The servo's magnet turns with its arm. Its field at the sensor turns with it."
//!     }
//!     fn columns(&self) -> [Option<Column<'_, f64>>; 2] {
//!         [Some(Column::now("servo_rad")), None]
//!     }
//!     fn coefficients(&self) -> usize {
//!         2
//!     }
//!     fn unit(&self) -> &str {
//!         "µT"
//!     }
//!     fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
//!         let angle = at.inputs[0];
//!         shape[0] = [angle.cos(), angle.sin(), 0.0];
//!         shape[1] = [-angle.sin(), angle.cos(), 0.0];
//!     }
//! }
//!
//! // A board that turns, its servo moving: field 50 µT, offset (20, −5, 8) µT, and the servo adds 3 µT along its arm.
//! let sample = |i: u32| {
//!     let (tilt, turn) = (f64::from(i) * 0.0113, f64::from(i) * 0.107);
//!     let angle = 1.5 * (f64::from(i) * 0.031).sin();
//!     let field = [tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin()].map(|v| 50.0 * v);
//!     let measured = [field[0] + 20.0 + 3.0 * angle.cos(), field[1] - 5.0 + 3.0 * angle.sin(), field[2] + 8.0];
//!     (measured, angle)
//! };
//!
//! // Fit: nine columns of the base and two of the effect, linearised again and again, from a sphere on.
//! let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let mut model = Model::new([18.0, -4.0, 9.0], identity, 50.0, identity, 0.0).ok_or("no model")?;
//! let mut servo = FittedEffect { effect: Servo, coefficients: [0.0; 9], std_errors: [0.0; 9] };
//! for _ in 0..8 {
//!     let mut study: Study<f64, 11, 1, 1> = Study::new(Residual::Magnitude, model, 2);
//!     for i in 0..3000 {
//!         let (measured_ut, angle) = sample(i);
//!         let term = Term { effect: &servo.effect, coefficients: servo.coefficients, inputs: [angle, 0.0] };
//!         study.push(0, &Observation { measured_ut, turn_radps: None, down: None }, &[term])?;
//!     }
//!     let prior: Normal<f64, 11> = base_prior(&PhysicalPrior::default(), &model, 0.01, 11);
//!     model = refit(&study, Some(&prior), core::slice::from_mut(&mut servo)).ok_or("not determined")?;
//! }
//! assert!((servo.coefficients[0] - 3.0).abs() < 1e-3 && servo.coefficients[1].abs() < 1e-3);
//! assert!((model.offset_ut[0] - 20.0).abs() < 1e-3);
//!
//! // Apply.
//! let calibration = ExtendedCalibration::from_model(&model, &[servo]).ok_or("more than four effects")?;
//! let mut live = Live::new(&calibration)?;
//! let (measured, angle) = sample(77);
//! assert!(live.apply(measured, None).is_err(), "where the servo stands is not known yet");
//! live.set("servo_rad", angle);
//! let corrected = live.apply(measured, None)?;
//! assert!((corrected.iter().map(|v| v * v).sum::<f64>().sqrt() - 50.0).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Effects of different types stand in one calibration as `ExtendedCalibration<T, &dyn Effect<T>>`; those of the catalogue as
//! [`BuiltIn`], which is what records and files hold.

mod delay;
mod live;

pub use delay::{DELAY_PLACES, DelayLine};
pub use live::{Live, LiveError, MAX_DELAYED, Slots};

use crate::calibration::Calibration;
use crate::effect::{BuiltIn, Coefficients, Effect, MAX_INPUTS, Quantities};
use crate::math::Real;
use crate::model::{Model, settle};
use crate::vector::{cross, inverse_3x3, minus, times};
use core::fmt;

/// The most effects a calibration carries.
pub const MAX_EFFECTS: usize = 4;

/// An effect with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedEffect<T, E = BuiltIn<T>> {
    /// The shape.
    pub effect: E,
    /// The coefficients, in the effect's unit; the first k count.
    pub coefficients: Coefficients<T>,
    /// Their standard errors, from noise; NaN for a coefficient that the data did not show.
    pub std_errors: Coefficients<T>,
}

/// Up to [`MAX_EFFECTS`] effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effects<T, E = BuiltIn<T>>([Option<FittedEffect<T, E>>; MAX_EFFECTS]);

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

/// A calibration with the effects that belong to it. See the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtendedCalibration<T = f64, E = BuiltIn<T>> {
    /// Offset, matrix and field.
    pub base: Calibration<T>,
    /// The effects.
    pub effects: Effects<T, E>,
}

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
}

impl fmt::Display for NotCorrected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Column(effect) => write!(f, "a column that effect {effect} reads is not known"),
            Self::RateOfTurn(effect) => write!(f, "effect {effect} needs the rate of turn"),
            Self::Shape(effect) => write!(f, "the shape of effect {effect} is not finite"),
            Self::NotFinite => f.write_str("the measured vector is not finite"),
        }
    }
}

impl core::error::Error for NotCorrected {}

/// What of a calibration is worked out once: `A = C⁻¹`, and what its effects look at.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Prepared<T> {
    inverse: [[T; 3]; 3],
    turning: bool,
    looks_again: bool,
}

impl<T: Real> Prepared<T> {
    fn of<E: Effect<T>>(calibration: &ExtendedCalibration<T, E>) -> Option<Self> {
        let effects = || calibration.effects.iter().map(|fitted| &fitted.effect);
        Some(Self {
            inverse: inverse_3x3(&calibration.base.matrix)?,
            turning: effects().any(|effect| effect.needs_gyro()),
            looks_again: effects().any(|effect| effect.reads_centre()),
        })
    }
}

impl<T: Real, E: Effect<T>> ExtendedCalibration<T, E> {
    /// A calibration without effects.
    pub const fn plain(base: Calibration<T>) -> Self {
        Self { base, effects: Effects::none() }
    }

    /// The calibration of a fitted model; `None` for more than [`MAX_EFFECTS`] effects.
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
        let prepared = Prepared::of(self).ok_or(NotCorrected::NotFinite)?;
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
        let list = list().map(|(fitted, inputs)| (&fitted.effect, &fitted.coefficients, inputs));
        correct(&self.base, &prepared, measured_ut, *turn_radps, list)
    }

    /// `‖corrected‖ − F`, µT.
    pub fn residual_ut(&self, corrected_ut: [T; 3]) -> T {
        self.base.residual_ut(corrected_ut)
    }
}

impl<T: Real> ExtendedCalibration<T> {
    /// The same calibration in another precision.
    pub fn cast<U: Real>(&self) -> ExtendedCalibration<U> {
        let to = |value: T| U::of(value.as_f64());
        let effects = self.effects.0.map(|place| {
            place.map(|FittedEffect { effect, coefficients, std_errors }| FittedEffect {
                effect: effect.cast(),
                coefficients: coefficients.map(to),
                std_errors: std_errors.map(to),
            })
        });
        ExtendedCalibration { base: self.base.cast(), effects: Effects(effects) }
    }

    /// The same calibration on a clock of its own, and what the old one shows when that is zero, s. To be done in double
    /// precision before [`ExtendedCalibration::cast`]: a single has lost the phase of an interference, or the second itself,
    /// where times count from long ago.
    pub fn on_own_clock(&self) -> (Self, f64) {
        let origin_s = self.effects.iter().find_map(|fitted| fitted.effect.time_reference_s()).unwrap_or(0.0);
        let effects = self.effects.0.map(|place| {
            place.map(|fitted| FittedEffect { effect: fitted.effect.on_clock_from(origin_s), ..fitted })
        });
        (Self { base: self.base, effects: Effects(effects) }, origin_s)
    }

    /// Whether every number but the standard errors is finite and the matrix invertible: what a record or a file must hold.
    pub fn is_sound(&self) -> bool {
        let sound = |fitted: &FittedEffect<T>| {
            let k = fitted.effect.coefficients();
            fitted.effect.is_sound() && fitted.coefficients.iter().take(k).all(|value| value.is_finite())
        };
        self.base.is_sound() && self.effects.iter().all(sound)
    }
}

/// The correction itself, once everything that the effects need is known to be there. Effects that read the centre are
/// evaluated again until their disturbance stands: the first time with the centre as if there were none.
#[inline]
fn correct<'e, T: Real, E: Effect<T> + 'e>(
    base: &Calibration<T>,
    prepared: &Prepared<T>,
    measured_ut: [T; 3],
    turn_radps: Option<[T; 3]>,
    effects: impl Iterator<Item = (&'e E, &'e Coefficients<T>, &'e [T; MAX_INPUTS])> + Clone,
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
        for (effect, coefficients, inputs) in effects.clone() {
            at.inputs = *inputs;
            left = minus(left, effect.disturbance(&at, coefficients));
        }
        Ok::<_, NotCorrected>(left)
    };
    let left = settle(centred, prepared.looks_again, look)?;
    let corrected = times(&base.matrix, left);
    if is_finite(corrected) {
        return Ok(corrected);
    }
    // Whose fault it is, is looked for only now.
    for (index, (effect, coefficients, inputs)) in effects.clone().enumerate() {
        at.inputs = *inputs;
        if is_finite(measured_ut) && !is_finite(effect.disturbance(&at, coefficients)) {
            return Err(NotCorrected::Shape(index));
        }
    }
    Err(NotCorrected::NotFinite)
}

#[inline]
fn is_finite<T: Real>([x, y, z]: [T; 3]) -> bool {
    (x + y + z).is_finite()
}

#[cfg(test)]
mod tests;
