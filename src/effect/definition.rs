//! The numbers of an effect: the trait that the fit, the study and the live correction see.

use super::quantities::{Coefficients, Column, MAX_INPUTS, Quantities, Shape, no_shape};
use crate::math::Real;
use core::fmt;

/// A physical cause of known shape and unknown strength.
pub trait Effect<T: Real> {
    /// Writes the id, as in `offset:temp_c`: lower case, no blanks.
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result;
    /// The name in words.
    fn name(&self) -> &'static str;
    /// The physical cause, in two sentences.
    fn explanation(&self) -> &'static str;
    /// The columns it reads; none, one or two.
    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [None, None]
    }
    /// Whether it needs the rate of turn.
    fn needs_gyro(&self) -> bool {
        false
    }
    /// k, the number of coefficients, at most [`MAX_COEFFICIENTS`](super::MAX_COEFFICIENTS).
    fn coefficients(&self) -> usize;
    /// Unit of the coefficients.
    fn unit(&self) -> &'static str;
    /// Writes `Φ` for one sample into the first k vectors of `shape`.
    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>);
    /// What is put into [`TIME`](super::TIME) for it at the time `now_s`: a time with the same shape. That is `now_s` itself
    /// unless the shape repeats; a shape that does gets whole periods taken off here, in double precision, since a single has
    /// lost the phase after an hour.
    fn time_s(&self, now_s: f64) -> f64 {
        now_s
    }
    /// Whether the shape repeats in time: then it goes on after the time that it was fitted over, and is not held at its end.
    fn repeats(&self) -> bool {
        false
    }
    /// Whether the shape reads [`Quantities::centred_ut`] or [`Quantities::turning_ut_per_s`], which themselves depend on
    /// the disturbance: the live correction then looks again until it stands. An effect that says no is cheaper.
    fn reads_centre(&self) -> bool {
        true
    }
    /// How late the whole reading is, s, where that is all that the effect does: the correction then turns the vector by what
    /// the board turned meanwhile, which keeps its length, and takes nothing off it. [`Effect::shape`] is then the
    /// derivative after the delay, and [`Effect::disturbance`] is zero.
    #[inline]
    fn delay_s(&self, _coefficients: &Coefficients<T>) -> Option<T> {
        None
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
    fn name(&self) -> &'static str {
        (**self).name()
    }
    fn explanation(&self) -> &'static str {
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
    fn unit(&self) -> &'static str {
        (**self).unit()
    }
    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        (**self).shape(at, shape);
    }
    fn time_s(&self, now_s: f64) -> f64 {
        (**self).time_s(now_s)
    }
    fn repeats(&self) -> bool {
        (**self).repeats()
    }
    fn reads_centre(&self) -> bool {
        (**self).reads_centre()
    }
    fn delay_s(&self, coefficients: &Coefficients<T>) -> Option<T> {
        (**self).delay_s(coefficients)
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
