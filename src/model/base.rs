//! The base model, and what a sample is at it.

use super::sample::{NotFinite, Term};
use crate::effect::{MAX_INPUTS, Quantities, Shape};
use crate::math::Real;
use crate::vector::{
    TRIANGLE, cross, dot, inverse_3x3, minus, norm, product, scaled, times, transposed_times,
};

/// The base model: `h = R C (ĥ − b − Σ Φθ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Model<T> {
    /// `b`, µT.
    pub offset_ut: [T; 3],
    /// `C`, upper triangular.
    pub matrix: [[T; 3]; 3],
    /// `F`, µT.
    pub field_ut: T,
    /// `R`: from the triangular frame to the accelerometer's.
    pub rotation: [[T; 3]; 3],
    /// Sine of the dip.
    pub sin_dip: T,
    pub(super) full: [[T; 3]; 3],
    inverse: [[T; 3]; 3],
}

pub(super) struct Linearised<T> {
    pub(super) centred: [T; 3],
    pub(super) pull: [T; 3],
    pub(super) residual: T,
}

impl<T: Real> Model<T> {
    /// A model. `None` where the matrix cannot be inverted or something is not finite.
    pub fn new(
        offset_ut: [T; 3],
        matrix: [[T; 3]; 3],
        field_ut: T,
        rotation: [[T; 3]; 3],
        sin_dip: T,
    ) -> Option<Self> {
        let full = product(&rotation, &matrix);
        let inverse = inverse_3x3(&full)?;
        let finite = offset_ut.iter().chain(full.iter().flatten()).all(|value| value.is_finite());
        let sound = finite && sin_dip.is_finite() && field_ut.is_finite() && field_ut > T::zero();
        sound.then_some(Model { offset_ut, matrix, field_ut, rotation, sin_dip, full, inverse })
    }

    /// `R C`: the full correction.
    pub fn full_matrix(&self) -> [[T; 3]; 3] {
        self.full
    }

    /// `(R C)⁻ᵀ v`.
    pub(super) fn transposed_inverse(&self, v: [T; 3]) -> [T; 3] {
        transposed_times(&self.inverse, v)
    }

    /// `Rᵀ v`.
    pub(super) fn transposed_rotation(&self, v: [T; 3]) -> [T; 3] {
        transposed_times(&self.rotation, v)
    }

    pub(super) fn quantities(
        &self,
        measured_ut: [T; 3],
        centred_ut: [T; 3],
        turn: Option<[T; 3]>,
    ) -> Quantities<T> {
        let turning = match turn {
            Some(turn) => times(&self.inverse, cross(turn, times(&self.full, centred_ut))),
            None => [T::zero(); 3],
        };
        Quantities { measured_ut, centred_ut, turning_ut_per_s: turning, inputs: [T::zero(); MAX_INPUTS] }
    }

    pub(super) fn linearise(&self, measured: [T; 3], disturbance: [T; 3]) -> Option<Linearised<T>> {
        let centred = minus(minus(measured, self.offset_ut), disturbance);
        let h = times(&self.matrix, centred);
        let length = norm(h);
        if !length.is_finite() || length <= T::zero() {
            return None;
        }
        let direction = scaled(h, T::one() / length);
        let pull = transposed_times(&self.matrix, direction);
        Some(Linearised { centred, pull, residual: length - self.field_ut })
    }

    /// The measured vector without its noise, as far as one sample tells: the nearest point of the ellipsoid.
    pub(super) fn closest(&self, at: &Linearised<T>) -> [T; 3] {
        let size = dot(at.pull, at.pull);
        scaled(at.pull, at.residual / size)
    }

    /// Shapes of those terms that are `wanted` at the closest point, each in its place, and the disturbance they make together.
    pub(super) fn shapes<'t, const N: usize>(
        &self,
        at: &Quantities<T>,
        terms: impl Iterator<Item = &'t Term<'t, T>>,
        wanted: impl Fn(&Term<'_, T>) -> bool,
        shapes: &mut [Shape<T>; N],
    ) -> Result<[T; 3], NotFinite>
    where
        T: 't,
    {
        let mut sum = [T::zero(); 3];
        let all = terms.zip(shapes.iter_mut()).enumerate();
        for (index, (term, shape)) in all.filter(|(_, (term, _))| wanted(term)) {
            term.effect.shape(&term.sees(at, self.offset_ut), shape);
            // A delay turns, and adds nothing.
            let adds = term.is_active() && term.effect.delay_s(&term.coefficients).is_none();
            for (vector, coefficient) in shape.iter().zip(term.coefficients).take(term.effect.coefficients())
            {
                for (total, value) in sum.iter_mut().zip(vector) {
                    if !value.is_finite() {
                        return Err(NotFinite::Effect(index));
                    }
                    if adds {
                        *total += *value * coefficient;
                    }
                }
            }
        }
        Ok(sum)
    }

    /// The model after a step of a magnitude study: offset and triangle moved, the rest kept.
    pub fn stepped(&self, delta: &[T]) -> Option<Self> {
        let d = |index: usize| delta.get(index).copied().unwrap_or(T::zero());
        let [x, y, z] = self.offset_ut;
        let mut matrix = self.matrix;
        for (index, (row, column)) in TRIANGLE.into_iter().enumerate() {
            if let Some(entry) = matrix.get_mut(row).and_then(|line| line.get_mut(column)) {
                *entry += d(3 + index);
            }
        }
        Self::new([x + d(0), y + d(1), z + d(2)], matrix, self.field_ut, self.rotation, self.sin_dip)
    }

    /// The model after a step of a dip study: turned by the rotation vector, sine of the dip moved.
    pub fn aligned(&self, delta: &[T]) -> Option<Self> {
        let d = |index: usize| delta.get(index).copied().unwrap_or(T::zero());
        let turn = T::rotation([d(0), d(1), d(2)]);
        let limit = T::of(0.999);
        let sine = (self.sin_dip + d(3)).max(-limit).min(limit);
        Self::new(self.offset_ut, self.matrix, self.field_ut, product(&turn, &self.rotation), sine)
    }
}
