//! A calibration that carries effects: offset and matrix, and up to four causes of error with their fitted coefficients.
//!
//! `corrected = matrix · (measured − offset − Σ Φθ)`. [`ExtendedCalibration`] is what a fit makes and what is stored;
//! [`Live`] is what runs on every sample: it knows which column goes to which effect, keeps the late ones, and says so
//! when a column that an effect needs is not known, instead of correcting with something else, and which column is outside the
//! range that its effect was fitted over ([`Live::outside`]).
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
//!     fn name(&self) -> &'static str {
//!         "servo magnet"
//!     }
//!     fn explanation(&self) -> &'static str {
//!         "The servo's magnet turns with its arm. Its field at the sensor turns with it."
//!     }
//!     fn columns(&self) -> [Option<Column<'_, f64>>; 2] {
//!         [Some(Column::now("servo_rad")), None]
//!     }
//!     fn coefficients(&self) -> usize {
//!         2
//!     }
//!     fn unit(&self) -> &'static str {
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
//! let mut servo = FittedEffect::new(Servo, [0.0; 9], [0.0; 9]);
//! for _ in 0..8 {
//!     let mut study: Study<f64, 11, 1, 1> = Study::new(Residual::Magnitude, model, 2);
//!     for i in 0..3000 {
//!         let (measured_ut, angle) = sample(i);
//!         let (coefficients, bends) = (servo.coefficients, servo.bends);
//!         let term = Term { effect: &servo.effect, coefficients, inputs: [angle, 0.0], bends };
//!         study.push(0, &Observation { measured_ut, turn_radps: None, down: None }, &[term])?;
//!     }
//!     let prior: Normal<f64, 11> = base_prior(&PhysicalPrior::default(), &model, 0.01, 11);
//!     model = refit(&study, Some(&prior), core::slice::from_mut(&mut servo)).ok_or("not determined")?;
//! }
//! assert!((servo.coefficients[0] - 3.0).abs() < 1e-3 && servo.coefficients[1].abs() < 1e-3);
//! assert!((model.offset_ut[0] - 20.0).abs() < 1e-3);
//!
//! // The arm was seen from −1.5 to 1.5 rad.
//! servo = servo.over([Some([-1.5, 1.5]), None]);
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
//! Effects of different types stand in one calibration as `ExtendedCalibration<T, &dyn Effect<T>>`; those of this crate as
//! [`BuiltIn`](crate::effect::BuiltIn), which is what the board's records hold; those of any family as
//! [`Made`](crate::effect::Made), which is what files and programs on a host hold.

mod calibration;
mod correction;
mod delay;
mod fitted;
mod live;
mod low_pass;
mod outside;
#[cfg(test)]
mod tests;
mod turning;

pub use calibration::ExtendedCalibration;
pub use correction::{Conditions, MAX_RATIO_TO_FIELD, NotCorrected};
pub use delay::{DELAY_PLACES, DelayLine};
pub use fitted::{Effects, FittedEffect, MAX_EFFECTS, MAX_WIDTHS_OUTSIDE, Ranges};
pub use live::{Live, LiveError, MAX_DELAYED, Slots};
pub use low_pass::LowPass;
pub use outside::Outside;
pub use turning::TurningField;
