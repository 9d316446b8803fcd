//! Standard errors from the sums, and what they make of a corrected vector.
//!
//! The quadric's nine coefficients have the covariance `V Ψ₉⁻¹`, and `Ψ₉ = L D Lᵀ` is at hand from the solve: the columns of
//! `L⁻ᵀ D^{−½}`, carried over to `(b, C)`, are a square root of the covariance of the calibration. (It is the
//! `V (GᵀΨG)⁻¹` of the theory, since `Ψ` is zero along the solution itself.) A square root has half the digits at stake:
//! single precision is enough from here on.

use crate::dense::{add_scaled_f32, dot_f32, of, put, scale_f32};
use crate::math::sqrtf;
use crate::quadric::{Ellipsoid, Lower};

pub use crate::vector::TRIANGLE;

/// Weak physical prior, one standard deviation: gains within some 20 % of each other …
const GAIN_SPREAD: f32 = 0.2;
/// … axes within some 10° of orthogonal.
const AXIS_SPREAD_RAD: f32 = 0.17;

type Upper = [f32; 6];

/// Product of an upper triangular matrix and a vector.
fn times(c: &Upper, v: [f32; 3]) -> [f32; 3] {
    [c[0] * v[0] + c[1] * v[1] + c[2] * v[2], c[3] * v[1] + c[4] * v[2], c[5] * v[2]]
}

/// Product of its transpose and a vector.
fn transposed_times(c: &Upper, v: [f32; 3]) -> [f32; 3] {
    [c[0] * v[0], c[1] * v[0] + c[3] * v[1], c[2] * v[0] + c[4] * v[1] + c[5] * v[2]]
}

/// Product of two upper triangular matrices.
fn product_upper(a: &Upper, b: &Upper) -> Upper {
    [
        a[0] * b[0],
        a[0] * b[1] + a[1] * b[3],
        a[0] * b[2] + a[1] * b[4] + a[2] * b[5],
        a[3] * b[3],
        a[3] * b[4] + a[4] * b[5],
        a[5] * b[5],
    ]
}

/// Inverse of an upper triangular matrix.
fn inverse(c: &Upper) -> Upper {
    let (a11, a22, a33) = (1.0 / c[0], 1.0 / c[3], 1.0 / c[5]);
    let a12 = -c[1] * a11 * a22;
    let a23 = -c[4] * a22 * a33;
    [a11, a12, -(c[1] * a23 + c[2] * a33) * a11, a22, a23, a33]
}

/// An ellipsoid in single precision, with `A = C⁻¹`.
struct Shape {
    centre: [f32; 3],
    c: Upper,
    a: Upper,
    s: f32,
}

impl Shape {
    fn of(ellipsoid: &Ellipsoid) -> Self {
        let c = ellipsoid.factor.map(|v| v as f32);
        Self { centre: ellipsoid.centre.map(|v| v as f32), c, a: inverse(&c), s: ellipsoid.s as f32 }
    }

    /// What a change of the quadric's coefficients over the columns of `gram` makes of `(b, C)`.
    ///
    /// In the corrected frame, `h = C(x−b)`, with `C → (1+E)C` and `b → b + A d`, the quadric changes by
    /// `δs(hᵀh−1) + s(2hᵀEh − 2hᵀd)`; comparing powers of `h` gives `E` and `d`.
    #[inline(never)]
    fn change(&self, v: &[f32; 9]) -> [f32; 9] {
        let m = [
            [v[0], 0.5 * v[2], 0.5 * v[3]],
            [0.5 * v[2], v[1], 0.5 * v[4]],
            [0.5 * v[3], 0.5 * v[4], -v[0] - v[1]],
        ];
        let a = &self.a;
        let columns = [[a[0], 0.0, 0.0], [a[1], a[3], 0.0], [a[2], a[4], a[5]]];
        let half = self.s * -2.0;
        // Row r of M applied to the centre and, with half the linear part, twice what is left of it.
        let mut linear = [0.0; 3];
        let mut ds = -v[8];
        for ((slot, row), (l, b)) in linear.iter_mut().zip(&m).zip(v[5..].iter().zip(&self.centre)) {
            let mb = dot_f32(row, &self.centre);
            ds -= (mb + l) * b;
            *slot = (2.0 * mb + l) / half;
        }
        let d = transposed_times(a, linear);
        let mut e = [0.0; 6];
        for (slot, (j, k)) in e.iter_mut().zip(TRIANGLE) {
            let mut entry = 0.0;
            for (row, weight) in m.iter().zip(of(&columns, j)) {
                entry += weight * dot_f32(row, &of(&columns, k));
            }
            *slot = if j == k { 0.5 * (entry - ds) } else { entry } / self.s;
        }
        join(times(a, d), product_upper(&e, &self.c))
    }
}

fn join(b: [f32; 3], c: Upper) -> [f32; 9] {
    [b[0], b[1], b[2], c[0], c[1], c[2], c[3], c[4], c[5]]
}

/// A square root of the covariance of `(b₁, b₂, b₃, C₁₁, C₁₂, C₁₃, C₂₂, C₂₃, C₃₃)`: nine independent changes of one standard
/// deviation each, whose squares add up.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Spread {
    changes: [[f32; 9]; 9],
}

/// Columns of `L⁻ᵀ D^{−½}` times a factor. Where a pivot is not positive they are not finite.
#[inline(never)]
fn root_of_inverse(rows: &Lower, factor: f32, columns: &mut [[f32; 9]; 9]) {
    // Upper triangular: Lᵀ, row by row.
    let mut upper = [[0.0f32; 9]; 9];
    for (r, row) in rows.iter().enumerate().take(9) {
        for (value, to) in row.iter().zip(&mut upper).take(r + 1) {
            put(to, r, *value as f32);
        }
    }
    for (j, column) in columns.iter_mut().enumerate() {
        column.fill(0.0);
        let pivot = upper.get(j).map_or(0.0, |row| of(row, j));
        put(column, j, factor / sqrtf(pivot));
        for (i, row) in upper.iter().enumerate().take(j).rev() {
            if let (Some(row), Some(below)) = (row.get(i + 1..=j), column.get(i + 1..=j)) {
                let value = -dot_f32(row, below);
                put(column, i, value);
            }
        }
    }
}

impl Spread {
    /// Nothing is uncertain: room for a spread.
    pub(crate) const ZERO: Self = Self { changes: [[0.0; 9]; 9] };

    /// Takes the spread from the factor of the normal matrix of a full quadric. `variance` is that of one sample's residual,
    /// in the quadric's own scale, over the number of samples.
    #[inline(never)]
    pub(crate) fn set_from_factor(&mut self, factor: &Lower, ellipsoid: &Ellipsoid, variance: f32) {
        let shape = Shape::of(ellipsoid);
        root_of_inverse(factor, sqrtf(variance), &mut self.changes);
        for change in &mut self.changes {
            *change = shape.change(change);
        }
    }

    /// Adds the weak physical prior: for a model that leaves parameters out, so that what the data do not say counts as
    /// unknown, within what magnetometers are.
    #[inline(never)]
    pub(crate) fn add_prior(&mut self, ellipsoid: &Ellipsoid) {
        // The common scale is not in doubt, only what the gains differ by: two contrasts of the three.
        const R2: f32 = core::f32::consts::FRAC_1_SQRT_2 / GAIN_SPREAD;
        const R6: f32 = 0.408_248_3 / GAIN_SPREAD;
        const X: f32 = 1.0 / AXIS_SPREAD_RAD;
        // Over C's six entries, in units of the prior's standard deviation.
        const ROWS: [[f32; 6]; 5] = [
            [R2, 0.0, 0.0, -R2, 0.0, 0.0],
            [R6, 0.0, 0.0, R6, 0.0, -2.0 * R6],
            [0.0, X, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, X, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, X, 0.0],
        ];
        let [c11, _, _, c22, _, c33] = ellipsoid.factor;
        let sigma = (c11 + c22 + c33) as f32 / 3.0;
        for row in &ROWS {
            self.observe(row, sigma);
        }
    }

    /// The spread after an observation of `row · C` with the standard deviation `sigma`: Potter's square-root update, which
    /// keeps the covariance positive definite in single precision.
    fn observe(&mut self, row: &[f32; 6], sigma: f32) {
        let mut along = [0.0; 9];
        for (slot, change) in along.iter_mut().zip(&self.changes) {
            *slot = dot_f32(&change[3..], row);
        }
        let r = sigma * sigma;
        let total = dot_f32(&along, &along) + r;
        let gamma = 1.0 / (total + sqrtf(total * r));
        let mut gain = [0.0; 9];
        for (change, a) in self.changes.iter().zip(along) {
            add_scaled_f32(&mut gain, a, change);
        }
        for (change, a) in self.changes.iter_mut().zip(along) {
            add_scaled_f32(change, -gamma * a, &gain);
        }
    }

    /// The same in other units: the first three, and the last six numbers of each change times a factor.
    pub(crate) fn scale(&mut self, offset: f32, matrix: f32) {
        for change in &mut self.changes {
            let (b, c) = change.split_at_mut(3);
            scale_f32(b, offset);
            scale_f32(c, matrix);
        }
    }

    /// The standard errors of the nine numbers.
    pub fn std_errors(&self) -> [f32; 9] {
        let mut squares = [0.0f32; 9];
        for change in &self.changes {
            for (square, value) in squares.iter_mut().zip(change) {
                *square += value * value;
            }
        }
        squares.map(sqrtf)
    }

    /// The covariance of the nine numbers: symmetric, positive definite.
    pub fn covariance(&self) -> [[f64; 9]; 9] {
        core::array::from_fn(|r| core::array::from_fn(|c| self.product(r, c)))
    }

    /// The covariance of two of the nine numbers.
    pub(crate) fn product(&self, r: usize, c: usize) -> f64 {
        self.changes.iter().map(|k| f64::from(of(k, r)) * f64::from(of(k, c))).sum()
    }

    /// The 1σ error of the corrected vector (rms length), in units of the field, in the worst direction of the sphere.
    ///
    /// `δh = E h − d` with `E = δC A` and `d = C δb`; its mean square is a quadratic form in `(h, 1)`, looked at in the 26
    /// directions of a cube's faces, edges and corners.
    #[inline(never)]
    pub(crate) fn worst_direction_error(&self, ellipsoid: &Ellipsoid) -> f32 {
        let shape = Shape::of(ellipsoid);
        // Entries 11 … 44 of the symmetric form, upper triangle row by row.
        let mut form = [0.0f32; 10];
        for k in &self.changes {
            let d = times(&shape.c, [k[0], k[1], k[2]]);
            let e = product_upper(&[k[3], k[4], k[5], k[6], k[7], k[8]], &shape.a);
            // The three rows of (E, −d) are as long as the triangle leaves them.
            add_square(&mut form, &[e[0], e[1], e[2], -d[0]]);
            add_square(&mut form[4..], &[e[3], e[4], -d[1]]);
            add_square(&mut form[7..], &[e[5], -d[2]]);
        }
        let [xx, xy, xz, x1, yy, yz, y1, zz, z1, constant] = form;
        let mut worst = 0.0f32;
        // One of each pair of opposite directions: the linear part makes the other.
        for [x, y, z] in DIRECTIONS {
            let square = x * (x * xx + 2.0 * (y * xy + z * xz)) + y * (y * yy + 2.0 * z * yz) + z * z * zz;
            let linear = x * x1 + y * y1 + z * z1;
            let total = square + 2.0 * linear.abs();
            // Written so that a NaN becomes the worst.
            if !(total <= worst) {
                worst = total;
            }
        }
        sqrtf(worst + constant)
    }
}

/// Adds the products of a row with itself to the upper triangle of a form, from the row's own diagonal on.
fn add_square(form: &mut [f32], row: &[f32]) {
    let mut slots = form.iter_mut();
    for (i, a) in row.iter().enumerate() {
        for (b, slot) in row.iter().skip(i).zip(&mut slots) {
            *slot += a * b;
        }
    }
}

/// Unit vectors to a cube's faces, edges and corners, one of each opposite pair.
const DIRECTIONS: [[f32; 3]; 13] = {
    const E: f32 = core::f32::consts::FRAC_1_SQRT_2;
    const C: f32 = 0.577_350_26;
    [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [E, E, 0.0],
        [E, -E, 0.0],
        [E, 0.0, E],
        [E, 0.0, -E],
        [0.0, E, E],
        [0.0, E, -E],
        [C, C, C],
        [C, C, -C],
        [C, -C, C],
        [-C, C, C],
    ]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangular_matrix_times_its_inverse_is_one() {
        let c = [0.5, 0.3, -0.25, 1.5, 0.2, 2.0];
        for product in [product_upper(&c, &inverse(&c)), product_upper(&inverse(&c), &c)] {
            for (value, one) in product.into_iter().zip([1.0, 0.0, 0.0, 1.0, 0.0, 1.0]) {
                assert!((value - one).abs() < 1e-6, "{product:?}");
            }
        }
    }

    #[test]
    fn the_weak_prior_leaves_a_fifth_of_the_gains_and_ten_degrees_of_the_axes() {
        // Nothing is known but the offset, about a sphere of gains of two.
        let sphere = Ellipsoid { centre: [0.0; 3], factor: [2.0, 0.0, 0.0, 2.0, 0.0, 2.0], s: 1.0 };
        let mut spread = Spread::ZERO;
        for (i, change) in spread.changes.iter_mut().enumerate() {
            change[i] = if i < 3 { 0.01 } else { 100.0 };
        }
        spread.add_prior(&sphere);
        let covariance = spread.covariance();
        let variance = |row: [f64; 6]| -> f64 {
            (0..6).map(|i| (0..6).map(|j| row[i] * covariance[3 + i][3 + j] * row[j]).sum::<f64>()).sum()
        };
        let half = core::f64::consts::FRAC_1_SQRT_2;
        // Two gains against each other, in units of the mean gain; then an axis that leans towards another.
        let gains = crate::math::sqrt(variance([half, 0.0, 0.0, -half, 0.0, 0.0])) / 2.0;
        assert!((gains - 0.2).abs() < 0.01, "{gains}");
        for off_diagonal in [1, 2, 4] {
            let mut row = [0.0; 6];
            row[off_diagonal] = 1.0;
            let lean = crate::math::sqrt(variance(row)) / 2.0;
            assert!((lean - 0.17).abs() < 0.01, "{lean}");
        }
        // The common scale stays open, and the offset is as it was.
        assert!(variance([1.0, 0.0, 0.0, 1.0, 0.0, 1.0]) > 50.0 * 50.0);
        assert!((spread.std_errors()[0] - 0.01).abs() < 1e-6);
    }
}
