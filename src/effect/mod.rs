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

mod built_in;
mod column_name;
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

pub use built_in::BuiltIn;
pub use column_name::{BadName, ColumnName, MAX_COLUMN_NAME};
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

/// `θ`: the coefficients of an effect. Only the first k are read.
pub type Coefficients<T> = [T; MAX_COEFFICIENTS];

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
    /// Whether the shape reads [`Quantities::centred_ut`] or [`Quantities::turning_ut_per_s`], which themselves depend on
    /// the disturbance: the live correction then looks again until it stands. An effect that says no is cheaper.
    fn reads_centre(&self) -> bool {
        true
    }
    /// `Φ θ`, µT. The same as [`Effect::shape`] times the coefficients, which is what it does unless an effect knows a
    /// cheaper way.
    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        let mut shape = no_shape();
        self.shape(at, &mut shape);
        let mut sum = [T::zero(); 3];
        for (vector, coefficient) in shape.iter().zip(coefficients).take(self.coefficients()) {
            for (total, value) in sum.iter_mut().zip(vector) {
                *total += *value * *coefficient;
            }
        }
        sum
    }
}

/// A reference to an effect is one: effects of different types stand in one model as `&dyn Effect<T>`.
impl<T: Real, E: Effect<T> + ?Sized> Effect<T> for &E {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        (**self).id(out)
    }
    fn name(&self) -> &str {
        (**self).name()
    }
    fn explanation(&self) -> &str {
        (**self).explanation()
    }
    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        (**self).columns()
    }
    fn needs_gyro(&self) -> bool {
        (**self).needs_gyro()
    }
    fn coefficients(&self) -> usize {
        (**self).coefficients()
    }
    fn unit(&self) -> &str {
        (**self).unit()
    }
    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        (**self).shape(at, shape);
    }
    fn reads_centre(&self) -> bool {
        (**self).reads_centre()
    }
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        (**self).disturbance(at, coefficients)
    }
}

/// Shows the id of an effect.
pub struct Id<'a, T>(pub &'a dyn Effect<T>);

impl<T: Real> fmt::Display for Id<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.id(f)
    }
}

/// `value · θ` with the first three coefficients: the disturbance of a shape `value · I₃`.
#[inline]
fn along<T: Real>(value: T, [x, y, z, ..]: &Coefficients<T>) -> [T; 3] {
    [*x * value, *y * value, *z * value]
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
