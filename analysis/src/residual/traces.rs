//! The residuals sample by sample, for whoever draws them.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, Term};
use crate::samples::samples::Samples;
use ironout::study::Residual;
use serde::Serialize;

/// Residuals of the base model and of the final one.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Traces {
    /// Row of the log of each sample.
    pub rows: Vec<usize>,
    /// Residual of the base model, µT: one series for the magnitude, one for each axis in use of a resting board.
    pub base_ut: Vec<Vec<f64>>,
    /// Residual of the final model, likewise.
    pub final_ut: Vec<Vec<f64>>,
    /// Unit vectors of the field as the base model corrects it; empty for a resting board.
    pub directions: Vec<[f64; 3]>,
}

impl Traces {
    /// Of two models over the same samples.
    pub fn of(design: &Design, base: &Fitted, last: &Fitted) -> Result<Traces, BadShape> {
        let samples: &Samples = design.samples;
        let residuals = |fitted: &Fitted| -> Result<Vec<Vec<f64>>, BadShape> {
            let terms: Vec<&Term> = fitted.terms.iter().collect();
            let all = design.residuals(&fitted.model, &terms)?;
            Ok(all.chunks(samples.len().max(1)).map(<[f64]>::to_vec).collect())
        };
        let direction = |index: usize| {
            let at_sample: Vec<_> = base.terms.iter().map(|term| term.at_sample(index)).collect();
            let h = base.model.correct(&samples.readings[index], &at_sample).unwrap_or_default();
            let length = h.iter().map(|value| value * value).sum::<f64>().sqrt();
            if length > 0.0 { h.map(|value| value / length) } else { [0.0; 3] }
        };
        let directions = match design.residual {
            Residual::Vector => Vec::new(),
            _ => (0..samples.len()).map(direction).collect(),
        };
        Ok(Traces {
            rows: samples.row.clone(),
            base_ut: residuals(base)?,
            final_ut: residuals(last)?,
            directions,
        })
    }
}
