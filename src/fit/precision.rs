//! Standard errors from the sums, and what they make of a corrected vector.
//!
//! `Cov(b, C) = V (GᵀΨ(s)G)⁻¹` with `G = ∂β/∂(b, C)` (10×9), `β` the coefficients of `‖C(x−b)‖² − 1`, `Ψ` the noise-corrected
//! scatter, `V = (4sm − 2s² tr Q²)/n` and `m` the mean of `(x−b)ᵀQ²(x−b)`.

use super::psi::{Matrix10, QUADRIC};
use crate::quadric::Ellipsoid;
use crate::scatter::Scatter;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

/// A 9×9 matrix over `(b₁, b₂, b₃, C₁₁, C₁₂, C₁₃, C₂₂, C₂₃, C₃₃)`.
pub type Matrix9 = SMatrix<f64, 9, 9>;

/// Row and column of each of the six entries of the triangular `C`, in the order of the covariance.
pub const TRIANGLE: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Weak physical prior, one standard deviation: gains within some 20 % of each other …
const GAIN_SPREAD: f64 = 0.2;
/// … axes within some 10° of orthogonal.
const AXIS_SPREAD_RAD: f64 = 0.17;

/// `∂β/∂(b, C)` over the pure monomials of [`QUADRIC`].
fn jacobian(ellipsoid: &Ellipsoid) -> SMatrix<f64, 10, 9> {
    let (b, c, q) = (ellipsoid.centre, ellipsoid.factor, ellipsoid.q());
    let mut g = SMatrix::<f64, 10, 9>::zeros();
    let mut fill = |column: usize, dq: Matrix3<f64>, linear: Vector3<f64>, constant: f64| {
        for (row, e) in QUADRIC.iter().enumerate().take(6) {
            let mut axes = [0usize; 2];
            let mut at = 0;
            for (axis, &power) in e.iter().enumerate() {
                for _ in 0..power {
                    axes[at.min(1)] = axis;
                    at += 1;
                }
            }
            let factor = if axes[0] == axes[1] { 1.0 } else { 2.0 };
            g[(row, column)] = factor * dq[(axes[0], axes[1])];
        }
        for axis in 0..3 {
            g[(6 + axis, column)] = linear[axis];
        }
        g[(9, column)] = constant;
    };
    let qb = q * b;
    for axis in 0..3 {
        fill(axis, Matrix3::zeros(), q.column(axis) * -2.0, 2.0 * qb[axis]);
    }
    for (i, (j, k)) in TRIANGLE.iter().copied().enumerate() {
        // Q = CᵀC: δQ = e_k c_j + c_jᵀ e_kᵀ with c_j the j-th row of C.
        let mut dq = Matrix3::zeros();
        for column in 0..3 {
            dq[(k, column)] += c[(j, column)];
            dq[(column, k)] += c[(j, column)];
        }
        let dqb = dq * b;
        fill(3 + i, dq, dqb * -2.0, b.dot(&dqb));
    }
    g
}

/// What the noise does to an ellipsoid.
pub(crate) struct Noise {
    /// Mean of `(x−b)ᵀQ²(x−b)`.
    pub m: f64,
    /// `tr Q²`.
    pub trace_q2: f64,
}

impl Noise {
    pub fn of(scatter: &Scatter, ellipsoid: &Ellipsoid) -> Self {
        let q = ellipsoid.q();
        let q2 = q * q;
        let covariance = scatter.covariance();
        let mean = Vector3::new(scatter.moment(1, 0, 0), scatter.moment(0, 1, 0), scatter.moment(0, 0, 1));
        let off = mean - ellipsoid.centre;
        let mut m = off.dot(&(q2 * off));
        for r in 0..3 {
            for c in 0..3 {
                m += q2[(r, c)] * covariance[r][c];
            }
        }
        Self { m, trace_q2: q2.trace() }
    }

    /// Variance of `‖C(x−b)‖² − 1` for a noise variance `s` per axis.
    pub fn variance(&self, s: f64) -> f64 {
        // Positive also where s has been raised to the quantisation floor above what m holds.
        (4.0 * s * self.m - 2.0 * s * s * self.trace_q2).max(2.0 * s * self.m)
    }
}

/// The information (inverse covariance) of `(b, C)` from `samples` samples of noise variance `s`.
pub(crate) fn information(psi: &Matrix10, ellipsoid: &Ellipsoid, variance: f64, samples: f64) -> Matrix9 {
    let g = jacobian(ellipsoid);
    let information = g.transpose() * (psi * g);
    information * (samples / variance)
}

/// The information of the weak physical prior about `ellipsoid`: for acceptance of a model that leaves parameters out.
pub(crate) fn prior(ellipsoid: &Ellipsoid) -> Matrix9 {
    let c = ellipsoid.factor;
    let scale = (c[(0, 0)] + c[(1, 1)] + c[(2, 2)]) / 3.0;
    let mut information = Matrix9::zeros();
    // The common scale is not in doubt, only what the gains differ by: with g = δC_ii/scale, Σ(g − ḡ)²/spread².
    let gain = 1.0 / (GAIN_SPREAD * scale * GAIN_SPREAD * scale);
    for (i, (j, k)) in TRIANGLE.iter().copied().enumerate() {
        for (l, (p, q)) in TRIANGLE.iter().copied().enumerate() {
            if j == k && p == q {
                information[(3 + i, 3 + l)] = gain * (if i == l { 2.0 / 3.0 } else { -1.0 / 3.0 });
            } else if i == l {
                information[(3 + i, 3 + l)] = 1.0 / (AXIS_SPREAD_RAD * scale * AXIS_SPREAD_RAD * scale);
            }
        }
    }
    information
}

/// The inverse of an information matrix; `None` unless positive definite.
pub fn invert(information: &Matrix9) -> Option<Matrix9> {
    // Unit diagonal first: offsets and matrix entries differ by orders of magnitude.
    let mut scale = [0.0; 9];
    for (i, s) in scale.iter_mut().enumerate() {
        let d = information[(i, i)];
        if !(d > 0.0 && d.is_finite()) {
            return None;
        }
        *s = 1.0 / crate::math::sqrt(d);
    }
    let unit = Matrix9::from_fn(|r, c| information[(r, c)] * scale[r] * scale[c]);
    let inverse = unit.cholesky()?.inverse();
    let covariance = Matrix9::from_fn(|r, c| inverse[(r, c)] * scale[r] * scale[c]);
    covariance.iter().all(|v| v.is_finite()).then_some(covariance)
}

/// The 1σ error of the corrected vector (rms length), in units of the field, in the worst direction of the sphere.
///
/// `δh = δC y − C δb` with `y = A u`; its mean square is a quadratic form in `(y, 1)`, looked at in 26 directions.
pub fn worst_direction_error(factor: &Matrix3<f64>, covariance: &Matrix9) -> f64 {
    let Some(a) = factor.try_inverse() else { return f64::INFINITY };
    let mut w = Matrix4::<f64>::zeros();
    for i in 0..3 {
        for (p, (j, k)) in TRIANGLE.iter().copied().enumerate().filter(|(_, (j, _))| *j == i) {
            for (q, (_, l)) in TRIANGLE.iter().copied().enumerate().filter(|(_, (r, _))| *r == j) {
                w[(k, l)] += covariance[(3 + p, 3 + q)];
            }
            let mut cross = 0.0;
            for c in 0..3 {
                cross -= factor[(i, c)] * covariance[(3 + p, c)];
            }
            w[(k, 3)] += cross;
            w[(3, k)] += cross;
        }
        for c in 0..3 {
            for d in 0..3 {
                w[(3, 3)] += factor[(i, c)] * factor[(i, d)] * covariance[(c, d)];
            }
        }
    }
    let mut worst = 0.0f64;
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                if (x, y, z) == (0, 0, 0) {
                    continue;
                }
                let u = Vector3::new(f64::from(x), f64::from(y), f64::from(z)).normalize();
                let v = a * u;
                let v = Vector4::new(v[0], v[1], v[2], 1.0);
                worst = worst.max(v.dot(&(w * v)));
            }
        }
    }
    crate::math::sqrt(worst)
}
