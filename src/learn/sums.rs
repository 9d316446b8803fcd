//! A normal matrix in single precision, packed: what a board can keep several of.

/// `JᵀJ` (its lower triangle, row after row), `Jᵀr`, `rᵀr` and the number of rows, of `P` columns; `E` is `P (P + 1) / 2`.
///
/// Row after row of the lower triangle, so that more columns stand behind what there is.
#[derive(Clone, Debug)]
pub(super) struct Sums<const P: usize, const E: usize> {
    pub(super) entries: [f32; E],
    pub(super) right: [f32; P],
    pub(super) squares: f32,
    pub(super) rows: u32,
}

/// The columns of the widest normal matrix that is solved: base, streamed effects, and a step.
pub(super) const WIDEST: usize = 24;
/// Entries of its triangle.
pub(super) const WIDEST_ENTRIES: usize = WIDEST * (WIDEST + 1) / 2;
/// Where the sums of a study come together to be solved.
pub(super) type Work = Sums<WIDEST, WIDEST_ENTRIES>;

/// Place of an entry.
pub(super) const fn at(i: usize, j: usize) -> usize {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    high * (high + 1) / 2 + low
}

/// Adds `row` times itself and times `residual`: one text for every number of columns.
///
/// Most of the study's instructions are here. Slices that are taken apart instead of iterators: whatever the compiler is told to
/// save, these are no calls.
fn add_row(entries: &mut [f32], right: &mut [f32], row: &[f32], residual: f32) {
    let (mut entries, mut right, mut values, mut length) = (entries, right, row, 1);
    while let ([slot, later @ ..], [value, others @ ..]) = (right, values) {
        *slot += value * residual;
        let Some((line, next)) = entries.split_at_mut_checked(length) else { return };
        let Some((mut fours, mut ones)) = line.split_at_mut_checked(length & !3) else { return };
        let mut from = row;
        while let ([a, b, c, d, more @ ..], [p, q, r, s, rest @ ..]) = (fours, from) {
            *a += value * p;
            *b += value * q;
            *c += value * r;
            *d += value * s;
            (fours, from) = (more, rest);
        }
        while let ([a, more @ ..], [p, rest @ ..]) = (ones, from) {
            *a += value * p;
            (ones, from) = (more, rest);
        }
        (entries, right, values, length) = (next, later, others, length + 1);
    }
}

impl<const P: usize, const E: usize> Sums<P, E> {
    pub(super) const fn new() -> Self {
        const { assert!(E == P * (P + 1) / 2, "entries of the triangle") };
        Self { entries: [0.0; E], right: [0.0; P], squares: 0.0, rows: 0 }
    }

    /// Forgets everything, in place.
    pub(super) fn clear(&mut self) {
        self.entries.fill(0.0);
        self.right.fill(0.0);
        (self.squares, self.rows) = (0.0, 0);
    }

    /// Adds one row of the first columns, all others zero.
    #[inline]
    pub(super) fn push(&mut self, row: &[f32], residual: f32) {
        add_row(&mut self.entries, &mut self.right, row, residual);
        self.squares += residual * residual;
        self.rows = self.rows.saturating_add(1);
    }

    pub(super) fn entry(&self, i: usize, j: usize) -> f32 {
        self.entries.get(at(i, j)).copied().unwrap_or(0.0)
    }

    pub(super) fn right(&self, i: usize) -> f32 {
        self.right.get(i).copied().unwrap_or(0.0)
    }

    /// Adds `sign` times the sums of the same first columns.
    fn combine<const Q: usize, const F: usize>(&mut self, other: &Sums<Q, F>, sign: f32) {
        for (entry, value) in self.entries.iter_mut().zip(&other.entries) {
            *entry += sign * value;
        }
        for (entry, value) in self.right.iter_mut().zip(&other.right) {
            *entry += sign * value;
        }
        self.squares += sign * other.squares;
    }

    /// Adds the rows of other sums, of as many columns at most.
    pub(super) fn merge<const Q: usize, const F: usize>(&mut self, other: &Sums<Q, F>) {
        self.combine(other, 1.0);
        self.rows = self.rows.saturating_add(other.rows);
    }

    /// Takes rows out again.
    pub(super) fn take_out<const Q: usize, const F: usize>(&mut self, other: &Sums<Q, F>) {
        self.combine(other, -1.0);
        self.rows = self.rows.saturating_sub(other.rows);
    }

    /// Lets every row count half.
    pub(super) fn halve(&mut self) {
        let all = self.entries.iter_mut().chain(&mut self.right).chain([&mut self.squares]);
        all.for_each(|sum| *sum *= 0.5);
        self.rows /= 2;
    }

    /// The same rows with `times` the column `from` taken off another one.
    pub(super) fn take_off_column(&mut self, column: usize, from: usize, times: f32) {
        let own = self.entry(column, column)
            + times * (times * self.entry(from, from) - 2.0 * self.entry(from, column));
        for other in 0..P {
            let value = if other == column {
                own
            } else {
                self.entry(column, other) - times * self.entry(from, other)
            };
            if let Some(entry) = self.entries.get_mut(at(column, other)) {
                *entry = value;
            }
        }
        let right = times * self.right(from);
        if let Some(value) = self.right.get_mut(column) {
            *value -= right;
        }
    }

    /// `Σ_j N_ij δ_j`.
    fn along(&self, i: usize, delta: &[f32; P]) -> f32 {
        let mut sum = 0.0;
        for (j, value) in delta.iter().enumerate() {
            if *value != 0.0 {
                sum += self.entry(i, j) * value;
            }
        }
        sum
    }

    /// `‖r + Jδ‖²`.
    pub(super) fn squares_after(&self, delta: &[f32; P]) -> f32 {
        let mut sum = self.squares;
        for (i, value) in delta.iter().enumerate() {
            if *value != 0.0 {
                sum += value * (self.along(i, delta) + 2.0 * self.right(i));
            }
        }
        sum
    }

    /// The same rows about another point: `r + Jδ` in place of `r`.
    pub(super) fn shift(&mut self, delta: &[f32; P]) {
        self.squares = self.squares_after(delta);
        for i in 0..P {
            let line = self.along(i, delta);
            if let Some(right) = self.right.get_mut(i) {
                *right += line;
            }
        }
    }
}
