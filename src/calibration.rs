//! A calibration: what turns a measured vector into the field.

use crate::real::Real;
use crate::vector::{determinant, minus, times};

pub use crate::vector::{inverse_3x3, norm};

/// `corrected = matrix · (measured − offset)`: hard iron and zero offset removed, soft iron, gains and
/// non-orthogonality undone (paper eq. (3) inverted, `h = C(ĥ − b)`).
///
/// From magnitudes alone the matrix is known up to a rotation; it is upper triangular with a positive diagonal
/// (the paper's eq. (4)), and becomes a full 3×3 once aligned to an accelerometer.
///
/// ```
/// use ironout::calibration::Calibration;
/// let cal = Calibration { offset_ut: [90.0, -12.0, 3.0], matrix: [[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.9]], field_ut: 48.0 };
/// assert_eq!(cal.apply([100.0_f64, -12.0, 3.0]), [10.0, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration<T = f64> {
    /// Hard iron and zero offset `b`, µT in the sensor's axes.
    pub offset_ut: [T; 3],
    /// `C = A⁻¹`, rows first, no unit.
    pub matrix: [[T; 3]; 3],
    /// The magnitude `F` that corrected vectors are scaled to, µT.
    pub field_ut: T,
}

impl<T: Real> Calibration<T> {
    /// A calibration that changes nothing.
    pub fn identity(field_ut: T) -> Self {
        let (one, zero) = (T::one(), T::zero());
        Self {
            offset_ut: [zero; 3],
            matrix: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
            field_ut,
        }
    }

    /// The corrected field of a measured vector, both µT. NaN in, NaN out.
    #[inline]
    pub fn apply(&self, measured_ut: [T; 3]) -> [T; 3] {
        times(&self.matrix, minus(measured_ut, self.offset_ut))
    }

    /// `‖corrected‖ − F`, µT: how far a corrected vector is from the magnitude it should have.
    #[inline]
    pub fn residual_ut(&self, corrected_ut: [T; 3]) -> T {
        norm(corrected_ut) - self.field_ut
    }

    /// The same calibration in another precision.
    pub fn cast<U: Real>(&self) -> Calibration<U> {
        let to = |v: T| U::of(v.as_f64());
        Calibration {
            offset_ut: self.offset_ut.map(to),
            matrix: self.matrix.map(|row| row.map(to)),
            field_ut: to(self.field_ut),
        }
    }

    /// The measured vector that this calibration corrects to `field_ut`: `A h + b`. `None` if the matrix is singular.
    pub fn distort(&self, field_ut: [T; 3]) -> Option<[T; 3]> {
        let inverse = inverse_3x3(&self.matrix)?;
        let raw = times(&inverse, field_ut);
        Some(core::array::from_fn(|a| raw[a] + self.offset_ut[a]))
    }

    /// Whether every number is finite, the field positive and the matrix invertible with a positive determinant.
    pub fn is_sound(&self) -> bool {
        let finite = self.offset_ut.iter().chain(self.matrix.iter().flatten()).all(|v| v.is_finite());
        finite
            && self.field_ut.is_finite()
            && self.field_ut > T::zero()
            && determinant(&self.matrix) > T::zero()
    }
}
