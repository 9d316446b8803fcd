//! Tests of candidates against a fitted model.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Matrix, TERMS, Term};
use crate::residual::spectrum::{Frame, Rows, Verdict};
use crate::threads::halves;
pub use ironout::study::rule::{ACCUSED, RELEVANCE, SIGNIFICANCE};
use ironout::study::rule::{falls, is_accepted};
use ironout::study::{Improvement, Residual, f_tail, held_out};
use std::ops::Range;

/// An effect of the magnitude is named if it takes at least this share off the squared held-out error.
pub const WORTH_NAMING: f64 = 0.15;

/// What takes less than this share off the squared error may be part of 1/f noise.
const OF_SLOW_NOISE: f64 = 0.5;
/// No noise follows its colour to the letter: where it is weakly known, at the lowest frequencies, chance is so many times likelier.
const CAUTION: f64 = 10.0;

/// What a test of a candidate says.
#[derive(Debug, Clone)]
pub struct Tested {
    /// Its place in the list.
    pub index: usize,
    /// Directions that are new.
    pub directions: usize,
    /// What it takes off the squared error.
    pub decrease: f64,
    /// Probability that chance does as well, with the search but not the number of candidates.
    pub p_value: f64,
    /// Squared held-out error with it.
    pub held_out: Option<f64>,
    /// By how much the noise's memory widens its errors (variance), as the residual with it shows.
    pub time: f64,
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
        let blocks = design.blocks(&design.folds(&all), &fitted.model, &all)?;
        let before = held_out(&blocks, Some(&fitted.prior), &own).map(|held| held.squares);
        let total = Matrix::total(&blocks, Some(&fitted.prior));
        let prior = ridge(&fitted.prior, &total, base);
        let safe = Matrix::total(&blocks, Some(&prior));
        let spans = ranges(base, &batch);
        let keeps: Vec<Vec<usize>> =
            spans.iter().map(|span| own.iter().copied().chain(span.clone()).collect()).collect();
        let gains: Vec<Option<Improvement<f64>>> = spans
            .iter()
            .map(|span| total.test(0..base, span.clone()).filter(|gain| gain.directions > 0))
            .collect();
        let rows = f64::from(total.rows());
        let chance = |gain: &Improvement<f64>, index: usize| {
            let (f, k, freedom) = gain.f_statistic(base, rows, rows);
            (f_tail(f, k, freedom) * candidates[index].trials).min(1.0)
        };
        // The noise's memory mostly makes chance more likely: it is looked at where that can matter.
        let close: Vec<usize> = (0..batch.len())
            .filter(|offset| {
                let index = start + offset;
                gains[*offset]
                    .as_ref()
                    .is_some_and(|gain| chance(gain, index) * (count as f64) < SIGNIFICANCE)
            })
            .collect();
        let rows = match close.is_empty() {
            true => None,
            false => Some(Rows::of(design, fitted, &all)?),
        };
        let frame = rows.as_ref().and_then(|rows| Frame::new(rows, &total, own.clone()));
        let coloured = |offset: usize| {
            let (rows, frame) = rows.as_ref().zip(frame.as_ref())?;
            let part = safe.select(&keeps[offset]);
            let mut step = [0.0; COLUMNS];
            for (column, value) in keeps[offset].iter().zip(part.step(&part.factor()?)) {
                step[*column] = value;
            }
            let span = spans[offset].clone();
            let left = rows.moved(&step);
            let noise = frame.spectrum(&total, span.clone(), &left)?;
            let test = frame.test(&total, span.clone(), &noise)?;
            let tries = candidates[start + offset].trials * count as f64;
            let found = with_colour(frame, &total, span.clone(), &left, test, tries);
            let takes = gains[offset].as_ref().map_or(0.0, |gain| gain.decrease);
            match takes < OF_SLOW_NOISE * fitted.squares {
                true => Some(before_it(frame, &total, span, &rows.moved(&[0.0; COLUMNS]), found, tries)),
                false => Some(found),
            }
        };
        let all_of = |half: &[usize]| half.iter().map(|offset| coloured(*offset)).collect::<Vec<_>>();
        let (first, second) = match close.len() {
            0 | 1 => (all_of(&close), Vec::new()),
            two => halves(close.split_at(two / 2), all_of),
        };
        let mut verdicts = first.into_iter().chain(second);
        for (offset, keep) in keeps.iter().enumerate() {
            let index = start + offset;
            // In the order of those that are close.
            let coloured = if close.contains(&offset) { verdicts.next().flatten() } else { None };
            let mut tested = Tested {
                index,
                directions: 0,
                decrease: 0.0,
                p_value: 1.0,
                held_out: held_out(&blocks, Some(&prior), keep).map(|held| held.squares),
                time: coloured.as_ref().map_or(1.0, |test| test.time),
                accepted: false,
            };
            if let Some(gain) = &gains[offset] {
                tested.directions = gain.directions;
                tested.decrease = gain.decrease;
                tested.p_value = match (coloured, close.contains(&offset)) {
                    (Some(test), _) => (test.p_value * candidates[index].trials).min(1.0),
                    (None, true) => 1.0,
                    (None, false) => chance(gain, index),
                };
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

/// The test once more where it would be passed, with the colour of the noise: 1/f noise, or a rolling mean, holds more at
/// low frequencies than its own short past tells.
fn with_colour(
    frame: &Frame,
    total: &Matrix,
    span: Range<usize>,
    left: &[f64],
    test: Verdict,
    tries: f64,
) -> Verdict {
    if test.p_value * tries >= SIGNIFICANCE {
        return test;
    }
    let noises = frame.coloured(total, span.clone(), left);
    let tests = noises.iter().filter_map(|noise| frame.test(total, span.clone(), noise));
    // The noise may be any of them: what chance does by one of them may be chance.
    tests.fold(test, |most, next| if next.p_value > most.p_value { next } else { most })
}

/// The same with the colour that the noise has before the candidate is taken out of it: a slow column takes the slowest part of
/// 1/f noise with it, and what is left looks whiter than the noise is.
fn before_it(
    frame: &Frame,
    total: &Matrix,
    span: Range<usize>,
    residuals: &[f64],
    test: Verdict,
    tries: f64,
) -> Verdict {
    if test.p_value * tries >= SIGNIFICANCE {
        return test;
    }
    let noises = frame.coloured(total, 0..0, residuals);
    let tests = noises.iter().filter_map(|noise| frame.test(total, span.clone(), noise));
    let careful = tests.map(|test| Verdict { p_value: (CAUTION * test.p_value).min(1.0), ..test });
    careful.fold(test, |most, next| if next.p_value > most.p_value { next } else { most })
}

/// The test of a fitted model's last effect, where the model stands.
pub fn stands(design: &Design, fitted: &Fitted) -> Result<Option<Verdict>, BadShape> {
    let Some(last) = fitted.terms.len().checked_sub(1) else { return Ok(None) };
    Ok(each_stands(design, fitted, last..last + 1)?.pop().flatten())
}

/// The test of each of these effects of a fitted model, where the model stands, all others in it.
pub fn each_stands(
    design: &Design,
    fitted: &Fitted,
    which: Range<usize>,
) -> Result<Vec<Option<Verdict>>, BadShape> {
    let columns = fitted.columns();
    let rows = Rows::of(design, fitted, &fitted.terms.iter().collect::<Vec<_>>())?;
    let residuals = rows.moved(&[0.0; COLUMNS]);
    let total = fitted.total();
    let test = |index: usize| {
        let term = &fitted.terms[index];
        let after: usize = fitted.terms[index..].iter().map(Term::k).sum();
        let own = columns - after..columns - after + term.k();
        let mut away = [0.0; COLUMNS];
        for (slot, value) in away[own.clone()].iter_mut().zip(term.coefficients) {
            *slot = -value;
        }
        let total = total.moved(&away);
        let others = (0..columns).filter(|column| !own.contains(column)).collect();
        let frame = Frame::new(&rows, &total, others)?;
        let noise = frame.spectrum(&total, own.clone(), &residuals)?;
        let test = frame.test(&total, own.clone(), &noise)?;
        Some(with_colour(&frame, &total, own, &residuals, test, 1.0))
    };
    Ok(which.map(test).collect())
}
