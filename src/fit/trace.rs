//! Trace normalisation: the robust reading of the paper's eq. (14), and the one solver behind the trace and the
//! adjusted method and their lower orders.

use super::FitError;
use super::psi::{Matrix10, Vector10};
use crate::quadric::Ellipsoid;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Which of the trace reading's nine columns carry a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// All nine: offset, gains, non-orthogonality.
    Ellipsoid,
    /// Six: offset and gains, axes orthogonal.
    AxisAligned,
    /// Four: offset and one scale.
    Sphere,
}

impl Model {
    /// Number of parameters of the quadric.
    pub const fn parameters(self) -> usize {
        match self {
            Self::Ellipsoid => 9,
            Self::AxisAligned => 6,
            Self::Sphere => 4,
        }
    }

    /// A word for reports: `ellipsoid`, `axis-aligned`, `sphere`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => "ellipsoid",
            Self::AxisAligned => "axis-aligned",
            Self::Sphere => "sphere",
        }
    }

    const fn uses(self, column: usize) -> bool {
        match self {
            Self::Ellipsoid => true,
            Self::AxisAligned => column < 2 || column > 4,
            Self::Sphere => column > 4,
        }
    }
}

/// The minimiser of `xᵀΨx` with `x₉ = 1`: `x = [−Ψ₉⁻¹ψ; 1]`, and an estimate of the condition number of `Ψ₉`.
/// `None` if `Ψ₉` is not positive definite. Columns the model leaves out stay zero.
pub(crate) fn minimise(psi: &Matrix10, model: Model) -> Option<(Vector10, f64)> {
    let mut leading = SMatrix::<f64, 9, 9>::zeros();
    let mut right = SVector::<f64, 9>::zeros();
    for r in 0..9 {
        if !model.uses(r) {
            leading[(r, r)] = 1.0;
            continue;
        }
        right[r] = -psi[(r, 9)];
        for c in 0..9 {
            if model.uses(c) {
                leading[(r, c)] = psi[(r, c)];
            }
        }
    }
    let cholesky = leading.cholesky()?;
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for i in (0..9).filter(|&i| model.uses(i)) {
        let d = cholesky.l_dirty()[(i, i)];
        low = low.min(d);
        high = high.max(d);
    }
    cholesky.solve_mut(&mut right);
    let mut x = Vector10::zeros();
    for r in 0..9 {
        x[r] = right[r];
    }
    x[9] = 1.0;
    x.iter().all(|v| v.is_finite()).then_some((x, (high / low) * (high / low)))
}

/// The ellipsoid of a solution of the trace reading (theory: `u = −x`, `M = [[1−u₁−u₂, −u₃, −u₄], …]`, `b = M⁻¹(u₆,u₇,u₈)`,
/// `s = bᵀMb + u₉`, `Q = M/s`).
///
/// # Errors
/// [`FitError::NotAnEllipsoid`].
pub(crate) fn ellipsoid(x: &Vector10) -> Result<Ellipsoid, FitError> {
    let u = -x;
    let m = Matrix3::new(
        1.0 - u[0] - u[1],
        -u[2],
        -u[3],
        -u[2],
        1.0 - u[0] + 2.0 * u[1],
        -u[4],
        -u[3],
        -u[4],
        1.0 + 2.0 * u[0] - u[1],
    );
    let g = Vector3::new(u[5], u[6], u[7]);
    let centre = m.cholesky().ok_or(FitError::NotAnEllipsoid)?.solve(&g);
    let s = g.dot(&centre) + u[8];
    if s <= 0.0 {
        return Err(FitError::NotAnEllipsoid);
    }
    Ellipsoid::from_quadric(m, centre, s)
}
