//! Whether a term is shown by many parts of a log, or by one.
//!
//! The likelihood supposes normal innovations. A cause that nobody logged jumps: then a term that happens to change at a jump explains
//! one enormous innovation, and the likelihood rises by hundreds. So each coefficient is estimated with one part of the log left out at a
//! time, from the same sums. The spread of those estimates (jackknife) is its error whatever the distribution of the noise.

use crate::evidence::design::BASE;
use crate::evidence::fit::Fit;
use crate::evidence::solve::{Factor, Sums};
use ironout::study::f_tail;
use nalgebra::{DMatrix, DVector};

/// Parts of a log: enough for an error of nine coefficients, each long enough for all orientations.
const PARTS: usize = 40;
/// Rows of a part, at least.
const FEWEST_ROWS: usize = 4;

/// p-value of each term's coefficients all being zero, by the spread over parts of the log.
pub fn p_values(fit: &Fit) -> Vec<f64> {
    let columns = fit.model.columns();
    let mut whitened = fit.rows.clone();
    fit.noise.whiten(&fit.track, columns + 1, &mut whitened);
    let changes = changes(&whitened, columns, &fit.sums.matrix);
    let mut at = BASE;
    let mut out = Vec::new();
    for term in &fit.model.terms {
        let theta = DVector::from_fn(term.k(), |i, _| term.coefficients[i]);
        out.push(changes.as_ref().map_or(1.0, |changes| p_value(changes, at, &theta)));
        at += term.k();
    }
    out
}

/// How far the solution moves with each part of whitened rows left out. `matrix` is the normal matrix of all, priors included. `None` where
/// no part may be missing.
pub fn changes(whitened: &[f64], columns: usize, matrix: &DMatrix<f64>) -> Option<Vec<DVector<f64>>> {
    let width = columns + 1;
    let rows = whitened.len() / width;
    let whole = -Factor::of(matrix)?.solve(&Sums::of(whitened, columns).right);
    let part = rows.div_ceil(PARTS).max(FEWEST_ROWS);
    let mut changes = Vec::with_capacity(PARTS);
    for chunk in whitened.chunks(part * width) {
        let sums = Sums::of(chunk, columns);
        // Without a part the solution moves by what is left of the matrix, inverted, times the part's gradient.
        let left = Factor::of(&(matrix - &sums.matrix))?;
        changes.push(left.solve(&(&sums.right + &sums.matrix * &whole)));
    }
    Some(changes)
}

/// p-value of the coefficients from the number `at` on all being zero.
pub fn p_value(changes: &[DVector<f64>], at: usize, theta: &DVector<f64>) -> f64 {
    let (k, parts) = (theta.len(), changes.len() as f64);
    let degrees = parts - k as f64;
    if degrees < 1.0 {
        return 1.0;
    }
    let sum = changes.iter().fold(DVector::zeros(k), |sum, change| sum + change.rows(at, k));
    let mean = sum / parts;
    let mut spread = DMatrix::zeros(k, k);
    for change in changes {
        let off = change.rows(at, k) - &mean;
        spread += &off * off.transpose();
    }
    spread *= (parts - 1.0) / parts;
    let square = Factor::of(&spread).map_or(0.0, |factor| theta.dot(&factor.solve(theta)));
    f_tail(square * degrees / (k as f64 * (parts - 1.0)), k as f64, degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// p-value of a mean where all of it is a `jump` in one part.
    fn p_with(jump: f64) -> f64 {
        let rows: Vec<f64> = (0..400)
            .flat_map(|row| [1.0, if (80..90).contains(&row) { jump } else { 0.1 * f64::from(row % 7 - 3) }])
            .collect();
        let sums = Sums::of(&rows, 1);
        let theta = sums.factor().unwrap().solve(&sums.right);
        p_value(&changes(&rows, 1, &sums.matrix).unwrap(), 0, &theta)
    }

    #[test]
    fn one_part_alone_shows_nothing() {
        // A mean of one quarter out of a single part, and the same one out of all parts.
        assert!(p_with(10.0) > 0.05, "{}", p_with(10.0));
        let rows: Vec<f64> = (0..400).flat_map(|row| [1.0, 0.25 + 0.1 * f64::from(row % 7 - 3)]).collect();
        let sums = Sums::of(&rows, 1);
        let theta = sums.factor().unwrap().solve(&sums.right);
        assert!(p_value(&changes(&rows, 1, &sums.matrix).unwrap(), 0, &theta) < 1e-9);
    }
}
