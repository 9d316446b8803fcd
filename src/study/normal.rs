//! The normal matrix of one block of rows, and its Cholesky factor.

use crate::math::Real;

/// `JᵀJ`, `Jᵀr`, `rᵀr` and the number of rows, for up to `P` columns of which `columns` are used.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Normal<T, const P: usize> {
    pub(super) columns: usize,
    /// Upper triangle.
    pub(super) matrix: [[T; P]; P],
    pub(super) right: [T; P],
    pub(super) squares: T,
    rows: u32,
}

impl<const P: usize> Normal<f32, P> {
    /// An empty matrix of all columns, as a constant.
    pub(crate) const EMPTY: Self =
        Normal { columns: P, matrix: [[0.0; P]; P], right: [0.0; P], squares: 0.0, rows: 0 };
}

impl<T: Real, const P: usize> Normal<T, P> {
    /// An empty matrix of `columns` columns, at most `P`.
    pub fn new(columns: usize) -> Self {
        Normal {
            columns: columns.min(P),
            matrix: [[T::zero(); P]; P],
            right: [T::zero(); P],
            squares: T::zero(),
            rows: 0,
        }
    }

    /// Columns in use.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows pushed.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// `rᵀr`.
    pub fn squares(&self) -> T {
        self.squares
    }

    /// An entry of `JᵀJ`; zero outside.
    pub fn entry(&self, i: usize, j: usize) -> T {
        self.matrix.get(i.min(j)).and_then(|row| row.get(i.max(j))).copied().unwrap_or(T::zero())
    }

    /// An entry of `Jᵀr`; zero outside.
    pub fn right(&self, i: usize) -> T {
        self.right.get(i).copied().unwrap_or(T::zero())
    }

    /// Adds one row `J` with its residual.
    #[inline]
    pub fn push(&mut self, row: &[T; P], residual: T) {
        // Slices of one length and no bounds inside: the inner loop becomes vector code.
        let n = self.columns.min(P);
        let Some(row) = row.get(..n) else { return };
        for (i, ((line, right), &value)) in self.matrix.iter_mut().zip(&mut self.right).zip(row).enumerate() {
            *right += value * residual;
            let (Some(line), Some(others)) = (line.get_mut(i..n), row.get(i..)) else { return };
            for (entry, &other) in line.iter_mut().zip(others) {
                *entry += value * other;
            }
        }
        self.squares += residual * residual;
        self.rows = self.rows.saturating_add(1);
    }

    /// Puts a sum of products in the place of an entry of `JᵀJ`, ...
    pub(crate) fn set(&mut self, i: usize, j: usize, value: T) {
        if let Some(entry) = self.matrix.get_mut(i.min(j)).and_then(|row| row.get_mut(i.max(j))) {
            *entry = value;
        }
    }

    /// ... and of `Jᵀr`.
    pub(crate) fn set_right(&mut self, i: usize, value: T) {
        if let Some(entry) = self.right.get_mut(i) {
            *entry = value;
        }
    }

    /// Adds information without data: `weight` at `(i, j)` and `(j, i)`.
    pub fn inform(&mut self, i: usize, j: usize, weight: T) {
        if let Some(entry) = self.matrix.get_mut(i.min(j)).and_then(|row| row.get_mut(i.max(j))) {
            *entry += weight;
        }
    }

    /// Adds to `Jᵀr` without data.
    pub fn pull(&mut self, i: usize, value: T) {
        if let Some(entry) = self.right.get_mut(i) {
            *entry += value;
        }
    }

    /// Adds to `rᵀr` without data: what a model departs from what is known.
    pub fn depart(&mut self, squares: T) {
        self.squares += squares;
    }

    /// Counts rows whose products were added by [`Normal::inform`] and its like.
    pub(crate) fn count(&mut self, rows: u32) {
        self.rows = self.rows.saturating_add(rows);
    }

    /// Forgets everything, in place.
    pub(crate) fn clear(&mut self) {
        self.scale(T::zero());
        self.rows = 0;
    }

    /// Lets every row count half.
    pub(crate) fn halve(&mut self) {
        self.scale(T::of(0.5));
        self.rows /= 2;
    }

    fn scale(&mut self, times: T) {
        let sums =
            self.matrix.as_flattened_mut().iter_mut().chain(&mut self.right).chain([&mut self.squares]);
        sums.for_each(|sum| *sum *= times);
    }

    /// Adds `sign` times another matrix; `sign` −1 takes a block out again.
    fn combine(&mut self, other: &Self, sign: T) {
        let n = other.columns;
        for (i, (line, from)) in self.matrix.iter_mut().zip(&other.matrix).take(n).enumerate() {
            for (entry, value) in line.iter_mut().zip(from).take(n).skip(i) {
                *entry += sign * *value;
            }
        }
        for (entry, value) in self.right.iter_mut().zip(&other.right).take(n) {
            *entry += sign * *value;
        }
        self.squares += sign * other.squares;
        self.columns = self.columns.max(other.columns);
    }

    /// Adds the rows of another block.
    pub fn merge(&mut self, other: &Self) {
        self.combine(other, T::one());
        self.rows = self.rows.saturating_add(other.rows);
    }

    /// Takes the rows of one of its blocks out again.
    pub(crate) fn take_out(&mut self, block: &Self) {
        self.combine(block, -T::one());
        self.rows = self.rows.saturating_sub(block.rows);
    }

    /// This matrix without the rows of one of its blocks.
    pub fn without(&self, block: &Self) -> Self {
        let mut rest = self.clone();
        rest.take_out(block);
        rest
    }

    /// The sum of blocks and a prior.
    pub fn total(blocks: &[Self], prior: Option<&Self>) -> Self {
        let mut sum = Self::new(0);
        for block in blocks.iter().chain(prior) {
            sum.merge(block);
        }
        sum
    }

    /// The same data with only the columns `keep`, in that order.
    pub fn select(&self, keep: &[usize]) -> Self {
        let mut out = Self::new(keep.len());
        for (i, &from) in keep.iter().enumerate().take(P) {
            if let Some(entry) = out.right.get_mut(i) {
                *entry = self.right(from);
            }
            for (j, &to) in keep.iter().enumerate().take(P).skip(i) {
                if let Some(entry) = out.matrix.get_mut(i).and_then(|row| row.get_mut(j)) {
                    *entry = self.entry(from, to);
                }
            }
        }
        out.squares = self.squares;
        out.rows = self.rows;
        out
    }

    /// The same data about another point of the linearised model: `r + Jδ` in place of `r`.
    pub fn moved(&self, delta: &[T; P]) -> Self {
        let mut out = self.clone();
        out.shift(delta);
        out
    }

    /// [`Normal::moved`] in place.
    pub(crate) fn shift(&mut self, delta: &[T; P]) {
        if delta.iter().all(|value| *value == T::zero()) {
            return;
        }
        self.squares = self.squares_after(delta);
        for i in 0..self.columns.min(P) {
            let line = self.along(i, delta);
            self.pull(i, line);
        }
    }

    /// `Σ_j N_ij δ_j`.
    fn along(&self, i: usize, delta: &[T; P]) -> T {
        let mut line = T::zero();
        // Column i above the diagonal, then row i.
        for (row, other) in self.matrix.iter().zip(delta).take(i) {
            line += row.get(i).copied().unwrap_or(T::zero()) * *other;
        }
        let row = self.matrix.get(i).map_or(&[][..], |row| row);
        for (entry, other) in row.iter().zip(delta).take(self.columns).skip(i) {
            line += *entry * *other;
        }
        line
    }

    /// Value of `‖r + Jδ‖²`.
    pub fn squares_after(&self, delta: &[T; P]) -> T {
        let mut sum = self.squares;
        for (i, (d, right)) in delta.iter().zip(&self.right).enumerate().take(self.columns) {
            if *d != T::zero() {
                sum += *d * (self.along(i, delta) + *right + *right);
            }
        }
        sum
    }

    /// Cholesky factor of the matrix with unit columns. `None` where it is not positive definite to working precision.
    pub fn factor(&self) -> Option<Factor<T, P>> {
        self.damped_factor(T::zero())
    }

    /// The same with `damping` added to the unit diagonal (Marquardt's step).
    pub fn damped_factor(&self, damping: T) -> Option<Factor<T, P>> {
        let mut factor = Factor::new();
        factor.extend(self, self.columns, damping, &|_| Role::Required)?;
        Some(factor)
    }

    /// The step `δ = −N⁻¹g` with a factor of this matrix.
    pub fn step(&self, factor: &Factor<T, P>) -> [T; P] {
        factor.solve(&self.right).map(|value| -value)
    }
}

/// `value − Σ aᵢbᵢ`, over the shorter of the two.
fn less_products<T: Real>(mut value: T, a: &[T], b: &[T]) -> T {
    for (a, b) in a.iter().zip(b) {
        value -= *a * *b;
    }
    value
}

/// `L` with `L Lᵀ = S N S`, `S` the scale to unit columns.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Factor<T, const P: usize> {
    pub(super) n: usize,
    pub(super) lower: [[T; P]; P],
    pub(super) scale: [T; P],
}

/// Whether a column is part of a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role<T> {
    /// Without it there is no factor.
    Required,
    /// Left out if those before it leave less than this share of its square.
    Optional(T),
    /// Left out.
    Absent,
}

impl<T: Real, const P: usize> Factor<T, P> {
    /// The factor of no column.
    pub(crate) fn new() -> Self {
        Factor { n: 0, lower: [[T::zero(); P]; P], scale: [T::zero(); P] }
    }

    /// Adds the columns up to `n`; those before are of the same matrix. `None` where a required one is not determined.
    pub(crate) fn extend(
        &mut self,
        normal: &Normal<T, P>,
        n: usize,
        damping: T,
        role: &dyn Fn(usize) -> Role<T>,
    ) -> Option<()> {
        for i in self.n..n {
            let (role, diagonal) = (role(i), normal.entry(i, i));
            let least = match role {
                Role::Required => T::epsilon() * T::of(16.0),
                Role::Optional(least) => least,
                Role::Absent => T::one(),
            };
            let is_usable = role != Role::Absent && diagonal.is_finite() && diagonal > T::zero();
            let scale = if is_usable { T::one() / diagonal.root() } else { T::zero() };
            let (before, rest) = self.lower.split_at_mut_checked(i)?;
            let row = rest.first_mut()?;
            *row = [T::zero(); P];
            let mut left = T::zero();
            if is_usable {
                let columns = normal.matrix.iter().zip(&self.scale).zip(&*before).enumerate();
                for (j, ((column, scale_j), row_j)) in columns {
                    // What is left out has a row of zeros.
                    if *scale_j == T::zero() {
                        continue;
                    }
                    let (known, slot) = row.split_at_mut_checked(j)?;
                    let product = *column.get(i)? * scale * *scale_j;
                    *slot.first_mut()? = less_products(product, known, row_j) / *row_j.get(j)?;
                }
                let known = row.get(..i)?;
                left = less_products(diagonal * scale * scale + damping, known, known);
            }
            let is_new = left.is_finite() && left > least;
            if !is_new {
                if role == Role::Required {
                    return None;
                }
                *row = [T::zero(); P];
                left = T::one();
            }
            *row.get_mut(i)? = left.root();
            *self.scale.get_mut(i)? = if is_new { scale } else { T::zero() };
        }
        self.n = n;
        Some(())
    }

    /// Leaves the columns from `n` on out again.
    pub(crate) fn shorten(&mut self, n: usize) {
        self.n = self.n.min(n);
    }

    /// Columns that are not left out.
    pub(crate) fn directions(&self) -> usize {
        self.scale.iter().take(self.n).filter(|scale| **scale > T::zero()).count()
    }

    /// What those before it leave of a column's square; zero of one that is left out.
    pub(crate) fn own_square(&self, column: usize) -> T {
        let scale = self.scale.get(column).copied().unwrap_or(T::zero());
        let pivot = self.lower.get(column).and_then(|row| row.get(column)).copied().unwrap_or(T::zero());
        if scale > T::zero() { pivot * pivot / (scale * scale) } else { T::zero() }
    }

    /// `rᵀr` after the step.
    pub(crate) fn squares(&self, normal: &Normal<T, P>) -> T {
        let mut squares = normal.squares;
        for value in self.forward(&normal.right) {
            squares -= value * value;
        }
        squares.max(T::zero())
    }

    /// Diagonal entry `j` of `N⁻¹`.
    pub(crate) fn inverse_diagonal(&self, j: usize) -> T {
        if self.scale.get(j).is_none_or(|scale| *scale == T::zero()) {
            return T::zero();
        }
        let mut unit = [T::zero(); P];
        if let Some(entry) = unit.get_mut(j) {
            *entry = T::one();
        }
        let mut sum = T::zero();
        for value in self.forward(&unit) {
            sum += value * value;
        }
        sum
    }

    /// The largest standard error among the first columns, for noise as large as what the step leaves.
    pub(crate) fn largest_error(&self, normal: &Normal<T, P>, first: usize) -> T {
        let freedom = (f64::from(normal.rows) - self.directions() as f64).max(1.0);
        let largest = (0..first).map(|column| self.inverse_diagonal(column)).fold(T::zero(), T::max);
        (self.squares(normal) / T::of(freedom) * largest).root()
    }

    /// `L⁻¹ S b`.
    pub(super) fn forward(&self, b: &[T; P]) -> [T; P] {
        let mut y = [T::zero(); P];
        let rows = self.lower.iter().zip(&self.scale).zip(b);
        for (i, ((row, s), value)) in rows.enumerate().take(self.n) {
            let (known, slot) = y.split_at_mut(i.min(P));
            if let (Some(out), Some(pivot)) = (slot.first_mut(), row.get(i))
                && *s != T::zero()
            {
                *out = less_products(*value * *s, known, row) / *pivot;
            }
        }
        y
    }

    /// `N⁻¹ b`.
    pub fn solve(&self, b: &[T; P]) -> [T; P] {
        let mut y = self.forward(b);
        for i in (0..self.n).rev() {
            let mut sum = y.get(i).copied().unwrap_or(T::zero());
            for (row, known) in self.lower.iter().zip(&y).take(self.n).skip(i + 1) {
                sum -= row.get(i).copied().unwrap_or(T::zero()) * *known;
            }
            let pivot = self.lower.get(i).and_then(|row| row.get(i)).copied().unwrap_or(T::one());
            if let Some(out) = y.get_mut(i) {
                *out = sum / pivot;
            }
        }
        for (out, s) in y.iter_mut().zip(&self.scale) {
            *out *= *s;
        }
        y
    }

    /// Column `j` of `N⁻¹`.
    pub fn inverse_column(&self, j: usize) -> [T; P] {
        let mut unit = [T::zero(); P];
        if let Some(entry) = unit.get_mut(j) {
            *entry = T::one();
        }
        self.solve(&unit)
    }
}
