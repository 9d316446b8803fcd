//! Tests of candidates against a fitted model.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Matrix, TERMS, Term};
use crate::search::parts::{merged, p_value, parts};
pub use ironout::study::rule::{ACCUSED, RELEVANCE, SIGNIFICANCE};
use ironout::study::rule::{falls, is_accepted};
use ironout::study::{Residual, f_tail, held_out};

/// An effect of the magnitude is named if it takes at least this share off the squared held-out error.
pub const WORTH_NAMING: f64 = 0.15;

/// What a test of a candidate says.
#[derive(Debug, Clone)]
pub struct Tested {
    /// Its place in the list.
    pub index: usize,
    /// What it takes off the squared error.
    pub decrease: f64,
    /// Probability that chance does as well, with the search but not the number of candidates.
    pub p_value: f64,
    /// Squared held-out error with it.
    pub held_out: Option<f64>,
    /// Whether it should be added.
    pub accepted: bool,
}

/// Columns of a term that follows `base` columns and the terms before it.
pub(crate) fn ranges(base: usize, terms: &[&Term]) -> Vec<std::ops::Range<usize>> {
    let mut next = base;
    terms
        .iter()
        .map(|term| {
            let range = next..next + term.k();
            next = range.end;
            range
        })
        .collect()
}

/// A prior with a trace of information on further columns, so that directions the data do not show stay at zero.
pub(crate) fn ridge(prior: &Matrix, data: &Matrix, from: usize) -> Matrix {
    let mut out = prior.clone();
    let mut wide = Matrix::new(data.columns());
    wide.merge(&out);
    out = wide;
    for column in from..data.columns() {
        let size = data.entry(column, column);
        out.inform(column, column, if size > 0.0 { 1e-7 * size } else { 1.0 });
    }
    out
}

/// Tests each candidate by itself against the fitted model, in their order. `count` is the number of candidates of the whole search.
///
/// Chance is the larger of two probabilities: that of white noise (F), and that by the spread of the coefficients over parts of the log,
/// whatever the noise ([`p_value`]).
pub fn screen(
    design: &Design,
    fitted: &Fitted,
    candidates: &[Term],
    count: usize,
) -> Result<Vec<Tested>, BadShape> {
    let base = fitted.columns();
    let inner: Vec<&Term> = fitted.terms.iter().collect();
    let own: Vec<usize> = (0..base).collect();
    let mut all_tested = Vec::new();
    let mut start = 0;
    while start < candidates.len() {
        let mut columns = base;
        let mut end = start;
        while end < candidates.len() && end - start + inner.len() < TERMS {
            columns += candidates[end].k();
            if columns > COLUMNS {
                break;
            }
            end += 1;
        }
        if end == start {
            break;
        }
        let batch: Vec<&Term> = candidates[start..end].iter().collect();
        let all: Vec<&Term> = inner.iter().copied().chain(batch.iter().copied()).collect();
        // All are held against the model as it is, on the same blocks.
        let folds = design.folds(&all);
        let (bounds, of_fold) = parts(&folds);
        let pieces = design.blocks(&bounds, &fitted.model, &all)?;
        let blocks = merged(&pieces, &of_fold);
        let before = held_out(&blocks, Some(&fitted.prior), &own).map(|held| held.squares);
        let total = Matrix::total(&blocks, Some(&fitted.prior));
        let prior = ridge(&fitted.prior, &total, base);
        let rows = f64::from(total.rows());
        for (offset, span) in ranges(base, &batch).into_iter().enumerate() {
            let index = start + offset;
            let keep: Vec<usize> = own.iter().copied().chain(span.clone()).collect();
            let mut tested = Tested {
                index,
                decrease: 0.0,
                p_value: 1.0,
                held_out: held_out(&blocks, Some(&prior), &keep).map(|held| held.squares),
                accepted: false,
            };
            if let Some(gain) = total.test(0..base, span.clone()).filter(|gain| gain.directions > 0) {
                let trials = candidates[index].trials;
                tested.decrease = gain.decrease;
                let (f, k, freedom) = gain.f_statistic(base, rows, rows);
                tested.p_value = (f_tail(f, k, freedom) * trials).min(1.0);
                // It is looked at where that can matter.
                if tested.p_value * (count as f64) < SIGNIFICANCE {
                    let own = base..base + span.len();
                    let by_parts = p_value(&pieces, &prior, &keep, own, &[0.0; COLUMNS]);
                    tested.p_value = (by_parts * trials).clamp(tested.p_value, 1.0);
                }
                // The board's rule takes less for relevant; of so little the log's own structure makes as much by chance.
                let relevant = match design.residual {
                    Residual::Magnitude => WORTH_NAMING,
                    Residual::Dip | Residual::Vector => RELEVANCE,
                };
                let falls = match (before, tested.held_out) {
                    (Some(before), Some(after)) => after < before * (1.0 - relevant),
                    (before, after) => falls(before, after),
                };
                tested.accepted = is_accepted(tested.p_value, count, falls);
            }
            all_tested.push(tested);
        }
        start = end;
    }
    Ok(all_tested)
}

/// Probability that chance does as well as each effect of a fitted model, where the model stands, all others in it.
pub fn each_stands(design: &Design, fitted: &Fitted) -> Result<Vec<f64>, BadShape> {
    let list: Vec<&Term> = fitted.terms.iter().collect();
    let (bounds, _) = parts(&design.folds(&list));
    let pieces = design.blocks(&bounds, &fitted.model, &list)?;
    let keep: Vec<usize> = (0..fitted.columns()).collect();
    let spans = ranges(design.residual.base_columns(), &list);
    let tests = list.iter().zip(spans).map(|(term, span)| {
        let mut theta = [0.0; COLUMNS];
        theta[span.clone()].copy_from_slice(&term.coefficients[..term.k()]);
        // What the magnitude does not show of it is held, and no part of the log moves it.
        let hidden = term.hidden_delay();
        let mean =
            hidden.iter().map(|&entry| term.coefficients[entry]).sum::<f64>() / hidden.len().max(1) as f64;
        hidden.iter().for_each(|&entry| theta[span.start + entry] -= mean);
        p_value(&pieces, &fitted.prior, &keep, span, &theta)
    });
    Ok(tests.collect())
}
