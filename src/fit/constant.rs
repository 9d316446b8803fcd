//! The paper's own reading: nine columns, eqs. (9)–(15), with the errata corrected.
//!
//! With `Ĥ²` taken as the squared magnitude of the *measurement*, eq. (14) has the solution `p = (1,0,1,0,1,0,0,0,0)` for
//! every data set: the identity. The left side of eq. (5) is the squared magnitude of the true field, a constant; with
//! the term `bᵀQb` that is lost between (5) and (7) it reads `D p = F² − bᵀQb`, and scaled to one `D p = 1`. The scale comes
//! back as `s = 1 + bᵀMb`, `Q = (F²/s) M`. The data must not be centred: the origin is the sensor's own zero.

use crate::math;
use crate::quadric::{Ellipsoid, Order, condition_number, factorise, minimiser, product};
use crate::scatter::Scatter;

/// Nearer to the sensor's zero than this (`|F² − bᵀQb|/F²`), the reading is refused as singular.
pub(crate) const NEAREST_ORIGIN: f64 = 0.02;

/// Solves `DᵀD p = Dᵀ1` for data about the sensor's zero, the columns of eq. (13) in the order `x² y² z² xy xz yz x y z`;
/// the ellipsoid is in the units of that scatter. Also returns an estimate of the condition number.
/// `None` unless there is one.
pub(crate) fn solve(about_zero: &Scatter) -> Option<(Ellipsoid, f64)> {
    let moments = &about_zero.moments;
    let mut factor = [[0.0; 10]; 10];
    for (r, row) in factor.iter_mut().enumerate() {
        for (c, entry) in row.iter_mut().enumerate().take(r + 1) {
            *entry = product(moments, r, c);
        }
    }
    if !factorise(&mut factor, Order::Ellipsoid) {
        return None;
    }
    // The minimiser has +1 for the constant column: −p. Where the origin lies outside the ellipsoid, M of p is negative
    // definite and so is s: the quadric −p is the same, and has neither.
    let x = minimiser(&factor);
    let sign = if x[0] < 0.0 { -1.0 } else { 1.0 };
    let p = x.map(|v| v * sign);
    let m = [p[0], 0.5 * p[3], 0.5 * p[4], p[1], 0.5 * p[5], p[2]];
    let ellipsoid = Ellipsoid::from_quadric(&m, [p[6], p[7], p[8]], p[9])?;
    Some((ellipsoid, condition_number(&factor, Order::Ellipsoid)))
}

/// `|F² − bᵀQb|/F²` of an ellipsoid given about the sensor's zero: zero where the reading is singular.
pub(crate) fn distance_from_origin(ellipsoid: &Ellipsoid) -> f64 {
    let (c, b) = (&ellipsoid.factor, &ellipsoid.centre);
    let h = [c[0] * b[0] + c[1] * b[1] + c[2] * b[2], c[3] * b[1] + c[4] * b[2], c[5] * b[2]];
    math::abs(1.0 - (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]))
}
