//! What candidates take off the squared error, each alone.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Matrix, Term};

/// How much each candidate alone takes off the squared error.
pub(crate) fn decreases(design: &Design, fitted: &Fitted, candidates: &[Term]) -> Result<Vec<f64>, BadShape> {
    let base = fitted.columns();
    let mut out = Vec::new();
    let width = candidates.iter().map(Term::k).max().unwrap_or(1);
    let batch = ((COLUMNS - base) / width).clamp(1, crate::base::term::TERMS - fitted.terms.len());
    for chunk in candidates.chunks(batch) {
        let all: Vec<&Term> = fitted.terms.iter().chain(chunk).collect();
        let blocks = design.blocks(&design.samples.bounds(2), &fitted.model, &all)?;
        let total = Matrix::total(&blocks, Some(&fitted.prior));
        let mut column = base;
        for term in chunk {
            let span = column..column + term.k();
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
