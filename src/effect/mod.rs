//! Effects: physical causes of error that the base model (hard iron, soft iron) does not know.
//!
//! An effect is a known shape with unknown coefficients `θ`: a 3×k matrix `Φ(sample)`, the disturbance of the measured
//! vector per unit coefficient, so that
//!
//! ```text
//! ĥ = A h + b + Σ Φ(sample) θ + w          h = C (ĥ − b − Σ Φ θ)
//! ```
//!
//! An effect has two sides, and both stand in one file of its own:
//!
//! - [`Effect`], the numbers: the columns it reads and `Φ`. It is all that the fit, the study and the live correction see,
//!   on the board too.
//! - [`Family`], everything else that a program asks: how ids are read and built ([`Form`], [`Parts`]), in which residual
//!   it shows, what its coefficients are called and amount to, which recording tells it from others, how it is written
//!   as C and as Rust. Only programs on a host look at it, and firmware that does not carries none of it.
//!
//! A [`Registry`] lists families: those of this crate, and a program's own after them.
//!
//! # One of your own
//!
//! The numbers are one type; `examples/own-effect` adds the family too, and then simulates, diagnoses, fits and exports it.
//!
//! ```
//! use ironout::effect::{Column, Effect, Quantities, Shape};
//! use ironout::math::Real;
//!
//! /// A servo whose magnet turns with its arm.
//! struct Servo;
//!
//! impl<T: Real> Effect<T> for Servo {
//!     fn id(&self, out: &mut dyn core::fmt::Write) -> core::fmt::Result {
//!         out.write_str("servo")
//!     }
//!     fn name(&self) -> &'static str {
//!         "servo magnet"
//!     }
//!     fn explanation(&self) -> &'static str {
//!         "The servo's magnet turns with its arm. Its field at the sensor follows the arm's angle."
//!     }
//!     fn columns(&self) -> [Option<Column<'_, T>>; 2] {
//!         [Some(Column::now("servo_rad")), None]
//!     }
//!     fn coefficients(&self) -> usize {
//!         2
//!     }
//!     fn unit(&self) -> &'static str {
//!         "µT/rad"
//!     }
//!     fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
//!         shape[0] = [at.inputs[0], T::zero(), T::zero()];
//!         shape[1] = [T::zero(), at.inputs[0], T::zero()];
//!     }
//! }
//!
//! let mut shape = ironout::effect::no_shape();
//! let mut at = Quantities::of_vector([20.0_f64, 5.0, -40.0]);
//! at.inputs[0] = 0.5;
//! Servo.shape(&at, &mut shape);
//! assert_eq!(shape[1], [0.0, 0.5, 0.0]);
//! ```

mod advice;
mod apart;
mod attitude;
mod built_in;
mod code;
mod column_name;
mod columns;
mod cross_axis;
mod definition;
mod drift;
mod family;
mod field;
mod gain;
mod lag;
mod made;
mod nonlinearity;
mod offset;
mod parts;
mod periodic;
mod product;
mod quantities;
mod registry;
mod soft_iron;
mod step;
#[cfg(test)]
mod tests;

pub(crate) use advice::advice;
pub use code::{CNumber, RustCode};
pub use column_name::{BadName, ColumnName, MAX_COLUMN_NAME};
pub use columns::{ColumnKind, Usual};
pub use cross_axis::CrossAxis;
pub use definition::{Effect, Id};
pub use drift::Drift;
pub use family::{Acts, Advice, Amount, Bends, Family, Follows, Group, Need, Subject};
pub use field::AmbientField;
pub use gain::Gain;
pub use lag::{Eddy, Lag};
pub use made::Made;
pub use nonlinearity::Nonlinearity;
pub use offset::{Offset, Power};
pub use parts::{Form, InParts, Parts, Searched, Zero};
pub use periodic::Periodic;
pub use product::Product;
pub use quantities::{
    Coefficients, Column, MAX_COEFFICIENTS, MAX_INPUTS, Past, Quantities, Shape, TIME, no_shape,
};
pub use registry::{BuiltIn, Named, Registry};
pub use soft_iron::SoftIron;
pub use step::Step;
