//! Chance as the log itself shows it: a column moved round in time causes nothing, and has all else of the column.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::search::gains::decreases;
use crate::search::state::Greedy;
use ironout::effect::Follows;
use ironout::study::Residual;
use std::sync::Arc;

/// So many copies are made ...
const COPIES: usize = 24;
/// ... of which those count that are no more like the column than this ...
const UNLIKE: f64 = 0.5;
/// ... if they are at least so many.
const FEWEST: usize = 6;

/// Correlation of the first inputs of a term with themselves, moved by `by` samples.
fn likeness(values: &[f64], by: usize) -> f64 {
    let n = values.len();
    let square: f64 = values.iter().map(|v| v * v).sum();
    let product: f64 = (0..n).map(|at| values[at] * values[(at + by) % n]).sum();
    product / square.max(f64::MIN_POSITIVE)
}

impl<'a> Greedy<'_, 'a> {
    /// Whether an effect of a column takes more off the error than any copy of that column does that is moved round in time, and than
    /// any slow change: slow columns meet slow errors by chance. True of what has no column.
    pub(crate) fn beats_its_copies(&self, without: &Fitted<'a>, term: &Term<'a>) -> Result<bool, BadShape> {
        Ok(self.beats_moved_ones(without, term)? && self.is_more_than_slow(without, term)?)
    }

    fn beats_moved_ones(&self, without: &Fitted<'a>, term: &Term<'a>) -> Result<bool, BadShape> {
        let n = self.design.samples.len();
        if !term.follows(Follows::Column)
            || self.design.residual != Residual::Magnitude
            || term.inputs.len() != n
            || n < 10 * COPIES
        {
            return Ok(true);
        }
        let values: Vec<f64> = term.inputs.iter().map(|input| input[0]).collect();
        let mean = values.iter().sum::<f64>() / n as f64;
        let values: Vec<f64> = values.iter().map(|value| value - mean).collect();
        let mut list = vec![Term { coefficients: Default::default(), ..term.clone() }];
        for copy in 1..=COPIES {
            let by = copy * n / (COPIES + 1);
            if likeness(&values, by).abs() < UNLIKE {
                let mut inputs = term.inputs.as_ref().clone();
                inputs.rotate_left(by);
                list.push(Term { inputs: Arc::new(inputs), ..list[0].clone() });
            }
        }
        if list.len() <= FEWEST {
            return Ok(true);
        }
        let taken = decreases(&self.design, without, &list)?;
        let (own, copies) = taken.split_first().map_or((0.0, &[][..]), |(own, copies)| (*own, copies));
        Ok(copies.iter().all(|copy| *copy < own))
    }
}
