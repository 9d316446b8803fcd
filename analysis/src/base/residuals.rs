//! Residuals of a model, sample by sample.

use crate::base::engine::Design;
use crate::base::term::{BadShape, COLUMNS, Term};
use crate::threads::parts;
use ironout::study::{Model, Residual};
use std::ops::Range;

impl Design<'_> {
    /// The residuals, in the order of the samples (axis by axis for the vector).
    pub fn residuals(&self, model: &Model<f64>, terms: &[&Term]) -> Result<Vec<f64>, BadShape> {
        Ok(self.moved(model, terms, &[])?.swap_remove(0))
    }

    /// Residuals of the model, and of the linearised model moved by each of `steps`.
    pub fn moved(
        &self,
        model: &Model<f64>,
        terms: &[&Term],
        steps: &[[f64; COLUMNS]],
    ) -> Result<Vec<Vec<f64>>, BadShape> {
        let within = |range: &Range<usize>| -> Result<Vec<Vec<f64>>, BadShape> {
            let mut out = vec![Vec::with_capacity(range.len()); steps.len().max(1)];
            self.rows(range.clone(), model, terms, |_, row, r| {
                if steps.is_empty() {
                    out[0].push(r);
                }
                for (series, step) in out.iter_mut().zip(steps) {
                    series.push(r + row.iter().zip(step).map(|(a, b)| a * b).sum::<f64>());
                }
            })?;
            Ok(out)
        };
        let mut parts = parts(self.samples.len(), within)?.into_iter();
        let mut out = parts.next().unwrap_or_default();
        for part in parts {
            out.iter_mut().zip(part).for_each(|(series, later)| series.extend(later));
        }
        if self.residual == Residual::Vector {
            let axes = self.samples.axes.iter().filter(|used| **used).count().max(1);
            for series in &mut out {
                *series =
                    (0..axes).flat_map(|axis| series.iter().skip(axis).step_by(axes).copied()).collect();
            }
        }
        Ok(out)
    }
}
