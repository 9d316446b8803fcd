//! From a quadric to centre, scale and a positive definite `C`. Every refusal of a shape lives here.

use crate::fit::FitError;
use crate::math;
use nalgebra::{Matrix3, Vector3};

/// Largest offset accepted, in fields. Real boards show 7.
pub const MAX_OFFSET_FIELDS: f64 = 20.0;
/// Largest ratio of the ellipsoid's semi-axes accepted. Real boards stay under 2; the paper's simulation has 3.3.
pub const MAX_AXIS_RATIO: f64 = 6.0;

/// The ellipsoid `‖C(x − b)‖ = 1` in the units of the scatter it was fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipsoid {
    /// Centre `b`.
    pub centre: Vector3<f64>,
    /// `C`, upper triangular with a positive diagonal: the Cholesky factor of `Q = CᵀC` (paper eq. (11), corrected).
    pub factor: Matrix3<f64>,
}

impl Ellipsoid {
    /// The ellipsoid `(x−b)ᵀM(x−b) = s`. The quotient `M/s` is right also where `M` is negative definite, as it is in
    /// the constant reading when the origin lies outside the ellipsoid.
    ///
    /// # Errors
    /// [`FitError::NotAnEllipsoid`] unless `M/s` is positive definite.
    pub fn from_quadric(m: Matrix3<f64>, centre: Vector3<f64>, s: f64) -> Result<Self, FitError> {
        let q = m / s;
        if !(q.iter().all(|v| v.is_finite()) && centre.iter().all(|v| v.is_finite())) {
            return Err(FitError::NotAnEllipsoid);
        }
        let factor = q.cholesky().ok_or(FitError::NotAnEllipsoid)?.l().transpose();
        Ok(Self { centre, factor })
    }

    /// `Q = CᵀC`.
    pub fn q(&self) -> Matrix3<f64> {
        self.factor.transpose() * self.factor
    }

    /// Longest over shortest semi-axis.
    pub fn axis_ratio(&self) -> f64 {
        let q = self.q();
        let rows = core::array::from_fn(|r| core::array::from_fn(|c| q[(r, c)]));
        let [low, _, high] = math::symmetric_eigenvalues_3x3(&rows);
        if low > 0.0 { math::sqrt(high / low) } else { f64::INFINITY }
    }

    /// Refuses offsets and shapes that no magnetometer has. `offset_fields` is the offset over the field magnitude.
    ///
    /// # Errors
    /// [`FitError::OffsetTooLarge`], [`FitError::AxisRatio`].
    pub fn check_plausible(&self, offset_fields: f64) -> Result<(), FitError> {
        // Written so that a NaN is refused too.
        if !(offset_fields <= MAX_OFFSET_FIELDS) {
            return Err(FitError::OffsetTooLarge { fields: offset_fields });
        }
        let ratio = self.axis_ratio();
        if !(ratio <= MAX_AXIS_RATIO) {
            return Err(FitError::AxisRatio { ratio });
        }
        Ok(())
    }
}
