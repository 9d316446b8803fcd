//! The 10×10 scatter matrix of the quadric's monomials and its correction for noise.
//!
//! Powers of noisy data are biased: `E[x²] = x₀² + σ²`. Replacing each power by its Hermite counterpart (`x² → x²−s`,
//! `x³ → x³−3sx`, `x⁴ → x⁴−6sx²+3s²`, `s = σ²`) gives `Ψ(s) = P₀ + sP₁ + s²P₂`, whose expectation is the noise-free
//! scatter matrix (Markovsky, Kukush, Van Huffel, Numer. Math. 98, 2004). `Ψ` is linear in the 34 sums.

use crate::scatter::Scatter;
use nalgebra::{SMatrix, SVector};

pub(crate) type Matrix10 = SMatrix<f64, 10, 10>;
pub(crate) type Vector10 = SVector<f64, 10>;

/// The pure monomials of a quadric, in the order of the 10×10 matrices.
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

/// Coefficients `q_a` of `−s x^{a−2}` in the Hermite polynomial of `x^a`.
const FIRST: [f64; 5] = [0.0, 0.0, 1.0, 3.0, 6.0];

/// `P₀, P₁, P₂` over the pure monomials [`QUADRIC`].
pub(crate) fn hermite(scatter: &Scatter) -> [Matrix10; 3] {
    let mut p = [Matrix10::zeros(); 3];
    for row in 0..10 {
        for column in 0..=row {
            let e: [usize; 3] = core::array::from_fn(|a| QUADRIC[row][a] + QUADRIC[column][a]);
            let values = corrected(scatter, e);
            for (matrix, value) in p.iter_mut().zip(values) {
                matrix[(row, column)] = value;
                matrix[(column, row)] = value;
            }
        }
    }
    p
}

/// The coefficients of `1, s, s²` in the noise-corrected moment of `xⁱyʲzᵏ`.
fn corrected(scatter: &Scatter, e: [usize; 3]) -> [f64; 3] {
    let lower = |down: [usize; 3]| scatter.moment(e[0] - down[0], e[1] - down[1], e[2] - down[2]);
    let (mut first, mut second) = (0.0, 0.0);
    for a in 0..3 {
        if e[a] >= 2 {
            let mut down = [0; 3];
            down[a] = 2;
            first -= FIRST[e[a]] * lower(down);
        }
        if e[a] == 4 {
            second += 3.0;
        }
        for b in a + 1..3 {
            if e[a] == 2 && e[b] == 2 {
                second += 1.0;
            }
        }
    }
    [scatter.moment(e[0], e[1], e[2]), first, second]
}

/// Changes a symmetric matrix over [`QUADRIC`] to the basis of the trace reading,
/// `[x²+y²−2z², x²+z²−2y², 2xy, 2xz, 2yz, 2x, 2y, 2z, 1, x²+y²+z²]`.
pub(crate) fn to_trace_basis(pure: &Matrix10) -> Matrix10 {
    let rows = |m: &Matrix10| {
        let mut out = Matrix10::zeros();
        for c in 0..10 {
            let (xx, yy, zz) = (m[(0, c)], m[(1, c)], m[(2, c)]);
            out[(0, c)] = xx + yy - 2.0 * zz;
            out[(1, c)] = xx + zz - 2.0 * yy;
            for r in 2..8 {
                out[(r, c)] = 2.0 * m[(r + 1, c)];
            }
            out[(8, c)] = m[(9, c)];
            out[(9, c)] = xx + yy + zz;
        }
        out
    };
    // T·H·Tᵀ: the same row operation twice, H being symmetric.
    rows(&rows(pure).transpose())
}

/// A quadratic form `xᵀPx`.
pub(crate) fn quadratic_form(p: &Matrix10, x: &Vector10) -> f64 {
    let mut total = 0.0;
    for r in 0..10 {
        let mut off = 0.0;
        for c in 0..r {
            off += p[(r, c)] * x[c];
        }
        total += x[r] * (2.0 * off + p[(r, r)] * x[r]);
    }
    total
}
