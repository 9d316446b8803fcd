//! Effects: physical causes of error that the base model (hard iron, soft iron) does not know.
//!
//! An effect is a known shape with unknown coefficients `θ`: a 3×k matrix `Φ(sample)`, the disturbance of the measured
//! vector per unit coefficient, so that
//!
//! ```text
//! ĥ = A h + b + Σ Φ(sample) θ + w          h = C (ĥ − b − Σ Φ θ)
//! ```
//!
//! The fit, the study, the live correction and the report see nothing but the trait [`Effect`]. An effect of one's own
//! is one type:
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
//!     fn name(&self) -> &str {
//!         "servo magnet"
//!     }
//!     fn explanation(&self) -> &str {
//!         "The servo's magnet turns with its arm. Its field at the sensor follows the arm's angle."
//!     }
//!     fn columns(&self) -> [Option<Column<'_, T>>; 2] {
//!         [Some(Column::now("servo_rad")), None]
//!     }
//!     fn coefficients(&self) -> usize {
//!         2
//!     }
//!     fn unit(&self) -> &str {
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

mod cross_axis;
mod drift;
mod eddy;
mod field;
mod gain;
mod lag;
mod nonlinearity;
mod offset;
mod periodic;
mod step;

pub use cross_axis::CrossAxis;
pub use drift::Drift;
pub use eddy::Eddy;
pub use field::AmbientField;
pub use gain::Gain;
pub use lag::Lag;
pub use nonlinearity::Nonlinearity;
pub use offset::{Offset, Power};
pub use periodic::Periodic;
pub use step::Step;

use crate::math::Real;
use core::fmt;

/// The most coefficients an effect may have.
pub const MAX_COEFFICIENTS: usize = 9;

/// The most columns an effect may read.
pub const MAX_INPUTS: usize = 2;

/// The column of an effect that reads the time.
pub const TIME: &str = "t_s";

/// `Φ`: one vector of µT per unit for each coefficient. Only the first k are read.
pub type Shape<T> = [[T; 3]; MAX_COEFFICIENTS];

/// A shape of zeros.
pub fn no_shape<T: Real>() -> Shape<T> {
    [[T::zero(); 3]; MAX_COEFFICIENTS]
}

/// A column that an effect reads, perhaps late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column<'a, T> {
    /// Name in the log; [`TIME`] is the time in seconds.
    pub name: &'a str,
    /// How long ago the value was that acts now, s.
    pub delay_s: T,
}

impl<'a, T: Real> Column<'a, T> {
    /// A column that acts at once.
    pub fn now(name: &'a str) -> Self {
        Column { name, delay_s: T::zero() }
    }
}

/// What an effect may look at in one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantities<T> {
    /// The measured vector without its noise (the foot point on the ellipsoid), µT.
    pub measured_ut: [T; 3],
    /// `ĥ − b − Φθ`: the same vector about the centre, µT.
    pub centred_ut: [T; 3],
    /// `A (ω × h)`, µT/s: minus the rate at which the measured vector changes because the board turns. Zero without a gyro.
    pub turning_ut_per_s: [T; 3],
    /// The values of the effect's columns, in the order of [`Effect::columns`].
    pub inputs: [T; MAX_INPUTS],
}

impl<T: Real> Quantities<T> {
    /// A sample of which only the measured vector is known: not turning, no columns.
    pub fn of_vector(measured_ut: [T; 3]) -> Self {
        let zero = T::zero();
        Quantities {
            measured_ut,
            centred_ut: measured_ut,
            turning_ut_per_s: [zero; 3],
            inputs: [zero; MAX_INPUTS],
        }
    }
}

/// A physical cause of known shape and unknown strength.
pub trait Effect<T: Real> {
    /// Writes the id, as in `offset:temp_c`: lower case, no blanks.
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result;
    /// The name in words.
    fn name(&self) -> &str;
    /// The physical cause, in two sentences.
    fn explanation(&self) -> &str;
    /// The columns it reads; none, one or two.
    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [None, None]
    }
    /// Whether it needs the rate of turn.
    fn needs_gyro(&self) -> bool {
        false
    }
    /// k, the number of coefficients, at most [`MAX_COEFFICIENTS`].
    fn coefficients(&self) -> usize;
    /// Unit of the coefficients.
    fn unit(&self) -> &str;
    /// Writes `Φ` for one sample into the first k vectors of `shape`.
    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>);
}

/// Shows the id of an effect.
pub struct Id<'a, T>(pub &'a dyn Effect<T>);

impl<T: Real> fmt::Display for Id<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.id(f)
    }
}

/// Writes `value · I₃` into the first three vectors.
fn isotropic<T: Real>(value: T, shape: &mut Shape<T>) {
    diagonal([value; 3], 0, shape);
}

/// Writes a diagonal matrix into the three vectors from `first` on.
fn diagonal<T: Real>(values: [T; 3], first: usize, shape: &mut Shape<T>) {
    for (axis, (vector, value)) in shape.iter_mut().skip(first).zip(values).enumerate() {
        *vector = [T::zero(); 3];
        if let Some(entry) = vector.get_mut(axis) {
            *entry = value;
        }
    }
}
