//! The rows of a pass, as the tests with the noise's spectrum want them.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Term};
use crate::threads::parts;
use ironout::study::Residual;
use std::ops::Range;

/// Rows of a pass, series after series (for the vector axis after axis).
pub struct Rows {
    pub(super) columns: usize,
    /// Row by row.
    pub(super) values: Vec<f64>,
    /// The residuals.
    pub(super) residuals: Vec<f64>,
    /// How alike the directions are that the noise shows along, by lag; empty where nothing turns.
    pub(super) alike: Vec<f64>,
    /// By how much each axis of the sensor shows in each row; empty where nothing turns.
    pub(super) weights: Vec<[f64; 3]>,
    /// Rounding of the readings: its variance in the residual.
    pub(super) rounding: f64,
    /// Time from sample to sample, s.
    pub(super) step_s: f64,
}

impl Rows {
    /// Of the fitted model with further terms.
    pub fn of(design: &Design, fitted: &Fitted, all: &[&Term]) -> Result<Rows, BadShape> {
        let columns = design.residual.base_columns() + all.iter().map(|term| term.k()).sum::<usize>();
        let columns = columns.min(COLUMNS);
        let step_s = design.samples.step_s();
        let mut rows = Rows {
            columns,
            values: Vec::new(),
            residuals: Vec::new(),
            alike: Vec::new(),
            weights: Vec::new(),
            rounding: 0.0,
            step_s,
        };
        let within = |range: &Range<usize>| -> Result<(Vec<f64>, Vec<f64>), BadShape> {
            let (mut values, mut residuals) = (Vec::with_capacity(range.len() * columns), Vec::new());
            design.rows(range.clone(), &fitted.model, all, |_, row, r| {
                values.extend_from_slice(&row[..columns]);
                residuals.push(r);
            })?;
            Ok((values, residuals))
        };
        for (values, residuals) in parts(design.samples.len(), within)? {
            rows.values.extend(values);
            rows.residuals.extend(residuals);
        }
        if design.residual == Residual::Vector {
            let axes = design.samples.axes.iter().filter(|used| **used).count().max(1);
            let n = rows.residuals.len();
            let order = (0..axes).flat_map(|axis| (axis..n).step_by(axes));
            let mut sorted = Rows { values: Vec::new(), residuals: Vec::new(), ..rows };
            for index in order {
                sorted.values.extend_from_slice(&rows.values[index * columns..(index + 1) * columns]);
                sorted.residuals.push(rows.residuals[index]);
            }
            rows = sorted;
        }
        if design.residual == Residual::Magnitude {
            let turning = design.turning(&fitted.model);
            (rows.alike, rows.weights) = (turning.alike, turning.weights);
            rows.rounding = design.samples.quantum_ut.powi(2) / 12.0;
        }
        Ok(rows)
    }

    pub(super) fn len(&self) -> usize {
        self.residuals.len()
    }

    /// Residuals of the linearised model moved by `step`.
    pub fn moved(&self, step: &[f64; COLUMNS]) -> Vec<f64> {
        self.values
            .chunks_exact(self.columns.max(1))
            .zip(&self.residuals)
            .map(|(row, r)| r + row.iter().zip(step).map(|(a, b)| a * b).sum::<f64>())
            .collect()
    }
}
