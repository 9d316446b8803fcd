//! Least squares of whitened rows: normal matrices, solutions, and what a further set of columns takes off.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Normal matrix, right side and squares of whitened rows `[columns | residual]`.
#[derive(Debug, Clone)]
pub struct Sums {
    /// `JᵀJ`.
    pub matrix: DMatrix<f64>,
    /// `Jᵀr`.
    pub right: DVector<f64>,
    /// `rᵀr`.
    pub squares: f64,
    /// Rows.
    pub rows: usize,
}

impl Sums {
    /// Of rows of `columns` entries and their residual behind them.
    pub fn of(rows: &[f64], columns: usize) -> Sums {
        let width = columns + 1;
        let mut sums = vec![0.0; width * width];
        for row in rows.chunks_exact(width) {
            for (i, &a) in row.iter().enumerate() {
                let line = &mut sums[i * width + i..(i + 1) * width];
                line.iter_mut().zip(&row[i..]).for_each(|(entry, b)| *entry += a * b);
            }
        }
        let entry = |i: usize, j: usize| sums[i.min(j) * width + i.max(j)];
        Sums {
            matrix: DMatrix::from_fn(columns, columns, entry),
            right: DVector::from_fn(columns, |i, _| entry(i, columns)),
            squares: entry(columns, columns),
            rows: rows.len() / width,
        }
    }

    /// Adds knowledge: `weight` per column at the distance `off` from what is expected.
    pub fn inform(&mut self, weight: &[f64], off: &[f64]) {
        for (i, (weight, off)) in weight.iter().zip(off).enumerate() {
            self.matrix[(i, i)] += weight;
            self.right[i] += weight * off;
            self.squares += weight * off * off;
        }
    }

    /// The factor of the normal matrix, columns scaled to one.
    pub fn factor(&self) -> Option<Factor> {
        Factor::of(&self.matrix)
    }
}

/// Cholesky factor with unit diagonal before factoring: µT and shares in one matrix keep their digits.
#[derive(Debug, Clone)]
pub struct Factor {
    scale: DVector<f64>,
    cholesky: Cholesky<f64, Dyn>,
}

impl Factor {
    /// Of a symmetric matrix; `None` where it is not positive.
    pub fn of(matrix: &DMatrix<f64>) -> Option<Factor> {
        Factor::damped(matrix, 1e-11)
    }

    /// With a share of the diagonal added: steps along directions that hardly anything shows become short (Levenberg–Marquardt).
    pub fn damped(matrix: &DMatrix<f64>, damping: f64) -> Option<Factor> {
        let scale = DVector::from_fn(matrix.nrows(), |i, _| 1.0 / matrix[(i, i)].max(1e-300).sqrt());
        let mut unit =
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scale[i] * scale[j]);
        for i in 0..unit.nrows() {
            unit[(i, i)] += damping;
        }
        Some(Factor { cholesky: unit.cholesky()?, scale })
    }

    /// Solves for one right side.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        self.cholesky.solve(&right.component_mul(&self.scale)).component_mul(&self.scale)
    }

    /// Solves for several.
    pub fn solve_all(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let scaled =
            |m: &DMatrix<f64>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * self.scale[i]);
        scaled(&self.cholesky.solve(&scaled(right)))
    }

    /// The inverse.
    pub fn inverse(&self) -> DMatrix<f64> {
        let n = self.scale.len();
        self.solve_all(&DMatrix::identity(n, n))
    }
}

/// Squares that `k` more columns take off, the model's own columns free: by a Cholesky with pivots, which leaves out directions
/// that the model has already. `matrix` is their Schur complement, `right` their right side, `own` their squares before. Gives also
/// how many directions were left.
pub fn taken_off(matrix: &DMatrix<f64>, right: &DVector<f64>, own: &DVector<f64>) -> (f64, usize) {
    let k = right.len();
    let (mut m, mut b) = (matrix.clone(), right.clone());
    let mut taken = 0.0;
    let mut used = vec![false; k];
    let mut rank = 0;
    for _ in 0..k {
        let left = (0..k).filter(|&i| !used[i]);
        let share = |i: usize| m[(i, i)] / own[i].max(1e-300);
        let Some(pivot) = left.max_by(|&i, &j| share(i).total_cmp(&share(j))) else { break };
        if share(pivot) < 1e-5 || m[(pivot, pivot)] <= 0.0 {
            break;
        }
        used[pivot] = true;
        rank += 1;
        let d = m[(pivot, pivot)];
        let c = b[pivot] / d;
        taken += b[pivot] * c;
        let line: Vec<f64> = (0..k).map(|j| m[(pivot, j)] / d).collect();
        for i in 0..k {
            if used[i] {
                continue;
            }
            let f = m[(i, pivot)];
            b[i] -= f * c;
            for j in 0..k {
                m[(i, j)] -= f * line[j];
            }
        }
    }
    (taken, rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns 1 and t over ten rows, and a residual 3 − 2t with the last row off by one.
    fn rows() -> Vec<f64> {
        (0..10)
            .flat_map(|t| [1.0, f64::from(t), 3.0 - 2.0 * f64::from(t) + f64::from(u8::from(t == 9))])
            .collect()
    }

    #[test]
    fn a_line_is_solved_and_information_pulls() {
        let mut sums = Sums::of(&rows(), 2);
        let delta = -sums.factor().unwrap().solve(&sums.right);
        // Least squares of the same line by hand: slope −2 + 4.5/82.5, intercept by the means.
        let slope = -2.0 + 4.5 / 82.5;
        assert!((delta[1] + slope).abs() < 1e-9, "{delta}");
        assert!((delta[0] + (3.1 - 2.0 * 4.5 - slope * 4.5)).abs() < 1e-9);
        sums.inform(&[1e12, 0.0], &[0.0, 0.0]);
        let held = -sums.factor().unwrap().solve(&sums.right);
        assert!(held[0].abs() < 1e-6, "{held}");
    }

    #[test]
    fn what_columns_take_off_is_what_a_fit_with_them_leaves_less() {
        let line: Vec<f64> = rows().chunks_exact(3).flat_map(|row| [row[0], row[1], row[2]]).collect();
        let whole = Sums::of(&line, 2);
        let one: Vec<f64> = line.chunks_exact(3).flat_map(|row| [row[0], row[2]]).collect();
        let base = Sums::of(&one, 1);
        let left = |sums: &Sums| sums.squares - sums.right.dot(&sums.factor().unwrap().solve(&sums.right));
        let cross = DMatrix::from_element(1, 2, whole.matrix[(0, 1)]);
        let n = whole.matrix[(0, 0)];
        // The same column twice: the second is left out.
        let own = DMatrix::from_element(2, 2, whole.matrix[(1, 1)]);
        let schur = &own - cross.transpose() * &cross / n;
        let right = DVector::from_element(2, whole.right[1] - whole.matrix[(0, 1)] * whole.right[0] / n);
        let (taken, rank) = taken_off(&schur, &right, &own.diagonal());
        assert_eq!(rank, 1);
        assert!((taken - (left(&base) - left(&whole))).abs() < 1e-8, "{taken}");
    }
}
