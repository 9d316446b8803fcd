//! What a candidate adds beyond the columns before it.

use super::normal::Normal;
use crate::effect::MAX_COEFFICIENTS;
use crate::math::Real;
use core::ops::Range;

/// Directions of a candidate whose Schur complement (unit columns) has a smaller eigenvalue are not new.
pub const MIN_EIGENVALUE: f64 = 1e-3;

/// Rows first.
type Small<T> = [[T; MAX_COEFFICIENTS]; MAX_COEFFICIENTS];
type SmallVector<T> = [T; MAX_COEFFICIENTS];

/// How much a candidate lowers the squared error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Improvement<T> {
    /// Squared error with the base alone, refitted.
    pub squares_before: T,
    /// What the candidate takes off it.
    pub decrease: T,
    /// Its directions that are new to the base.
    pub directions: usize,
}

impl<T: Real> Improvement<T> {
    /// `F*` and its degrees of freedom: `(F, k, n_eff − p − k)` for `p` base columns, `rows` rows and
    /// `rows_effective` independent ones.
    pub fn f_statistic(&self, base: usize, rows: f64, rows_effective: f64) -> (f64, f64, f64) {
        let k = self.directions as f64;
        // Rounding may leave nothing, or less: a perfect candidate is no impossible one.
        let after = (self.squares_before - self.decrease).as_f64().max(f64::MIN_POSITIVE);
        let freedom = rows - base as f64 - k;
        let f = (self.decrease.as_f64() / k) / (after / freedom) * rows_effective / rows;
        (f, k, rows_effective - base as f64 - k)
    }
}

impl<T: Real, const P: usize> Normal<T, P> {
    /// Tests the columns `candidate` against those `base`. `None` where the base itself is not determined, or the
    /// candidate has more than [`MAX_COEFFICIENTS`] columns or is not finite.
    pub fn test(&self, base: Range<usize>, candidate: Range<usize>) -> Option<Improvement<T>> {
        let k = candidate.len();
        let (schur, right, squares_before) = self.schur(base, candidate)?;
        let (values, vectors) = T::symmetric_eigen(&schur)?;
        let mut improvement = Improvement { squares_before, decrease: T::zero(), directions: 0 };
        for (value, vector) in values.into_iter().zip(&vectors) {
            if value > T::of(MIN_EIGENVALUE) && improvement.directions < k {
                let along = T::inner_product(vector, &right);
                improvement.decrease += along * along / value;
                improvement.directions += 1;
            }
        }
        Some(improvement)
    }

    /// Schur complement of the candidate's unit columns, their right side, and the squared error of the base.
    fn schur(&self, base: Range<usize>, candidate: Range<usize>) -> Option<(Small<T>, SmallVector<T>, T)> {
        let k = candidate.len();
        if k > MAX_COEFFICIENTS || candidate.end > self.columns {
            return None;
        }
        let p = base.len();
        let part = self.select_range(base.clone());
        let factor = part.factor()?;
        let known = factor.forward(&part.right);
        let mut squares = self.squares();
        for value in known.iter().take(p) {
            squares -= *value * *value;
        }
        let mut through = [[T::zero(); P]; MAX_COEFFICIENTS];
        let mut scale = [T::zero(); MAX_COEFFICIENTS];
        for ((out, s), column) in through.iter_mut().zip(&mut scale).zip(candidate.clone()) {
            let norm = self.entry(column, column);
            // A column of zeros is no direction: its row stays zero and is dropped with the small eigenvalues.
            if norm > T::zero() {
                *s = T::one() / norm.root();
            }
            let mut cross = [T::zero(); P];
            for (entry, from) in cross.iter_mut().zip(base.clone()) {
                *entry = self.entry(from, column);
            }
            *out = factor.forward(&cross);
        }
        let dot = |a: &[T; P], b: &[T; P]| {
            let mut sum = T::zero();
            for (x, y) in a.iter().zip(b).take(p) {
                sum += *x * *y;
            }
            sum
        };
        let mut schur: Small<T> = [[T::zero(); MAX_COEFFICIENTS]; MAX_COEFFICIENTS];
        let mut right: SmallVector<T> = [T::zero(); MAX_COEFFICIENTS];
        for (i, ((row, s), column)) in through.iter().zip(&scale).zip(candidate.clone()).enumerate() {
            let value = (self.right(column) - dot(row, &known)) * *s;
            if let Some(entry) = right.get_mut(i) {
                *entry = value;
            }
            for (j, ((other, t), second)) in through.iter().zip(&scale).zip(candidate.clone()).enumerate() {
                if let Some(entry) = schur.get_mut(i).and_then(|row| row.get_mut(j)) {
                    *entry = (self.entry(column, second) - dot(row, other)) * *s * *t;
                }
            }
        }
        let finite =
            schur.iter().flatten().chain(&right).all(|value| value.is_finite()) && squares.is_finite();
        finite.then_some((schur, right, squares))
    }

    fn select_range(&self, range: Range<usize>) -> Self {
        let mut keep = [0; P];
        let n = range.len().min(P);
        for (slot, column) in keep.iter_mut().zip(range) {
            *slot = column;
        }
        self.select(keep.get(..n).unwrap_or(&[]))
    }

    /// Canonical correlations between the columns `first` and `second` once `base` is projected out of both, in no
    /// particular order; as many as the smaller of the two has new directions, zero elsewhere. One of 1 means that
    /// some combination of the first is also one of the second.
    pub fn canonical_correlations(
        &self,
        base: Range<usize>,
        first: Range<usize>,
        second: Range<usize>,
    ) -> Option<[T; MAX_COEFFICIENTS]> {
        let (a, _, _) = self.schur(base.clone(), first.clone())?;
        let (b, _, _) = self.schur(base.clone(), second.clone())?;
        // The cross block: both candidates as one would be too wide, so it is built like the others, entry by entry.
        let cross = self.schur_cross(base, first, second)?;
        let (white_a, white_b) = (inverse_root(&a)?, inverse_root(&b)?);
        let coupling = product(&product(&white_a, &cross), &white_b);
        let (values, _) = T::symmetric_eigen(&product(&transposed(&coupling), &coupling))?;
        let mut out = [T::zero(); MAX_COEFFICIENTS];
        for (slot, value) in out.iter_mut().zip(values) {
            *slot = value.max(T::zero()).min(T::one()).root();
        }
        Some(out)
    }

    fn schur_cross(&self, base: Range<usize>, first: Range<usize>, second: Range<usize>) -> Option<Small<T>> {
        let part = self.select_range(base.clone());
        let factor = part.factor()?;
        let project = |column: usize| {
            let mut cross = [T::zero(); P];
            for (entry, from) in cross.iter_mut().zip(base.clone()) {
                *entry = self.entry(from, column);
            }
            factor.forward(&cross)
        };
        let unit = |column: usize| {
            let norm = self.entry(column, column);
            if norm > T::zero() { T::one() / norm.root() } else { T::zero() }
        };
        let mut out: Small<T> = [[T::zero(); MAX_COEFFICIENTS]; MAX_COEFFICIENTS];
        for (i, row) in first.enumerate() {
            let left = project(row);
            for (j, column) in second.clone().enumerate() {
                let mut value = self.entry(row, column);
                for (x, y) in left.iter().zip(&project(column)).take(base.len()) {
                    value -= *x * *y;
                }
                *out.get_mut(i)?.get_mut(j)? = value * unit(row) * unit(column);
            }
        }
        Some(out)
    }
}

/// `Mᵀ`.
fn transposed<T: Real>(m: &Small<T>) -> Small<T> {
    core::array::from_fn(|i| core::array::from_fn(|j| m[j][i]))
}

/// `A B`.
fn product<T: Real>(a: &Small<T>, b: &Small<T>) -> Small<T> {
    a.map(|row| {
        let mut out = [T::zero(); MAX_COEFFICIENTS];
        for (weight, line) in row.into_iter().zip(b) {
            for (entry, value) in out.iter_mut().zip(line) {
                *entry += weight * *value;
            }
        }
        out
    })
}

/// `M^(−1/2)` on the directions above the eigenvalue limit, zero on the rest.
fn inverse_root<T: Real>(matrix: &Small<T>) -> Option<Small<T>> {
    let (values, vectors) = T::symmetric_eigen(matrix)?;
    let mut out: Small<T> = [[T::zero(); MAX_COEFFICIENTS]; MAX_COEFFICIENTS];
    for (value, vector) in values.into_iter().zip(&vectors) {
        if value > T::of(MIN_EIGENVALUE) {
            let weight = T::one() / value.root();
            for (row, a) in out.iter_mut().zip(vector) {
                for (entry, b) in row.iter_mut().zip(vector) {
                    *entry += *a * *b * weight;
                }
            }
        }
    }
    Some(out)
}
