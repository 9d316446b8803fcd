//! What candidates take off the squared error, each alone.

use crate::base::engine::{Fitted, Pass};
use crate::base::piece::{BadShape, COLUMNS, Matrix, Piece};

/// How much each candidate alone takes off the squared error.
pub(crate) fn decreases(pass: &Pass, fitted: &Fitted, candidates: &[Piece]) -> Result<Vec<f64>, BadShape> {
    let base = fitted.columns();
    let mut out = Vec::new();
    let width = candidates.iter().map(Piece::k).max().unwrap_or(1);
    let batch = ((COLUMNS - base) / width).clamp(1, crate::base::piece::TERMS - fitted.pieces.len());
    for chunk in candidates.chunks(batch) {
        let all: Vec<&Piece> = fitted.pieces.iter().chain(chunk).collect();
        let blocks = pass.blocks(&pass.samples.bounds(2), &fitted.model, &all)?;
        let total = Matrix::total(&blocks, Some(&fitted.prior));
        let mut column = base;
        for piece in chunk {
            let span = column..column + piece.k();
            column = span.end;
            out.push(total.test(0..base, span).map_or(0.0, |gain| gain.decrease));
        }
    }
    Ok(out)
}

/// The place of the largest.
pub(crate) fn largest(values: &[f64]) -> usize {
    values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(index, _)| index)
}
