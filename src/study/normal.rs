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

    /// This matrix without the rows of one of its blocks.
    pub fn without(&self, block: &Self) -> Self {
        let mut rest = self.clone();
        rest.combine(block, -T::one());
        rest.rows = self.rows.saturating_sub(block.rows);
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
        out.squares = self.squares_after(delta);
        for i in 0..self.columns.min(P) {
            let mut line = T::zero();
            for (j, other) in delta.iter().enumerate().take(self.columns) {
                line += self.entry(i, j) * *other;
            }
            out.pull(i, line);
        }
        out
    }

    /// Value of `‖r + Jδ‖²`.
    pub fn squares_after(&self, delta: &[T; P]) -> T {
        let mut sum = self.squares;
        for i in 0..self.columns {
            let d = delta.get(i).copied().unwrap_or(T::zero());
            let mut line = T::zero();
            for (j, other) in delta.iter().enumerate().take(self.columns) {
                line += self.entry(i, j) * *other;
            }
            sum += d * (line + self.right(i) + self.right(i));
        }
        sum
    }

    /// Cholesky factor of the matrix with unit columns. `None` where it is not positive definite to working precision.
    pub fn factor(&self) -> Option<Factor<T, P>> {
        self.damped_factor(T::zero())
    }

    /// The same with `damping` added to the unit diagonal (Marquardt's step).
    pub fn damped_factor(&self, damping: T) -> Option<Factor<T, P>> {
        let n = self.columns;
        let mut scale = [T::zero(); P];
        for (i, s) in scale.iter_mut().enumerate().take(n) {
            let diagonal = self.entry(i, i);
            if !diagonal.is_finite() || diagonal <= T::zero() {
                return None;
            }
            *s = T::one() / diagonal.root();
        }
        let floor = T::epsilon() * T::of(16.0);
        let mut lower = [[T::zero(); P]; P];
        for i in 0..n {
            for j in 0..=i {
                let mut sum = self.entry(i, j) * scale.get(i).copied()? * scale.get(j).copied()?;
                if i == j {
                    sum += damping;
                }
                let (row_i, row_j) = (lower.get(i)?, lower.get(j)?);
                for (a, b) in row_i.iter().zip(row_j).take(j) {
                    sum -= *a * *b;
                }
                let value = if i == j {
                    if !sum.is_finite() || sum <= floor {
                        return None;
                    }
                    sum.root()
                } else {
                    sum / *lower.get(j)?.get(j)?
                };
                *lower.get_mut(i)?.get_mut(j)? = value;
            }
        }
        Some(Factor { n, lower, scale })
    }

    /// The step `δ = −N⁻¹g` with a factor of this matrix.
    pub fn step(&self, factor: &Factor<T, P>) -> [T; P] {
        factor.solve(&self.right).map(|value| -value)
    }
}

/// `L` with `L Lᵀ = S N S`, `S` the scale to unit columns.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Factor<T, const P: usize> {
    pub(super) n: usize,
    pub(super) lower: [[T; P]; P],
    pub(super) scale: [T; P],
}

impl<T: Real, const P: usize> Factor<T, P> {
    /// `L⁻¹ S b`.
    pub(super) fn forward(&self, b: &[T; P]) -> [T; P] {
        let mut y = [T::zero(); P];
        for i in 0..self.n {
            let (Some(row), Some(s), Some(value)) = (self.lower.get(i), self.scale.get(i), b.get(i)) else {
                break;
            };
            let mut sum = *value * *s;
            for (l, known) in row.iter().zip(&y).take(i) {
                sum -= *l * *known;
            }
            if let (Some(out), Some(pivot)) = (y.get_mut(i), row.get(i)) {
                *out = sum / *pivot;
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
