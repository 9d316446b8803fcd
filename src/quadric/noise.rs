//! What noise does to a quadric's mean square, to second order.
//!
//! For `q(x) = xᵀMx + lᵀx + k` and noise of variance `s` on each axis, the Hermite-corrected mean square is
//! `E[q²] − s·E[|∇q|² + q∇²q] + s²(2‖M‖² + (tr M)²)`: three numbers from the second moments. They steer the iteration
//! and become the variance of the residual, so single precision is enough.

use crate::scatter::Scatter;

/// The pieces of a quadric's noise terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoiseTerms {
    /// Mean of `|∇q|²` over the samples.
    pub gradient2: f32,
    /// Mean of `q∇²q`.
    pub curvature: f32,
    /// `‖M‖²`.
    pub norm2: f32,
    /// `(tr M)²`.
    pub trace2: f32,
}

impl NoiseTerms {
    /// Of no quadric at all.
    pub const ZERO: Self = Self { gradient2: 0.0, curvature: 0.0, norm2: 0.0, trace2: 0.0 };

    /// From the coefficients over [`super::gram::QUADRIC`].
    #[inline(never)]
    pub fn of(scatter: &Scatter, beta: &[f64; 10]) -> Self {
        let b = beta.map(|v| v as f32);
        let c = scatter.covariance.map(|v| v as f32);
        let [_, x, y, z, ..] = scatter.moments;
        let mean = [x as f32, y as f32, z as f32];
        let half = 0.5;
        let m = [
            [b[0], half * b[3], half * b[4]],
            [half * b[3], b[1], half * b[5]],
            [half * b[4], half * b[5], b[2]],
        ];
        let c = [[c[0], c[1], c[2]], [c[1], c[3], c[4]], [c[2], c[4], c[5]]];
        let l = [b[6], b[7], b[8]];
        let (mut gradient2, mut norm2, mut value) = (0.0, 0.0, b[9]);
        for i in 0..3 {
            // Half the gradient at the mean, and the spread of its i-th component about that.
            let mut at_mean = half * l[i];
            for j in 0..3 {
                at_mean += m[i][j] * mean[j];
                norm2 += m[i][j] * m[i][j];
                value += m[i][j] * (c[i][j] + mean[i] * mean[j]);
                for k in 0..3 {
                    gradient2 += m[i][j] * c[j][k] * m[i][k];
                }
            }
            value += l[i] * mean[i];
            gradient2 += at_mean * at_mean;
        }
        let trace = b[0] + b[1] + b[2];
        Self { gradient2: 4.0 * gradient2, curvature: 2.0 * trace * value, norm2, trace2: trace * trace }
    }

    /// The coefficients of `s` and `s²` in the corrected mean square.
    pub fn slopes(&self) -> [f32; 2] {
        [-(self.gradient2 + self.curvature), 2.0 * self.norm2 + self.trace2]
    }

    /// The variance of `q` on the ellipsoid for a noise of variance `s`.
    pub fn variance(&self, s: f32) -> f32 {
        // |∇q|² of the samples holds the noise's own part, 4s‖M‖²; half of that is q's own variance. Positive also where s
        // has been raised to the quantisation floor above what the samples hold.
        (s * self.gradient2 - 2.0 * s * s * self.norm2).max(0.5 * s * self.gradient2)
    }
}
