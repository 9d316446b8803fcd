//! One least squares of the ellipse, from the sums.

use super::plane::{Affine, Plane};
use crate::dense::root;
use crate::monomial::COUNT;
use crate::quadric::{corrected, product as mean_product};

/// Columns of the least squares: two of the soft iron, two of the offset, the constant, the vertical field.
pub(super) const COLUMNS: usize = 6;
pub(super) const VERTICAL: usize = 5;
/// A polynomial in the scatter's coordinates, over the monomials of a quadric.
type Polynomial = [f64; 10];

/// The product of two affine functions, over xx yy zz xy xz yz x y z 1.
fn multiplied(a: &Affine, b: &Affine, factor: f64) -> Polynomial {
    let [ax, ay, az, a1] = a.map(|value| factor * value);
    let [bx, by, bz, b1] = *b;
    [
        ax * bx,
        ay * by,
        az * bz,
        ax * by + ay * bx,
        ax * bz + az * bx,
        ay * bz + az * by,
        ax * b1 + a1 * bx,
        ay * b1 + a1 * by,
        az * b1 + a1 * bz,
        a1 * b1,
    ]
}

fn linear(a: &Affine, factor: f64) -> Polynomial {
    multiplied(a, &[0.0, 0.0, 0.0, 1.0], factor)
}

fn sum(a: Polynomial, b: Polynomial) -> Polynomial {
    core::array::from_fn(|i| a.get(i).unwrap_or(&0.0) + b.get(i).unwrap_or(&0.0))
}

/// Mean of the product of two polynomials.
fn mean_of(moments: &[f64; COUNT], a: &Polynomial, b: &Polynomial) -> f64 {
    let mut mean = 0.0;
    for (r, a) in a.iter().enumerate() {
        for (c, b) in b.iter().enumerate() {
            if *a != 0.0 && *b != 0.0 {
                mean += a * b * mean_product(moments, r, c);
            }
        }
    }
    mean
}

/// The ellipse under way.
pub(super) struct Ellipse {
    /// The corrected horizontal readings.
    pub(super) w: [Affine; 2],
    /// `w = M p − c` of the plane's own readings `p`.
    pub(super) matrix: [[f64; 2]; 2],
    pub(super) centre: [f64; 2],
    /// Vertical field, µT.
    pub(super) vertical_ut: f64,
    /// Horizontal field squared, µT².
    pub(super) horizontal_ut2: f64,
    /// Variance of the residual of the square, µT⁴.
    pub(super) variance: f64,
    /// The inverse of the normal matrix of means.
    pub(super) inverse: [[f64; COLUMNS]; COLUMNS],
}

impl Ellipse {
    /// One least squares, and its changes applied. `held` is the prior information on the vertical field, over that of one sample.
    pub(super) fn improved(
        &mut self,
        plane: &Plane,
        measured: &[f64; COUNT],
        noise: f32,
        held: f64,
    ) -> Option<()> {
        // Noise along the vertical would count as tilt.
        let moments = &corrected(measured, noise);
        let [w1, w2] = &self.w;
        let [_, _, s] = &plane.readings;
        let (squares, level) = (multiplied(w1, w1, 1.0), multiplied(w2, w2, 1.0));
        let difference = sum(squares, level.map(|value| -value)).map(|value| -2.0 * value);
        let observed =
            sum(sum(squares, level), sum(multiplied(s, s, 1.0), linear(s, 2.0 * self.vertical_ut)));
        let mut one = [0.0; 10];
        one[9] = 1.0;
        let columns = [
            difference,
            multiplied(w1, w2, -4.0),
            linear(w1, 2.0),
            linear(w2, 2.0),
            one,
            linear(s, -2.0),
            observed,
        ];
        let mut gram: [[f64; COLUMNS + 1]; COLUMNS + 1] =
            columns.map(|a| columns.map(|b| mean_of(moments, &a, &b)));
        gram[VERTICAL][VERTICAL] += held;
        swept(&mut gram)?;
        let change: [f64; COLUMNS] = core::array::from_fn(|i| gram[i][COLUMNS]);
        self.inverse = core::array::from_fn(|r| core::array::from_fn(|c| -gram[r][c]));
        let residual = columns
            .iter()
            .zip(change)
            .fold(observed, |residual, (column, change)| sum(residual, column.map(|value| -change * value)));
        self.variance = mean_of(measured, &residual, &residual).max(0.0);
        let [p, q, d1, d2, constant, vertical] = change;
        // Of determinant one: the common gain is the prior's.
        let determinant = 1.0 - p * p - q * q;
        if !(determinant > 0.1) {
            return None;
        }
        let per = 1.0 / root(determinant);
        let turn = [[(1.0 + p) * per, q * per], [q * per, (1.0 - p) * per]];
        let shift = [d1 * per, d2 * per];
        let ([a, b], [m, n]) = (self.w, self.matrix);
        let [ca, cb] = self.centre;
        for row in 0..2 {
            let [x, y] = turn[row];
            self.w[row] = core::array::from_fn(|i| x * a[i] + y * b[i]);
            self.w[row][3] -= shift[row];
            self.matrix[row] = [x * m[0] + y * n[0], x * m[1] + y * n[1]];
            self.centre[row] = x * ca + y * cb + shift[row];
        }
        self.vertical_ut += vertical;
        self.horizontal_ut2 = constant;
        Some(())
    }
}

/// Sweeps all columns but the last of a symmetric matrix: the solution comes into the last column and the negative inverse into
/// the rest. `None` unless the matrix is positive definite.
fn swept(gram: &mut [[f64; COLUMNS + 1]; COLUMNS + 1]) -> Option<()> {
    for k in 0..COLUMNS {
        let own = gram[k];
        let pivot = own[k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        for (r, row) in gram.iter_mut().enumerate() {
            let factor = row[k] / pivot;
            for (c, value) in row.iter_mut().enumerate() {
                if r != k && c != k {
                    *value -= factor * own[c];
                }
            }
            row[k] = if r == k { -1.0 / pivot } else { factor };
        }
        for (c, value) in gram[k].iter_mut().enumerate() {
            if c != k {
                *value = own[c] / pivot;
            }
        }
    }
    Some(())
}
