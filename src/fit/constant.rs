//! The paper's own reading: nine columns, eqs. (9)–(15), with the errata corrected.
//!
//! With `Ĥ²` taken as the squared magnitude of the *measurement*, eq. (14) has the solution `p = (1,0,1,0,1,0,0,0,0)` for
//! every data set: the identity. The left side of eq. (5) is the squared magnitude of the true field, a constant; with
//! the term `bᵀQb` that is lost between (5) and (7) it reads `D p = F² − bᵀQb`, and scaled to one `D p = 1`. The scale comes
//! back as `s = 1 + bᵀMb`, `Q = (F²/s) M`. The data must not be centred: the origin is the sensor's own zero.

use super::FitError;
use crate::math;
use crate::quadric::Ellipsoid;
use crate::scatter::Scatter;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Monomials of the paper's nine columns, eq. (13): `x² x y² y z² z xy zy xz`.
const COLUMNS: [[usize; 3]; 9] =
    [[2, 0, 0], [1, 0, 0], [0, 2, 0], [0, 1, 0], [0, 0, 2], [0, 0, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]];

/// Nearer to the sensor's zero than this (`|F² − bᵀQb|/F²`), the reading is refused as singular.
pub(crate) const NEAREST_ORIGIN: f64 = 0.02;

/// Solves `DᵀD p = Dᵀ1` for data about the sensor's zero; the ellipsoid is in the units of that scatter. Also returns an
/// estimate of the condition number.
///
/// # Errors
/// [`FitError::NotAnEllipsoid`].
pub(crate) fn solve(about_zero: &Scatter) -> Result<(Ellipsoid, f64), FitError> {
    let mut dtd = SMatrix::<f64, 9, 9>::zeros();
    let mut p = SVector::<f64, 9>::zeros();
    for r in 0..9 {
        let e = COLUMNS[r];
        p[r] = about_zero.moment(e[0], e[1], e[2]);
        for c in 0..9 {
            let f = COLUMNS[c];
            dtd[(r, c)] = about_zero.moment(e[0] + f[0], e[1] + f[1], e[2] + f[2]);
        }
    }
    let cholesky = dtd.cholesky().ok_or(FitError::NotAnEllipsoid)?;
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for i in 0..9 {
        let d = cholesky.l_dirty()[(i, i)];
        low = low.min(d);
        high = high.max(d);
    }
    cholesky.solve_mut(&mut p);
    let m = Matrix3::new(
        p[0],
        0.5 * p[6],
        0.5 * p[8],
        0.5 * p[6],
        p[2],
        0.5 * p[7],
        0.5 * p[8],
        0.5 * p[7],
        p[4],
    );
    let g = Vector3::new(p[1], p[3], p[5]);
    // Eq. (12) is b = −½M⁻¹g; M may be negative definite, so it is solved by LU.
    let centre = m.lu().solve(&g).ok_or(FitError::NotAnEllipsoid)? * -0.5;
    let s = 1.0 + centre.dot(&(m * centre));
    if s == 0.0 || !s.is_finite() {
        return Err(FitError::NotAnEllipsoid);
    }
    Ok((Ellipsoid::from_quadric(m, centre, s)?, (high / low) * (high / low)))
}

/// `|F² − bᵀQb|/F²` of an ellipsoid given about the sensor's zero: zero where the reading is singular.
pub(crate) fn distance_from_origin(ellipsoid: &Ellipsoid) -> f64 {
    math::abs(1.0 - (ellipsoid.factor * ellipsoid.centre).norm_squared())
}
