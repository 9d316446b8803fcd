//! From a quadric to centre, scale and a positive definite `C`. Every refusal of a shape lives here.

use super::gram::{factorise, minimiser};
use super::order::Order;
use crate::dense::{self, all_finite, dot};
use crate::math;
use crate::refusal::FitError;

/// Largest offset accepted, in fields. Real boards show 7.
pub const MAX_OFFSET_FIELDS: f32 = 20.0;
/// Largest ratio of the ellipsoid's semi-axes accepted. Real boards stay under 2; the paper's simulation has 3.3.
pub const MAX_AXIS_RATIO: f32 = 6.0;

/// An upper triangular 3×3 matrix: entries 11, 12, 13, 22, 23, 33.
pub(crate) type Upper = [f64; 6];
/// A symmetric 3×3 matrix, the same six entries.
pub(crate) type Symmetric = [f64; 6];

/// The ellipsoid `‖C(x − b)‖ = 1` in the units of the scatter it was fitted to, and the scale of the quadric it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipsoid {
    /// Centre `b`.
    pub centre: [f64; 3],
    /// `C`, upper triangular with a positive diagonal: the Cholesky factor of `Q = CᵀC` (paper eq. (11), corrected).
    pub factor: Upper,
    /// The quadric was `s(‖C(x − b)‖² − 1)`.
    pub s: f64,
}

impl Ellipsoid {
    /// The ellipsoid of `xᵀMx + lᵀx + k = 0`, with `b = −½M⁻¹l` (paper eq. (12)) and `s = bᵀMb − k`, `Q = M/s`. `None` unless `M`
    /// and `s` are positive; a quadric and its negative are the same, and it is for the caller to choose.
    pub fn from_quadric(m: &Symmetric, l: [f64; 3], k: f64) -> Option<Self> {
        // M = L D Lᵀ with ½l as its right side: that leaves k − ¼ lᵀM⁻¹l = −s of the constant.
        let mut rows = [[0.0; 10]; 4];
        let [xx, xy, xz, yy, yz, zz] = *m;
        rows[0][0] = xx;
        [rows[1][0], rows[1][1]] = [xy, yy];
        [rows[2][0], rows[2][1], rows[2][2]] = [xz, yz, zz];
        for (slot, l) in rows[3].iter_mut().zip(l) {
            *slot = 0.5 * l;
        }
        rows[3][3] = k;
        if !factorise(&mut rows, Order::Ellipsoid) {
            return None;
        }
        let s = -rows[3][3];
        // Written so that a NaN is refused too.
        if !(s > 0.0) {
            return None;
        }
        let [x, y, z, ..] = minimiser(&rows);
        // C = (D/s)^½ Lᵀ.
        let [a, b, c, _] = &rows;
        let [first, second, third] = [a[0], b[1], c[2]].map(|pivot| dense::root(pivot / s));
        let factor = [first, first * b[0], first * c[0], second, second * c[1], third];
        let ellipsoid = Self { centre: [x, y, z], factor, s };
        if !all_finite(&ellipsoid.centre) || !all_finite(&ellipsoid.factor) {
            return None;
        }
        Some(ellipsoid)
    }

    /// The ellipsoid of coefficients over [`super::gram::QUADRIC`].
    pub fn from_coefficients(beta: &[f64; 10]) -> Option<Self> {
        let [xx, yy, zz, xy, xz, yz, x, y, z, k] = *beta;
        Self::from_quadric(&[xx, 0.5 * xy, 0.5 * xz, yy, 0.5 * yz, zz], [x, y, z], k)
    }

    /// Coefficients of `‖C(x−b)‖² − 1` over [`super::gram::QUADRIC`].
    pub fn quadric(&self) -> [f64; 10] {
        let [xx, xy, xz, yy, yz, zz] = self.q();
        let [x, y, z] = self.centre;
        let qb = [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z];
        let k = qb[0] * x + qb[1] * y + qb[2] * z - 1.0;
        [xx, yy, zz, 2.0 * xy, 2.0 * xz, 2.0 * yz, -2.0 * qb[0], -2.0 * qb[1], -2.0 * qb[2], k]
    }

    /// `Q = CᵀC`.
    pub fn q(&self) -> Symmetric {
        let [c11, c12, c13, c22, c23, c33] = self.factor;
        let (a, b, c) = ([c11], [c12, c22], [c13, c23, c33]);
        [dot(&a, &a), dot(&a, &b), dot(&a, &c), dot(&b, &b), dot(&b, &c), dot(&c, &c)]
    }

    /// Longest over shortest semi-axis, to single precision.
    fn axis_ratio(&self) -> f32 {
        let [low, _, high] = math::eigenvalues_3x3_f32(&self.q().map(|v| v as f32));
        if low > 0.0 { math::sqrtf(high / low) } else { f32::INFINITY }
    }

    /// Refuses offsets and shapes that no magnetometer has. `offset_fields` is the offset over the field magnitude.
    /// Returns the axis ratio.
    ///
    /// # Errors
    /// [`FitError::OffsetTooLarge`], [`FitError::AxisRatio`].
    pub fn check_plausible(&self, offset_fields: f32) -> Result<f32, FitError> {
        // Written so that a NaN is refused too.
        if !(offset_fields <= MAX_OFFSET_FIELDS) {
            return Err(FitError::OffsetTooLarge { fields: offset_fields.into() });
        }
        let ratio = self.axis_ratio();
        if !(ratio <= MAX_AXIS_RATIO) {
            return Err(FitError::AxisRatio { ratio: ratio.into() });
        }
        Ok(ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipsoid_comes_back_from_its_quadric() {
        // (x−1)²/4 + (y+2)² + (z−3)²·4 + 0.2 xy-shear, written out from C and b.
        let truth = Ellipsoid { centre: [1.0, -2.0, 3.0], factor: [0.5, 0.1, -0.05, 1.0, 0.2, 2.0], s: 1.0 };
        let q = truth.q();
        let row = [
            q[0] * 1.0 + q[1] * -2.0 + q[2] * 3.0,
            q[1] * 1.0 + q[3] * -2.0 + q[4] * 3.0,
            q[2] * 1.0 + q[4] * -2.0 + q[5] * 3.0,
        ];
        let k = row[0] - 2.0 * row[1] + 3.0 * row[2] - 1.0;
        let found = Ellipsoid::from_quadric(&q.map(|v| v * 3.0), row.map(|v| -6.0 * v), k * 3.0).unwrap();
        for (a, b) in found.centre.iter().chain(&found.factor).zip(truth.centre.iter().chain(&truth.factor)) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
        assert!((found.s - 3.0).abs() < 1e-12);
        assert!(Ellipsoid::from_quadric(&[1.0, 0.0, 0.0, 1.0, 0.0, -1.0], [0.0; 3], -1.0).is_none());
        assert!(Ellipsoid::from_quadric(&[1.0, 0.0, 0.0, 1.0, 0.0, 1.0], [0.0; 3], 1.0).is_none());
        assert!(Ellipsoid::from_quadric(&[f64::NAN; 6], [0.0; 3], 1.0).is_none());
    }
}
