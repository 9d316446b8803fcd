//! The quadric's normal matrix from the moments, its correction for noise, and its factor.
//!
//! Powers of noisy data are biased: `E[x²] = x₀² + σ²`. Replacing each power by its Hermite counterpart (`x² → x²−s`,
//! `x³ → x³−3sx`, `x⁴ → x⁴−6sx²+3s²`, `s = σ²`) gives moments whose expectation is the noise-free one (Markovsky,
//! Kukush, Van Huffel, Numer. Math. 98, 2004), and with them `Ψ(s) = P₀ + sP₁ + s²P₂`.

use super::order::Order;
use crate::dense::{add_scaled, dot, of, put};
use crate::monomial::{COUNT, EXPONENTS, at};

/// The pure monomials of a quadric: `xx yy zz xy xz yz x y z 1`.
pub(crate) const QUADRIC: [[usize; 3]; 10] = [
    [2, 0, 0],
    [0, 2, 0],
    [0, 0, 2],
    [1, 1, 0],
    [1, 0, 1],
    [0, 1, 1],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [0, 0, 0],
];

/// Where the moment of the product of two of them stands.
const PLACE: [[u8; 10]; 10] = places();

const fn places() -> [[u8; 10]; 10] {
    let mut table = [[0; 10]; 10];
    let mut r = 0;
    while r < 10 {
        let mut c = 0;
        while c < 10 {
            let (e, f) = (QUADRIC[r], QUADRIC[c]);
            table[r][c] = at(e[0] + f[0], e[1] + f[1], e[2] + f[2]) as u8;
            c += 1;
        }
        r += 1;
    }
    table
}

/// The mean of the product of two pure monomials, by their places below ten.
#[inline]
pub(crate) fn product(moments: &[f64; COUNT], r: usize, c: usize) -> f64 {
    let place = PLACE.get(r).map_or(0, |row| of(row, c));
    of(moments, usize::from(place))
}

/// The moments corrected for a noise of variance `s`: the Hermite polynomials of each axis in turn, in place.
#[inline(never)]
pub(crate) fn corrected(moments: &[f64; COUNT], s: f32) -> [f64; COUNT] {
    let mut out = *moments;
    if s == 0.0 {
        return out;
    }
    let s = f64::from(s);
    // Of x^{a−2} in the Hermite polynomial of x^a.
    let first = [0.0, 0.0, s, 3.0 * s, 6.0 * s];
    for axis in 0..3 {
        // From the highest degree down, so that the lower powers are still those of the data.
        for (position, e) in EXPONENTS.iter().enumerate().skip(4).rev() {
            let mut lower = e.map(usize::from);
            if lower[axis] >= 2 {
                let factor = first[lower[axis].min(4)];
                lower[axis] -= 2;
                let lower_moment = of(&out, at(lower[0], lower[1], lower[2]));
                let Some(moment) = out.get_mut(position) else { continue };
                *moment -= factor * lower_moment;
                if e[axis] == 4 {
                    *moment += 3.0 * s * s;
                }
            }
        }
    }
    out
}

/// The lower triangle of a symmetric 10×10 matrix.
pub(crate) type Lower = [[f64; 10]; 10];

/// The scatter matrix of the columns `[x²−z², y²−z², xy, xz, yz, x, y, z, 1]` and, last, `x²+y²+z²`.
///
/// The first two span the same traceless squares as the `x²+y²−2z²`, `x²+z²−2y²` of the trace reading in
/// [`crate::moments::Normalisation`], so the least squares solution is the same quadric, for fewer additions.
#[inline(never)]
pub(crate) fn gram(m: &[f64; COUNT], a: &mut Lower) {
    for row in 2..9 {
        let (xx, yy, zz) = (product(m, row + 1, 0), product(m, row + 1, 1), product(m, row + 1, 2));
        a[row][0] = xx - zz;
        a[row][1] = yy - zz;
        a[9][row] = xx + yy + zz;
        for column in 2..=row {
            a[row][column] = product(m, row + 1, column + 1);
        }
    }
    let (xxxx, yyyy, zzzz) = (product(m, 0, 0), product(m, 1, 1), product(m, 2, 2));
    let (xxyy, xxzz, yyzz) = (product(m, 0, 1), product(m, 0, 2), product(m, 1, 2));
    let (x, y, z) = (xxxx - xxzz, yyyy - yyzz, zzzz - xxzz);
    a[0][0] = x + z;
    a[1][0] = xxyy - yyzz + z;
    a[1][1] = y + (zzzz - yyzz);
    a[9][0] = xxxx + xxyy - yyzz - zzzz;
    a[9][1] = xxyy + yyyy - xxzz - zzzz;
    a[9][9] = xxxx + yyyy + zzzz + 2.0 * (xxyy + xxzz + yyzz);
}

/// Factors the leading columns of a symmetric matrix in place, `L D Lᵀ`; nothing above the diagonal is used.
///
/// Below the diagonal comes `L` (whose own diagonal is one), on it `D`. The last row is the right side: `L⁻¹` applied to it and
/// divided by `D`, and in its corner what the columns leave of it. Columns without a parameter in `model` are left out.
/// `false` unless what remains is positive definite.
#[inline(never)]
pub(crate) fn factorise(rows: &mut [[f64; 10]], model: Order) -> bool {
    let mut inverse = [0.0; 10];
    let last = rows.len().saturating_sub(1);
    for r in 0..rows.len().min(10) {
        let (done, rest) = rows.split_at_mut(r);
        let Some(row) = rest.first_mut() else { break };
        let mut pivot = row[r];
        if r < last && !model.uses(r) {
            // It stays zero in the solution and out of the sums.
            row[..r].fill(0.0);
            row[r] = 1.0;
            inverse[r] = 0.0;
            continue;
        }
        // First w = L⁻¹ of the row, then its quotients by D.
        for (c, above) in done.iter().enumerate() {
            if let Some((head, [entry, ..])) = row.split_at_mut_checked(c) {
                *entry -= dot(head, above);
            }
        }
        for (w, inverse) in row[..r].iter_mut().zip(inverse) {
            let l = *w * inverse;
            pivot -= *w * l;
            *w = l;
        }
        row[r] = pivot;
        if r < last {
            // Below this, relative to entries of order one, there is nothing but rounding.
            if !(pivot > 1e-24) {
                return false;
            }
            inverse[r] = 1.0 / pivot;
        }
    }
    true
}

/// The minimiser of `xᵀΨx` with a last element of one, from the factor of `Ψ`.
#[inline(never)]
pub(crate) fn minimiser(rows: &[[f64; 10]]) -> [f64; 10] {
    // Lᵀ x = −(row of the right side), from the last row up.
    let mut x = [0.0; 10];
    put(&mut x, rows.len().saturating_sub(1), 1.0);
    for (r, row) in rows.iter().enumerate().rev() {
        if let Some((head, [value, ..])) = x.split_at_mut_checked(r) {
            add_scaled(head, -*value, row);
        }
    }
    x
}

/// Largest over smallest pivot of a factor: an estimate of the condition number.
pub(crate) fn condition_number(rows: &Lower, model: Order) -> f64 {
    let (mut low, mut high) = (f32::INFINITY, 0.0f32);
    for (i, row) in rows.iter().enumerate().take(9).filter(|(i, _)| model.uses(*i)) {
        let pivot = of(row, i) as f32;
        low = low.min(pivot);
        high = high.max(pivot);
    }
    f64::from(high / low)
}

/// Coefficients over [`QUADRIC`] of a solution over the columns of [`gram`].
pub(crate) fn pure(x: &[f64; 10]) -> [f64; 10] {
    [x[9] + x[0], x[9] + x[1], x[9] - x[0] - x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8]]
}

/// `P β`, the scatter matrix over [`QUADRIC`] times coefficients.
#[inline(never)]
pub(crate) fn times(moments: &[f64; COUNT], beta: &[f64; 10]) -> [f64; 10] {
    let mut out = [0.0; 10];
    for (slot, places) in out.iter_mut().zip(&PLACE) {
        let mut row = [0.0; 10];
        for (value, place) in row.iter_mut().zip(places) {
            *value = of(moments, usize::from(*place));
        }
        *slot = dot(&row, beta);
    }
    out
}

/// The mean square of a quadric (coefficients over [`QUADRIC`]) over the samples.
pub(crate) fn mean_square(moments: &[f64; COUNT], beta: &[f64; 10]) -> f64 {
    dot(beta, &times(moments, beta))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_square_of_a_quadric_is_that_over_the_samples() {
        let points = [[0.5, -1.0, 2.0], [1.5, 0.25, -0.5], [-2.0, 1.0, 0.75]];
        let beta = [1.0, 0.5, -0.25, 2.0, -1.0, 0.125, 3.0, -2.0, 1.0, -0.5];
        let power = |base: f64, exponent: usize| (0..exponent).map(|_| base).product::<f64>();
        let monomial = |x: &[f64; 3], e: [usize; 3]| (0..3).map(|a| power(x[a], e[a])).product::<f64>();
        let mut moments = [0.0; COUNT];
        let mut squares = 0.0;
        for point in &points {
            for (moment, exponents) in moments.iter_mut().zip(EXPONENTS) {
                *moment += monomial(point, exponents.map(usize::from)) / 3.0;
            }
            let value: f64 = QUADRIC.iter().zip(beta).map(|(e, b)| b * monomial(point, *e)).sum();
            squares += value * value / 3.0;
        }
        let mean = mean_square(&moments, &beta);
        assert!((mean / squares - 1.0).abs() < 1e-12, "{mean} instead of {squares}");
    }
}
