//! The parts of a log, and whether they agree about a coefficient.

use crate::base::term::{COLUMNS, Matrix};
use crate::evidence::held_out;
use nalgebra::DVector;
use std::ops::Range;

/// Parts of a block of the held-out error: some forty in all, enough for the errors of nine coefficients, each long enough for many
/// orientations.
const OF_A_BLOCK: usize = 4;
/// Samples of a part, at least.
const FEWEST: usize = 4;

/// Bounds of the parts of these blocks, and how many parts each block has.
pub fn parts(blocks: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let (mut bounds, mut counts) = (blocks.first().copied().into_iter().collect::<Vec<_>>(), Vec::new());
    for block in blocks.windows(2) {
        let length = block[1] - block[0];
        let count = (length / FEWEST).clamp(1, OF_A_BLOCK);
        bounds.extend((1..=count).map(|part| block[0] + length * part / count));
        counts.push(count);
    }
    (bounds, counts)
}

/// The blocks that have so many parts each.
pub fn merged(parts: &[Matrix], counts: &[usize]) -> Vec<Matrix> {
    let mut rest = parts;
    let mut blocks = Vec::with_capacity(counts.len());
    for &count in counts {
        let (own, after) = rest.split_at(count.min(rest.len()));
        blocks.push(Matrix::total(own, None));
        rest = after;
    }
    blocks
}

/// p-value of the coefficients `span` of the columns `keep` all being zero, by how far the solution moves with each part left out
/// (jackknife): their error whatever the noise, as long as it forgets within a part. `theta` is where the coefficients stand.
pub fn p_value(
    parts: &[Matrix],
    prior: &Matrix,
    keep: &[usize],
    span: Range<usize>,
    theta: &[f64; COLUMNS],
) -> f64 {
    let total = Matrix::total(parts, Some(prior)).select(keep);
    let Some(whole) = total.factor().map(|factor| total.step(&factor)) else { return 1.0 };
    let size = span.len();
    let mut changes = Vec::with_capacity(parts.len());
    for part in parts.iter().filter(|part| part.rows() > 0) {
        let rest = total.without(&part.select(keep));
        let Some(factor) = rest.factor() else { return 1.0 };
        let step = rest.step(&factor);
        changes.push(DVector::from_fn(size, |i, _| step[span.start + i] - whole[span.start + i]));
    }
    let theta = DVector::from_fn(size, |i, _| theta[span.start + i] + whole[span.start + i]);
    held_out::p_value(&changes, 0, &theta)
}
