//! The test of one more effect beside a fitted model.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Matrix, TERMS, Term};
pub use ironout::study::rule::{ACCUSED, RELEVANCE, SIGNIFICANCE};
use ironout::study::rule::{falls, is_accepted};
use ironout::study::{f_tail, held_out};

/// What a test of a candidate says.
#[derive(Debug, Clone)]
pub struct Tested {
    /// What it takes off the squared error.
    pub decrease: f64,
    /// p-value, corrected for the search but not for the number of candidates.
    pub p_value: f64,
    /// Squared held-out error with it.
    pub held_out: Option<f64>,
    /// Whether it should be added.
    pub accepted: bool,
}

/// A prior with a trace of information on further columns, so that directions the data do not show stay at zero.
fn ridge(prior: &Matrix, data: &Matrix, from: usize) -> Matrix {
    let mut out = Matrix::new(data.columns());
    out.merge(prior);
    for column in from..data.columns() {
        let size = data.entry(column, column);
        out.inform(column, column, if size > 0.0 { 1e-7 * size } else { 1.0 });
    }
    out
}

/// Tests one more effect beside a fitted model; `None` where there is no room for it. `count` is the number of those that compete.
pub fn test(design: &Design, fitted: &Fitted, term: &Term, count: usize) -> Result<Option<Tested>, BadShape> {
    let base = fitted.columns();
    if base + term.k() > COLUMNS || fitted.terms.len() >= TERMS {
        return Ok(None);
    }
    let all: Vec<&Term> = fitted.terms.iter().chain([term]).collect();
    // Both are held against the model as it is, on the same blocks.
    let blocks = design.blocks(&design.folds(&all), &fitted.model, &all)?;
    let own: Vec<usize> = (0..base).collect();
    let before = held_out(&blocks, Some(&fitted.prior), &own).map(|held| held.squares);
    let total = Matrix::total(&blocks, Some(&fitted.prior));
    let prior = ridge(&fitted.prior, &total, base);
    let rows = f64::from(total.rows());
    let span = base..base + term.k();
    let keep: Vec<usize> = (0..span.end).collect();
    let held_out = held_out(&blocks, Some(&prior), &keep).map(|held| held.squares);
    let mut tested = Tested { decrease: 0.0, p_value: 1.0, held_out, accepted: false };
    if let Some(gain) = total.test(0..base, span).filter(|gain| gain.directions > 0) {
        tested.decrease = gain.decrease;
        let (f, k, freedom) = gain.f_statistic(base, rows, rows);
        tested.p_value = (f_tail(f, k, freedom) * term.trials).min(1.0);
        tested.accepted = is_accepted(tested.p_value, count, falls(before, held_out));
    }
    Ok(Some(tested))
}
