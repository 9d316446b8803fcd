//! Batch means of the score: how far the sums of `Jᵀr` over parts of a log spread.
//!
//! Independent samples make that spread `σ²JᵀJ`. A residual that is correlated where the rows are alike makes it larger, whatever its
//! spectrum, as long as its memory is short next to a part (Liang and Zeger 1986, Flegal and Jones 2010).

use nalgebra::{DMatrix, DVector};

/// Parts of a log whose scores are compared.
const BATCHES: usize = 24;

/// The sums of `Jᵀr` over equal parts of a log.
pub struct Scores {
    sums: Vec<DVector<f64>>,
    samples: usize,
}

impl Scores {
    /// Of so many columns, over so many samples.
    pub fn new(columns: usize, samples: usize) -> Self {
        Scores { sums: vec![DVector::zeros(columns); BATCHES], samples: samples.max(1) }
    }

    /// Adds the row of one sample; columns beyond those of the scores are left out.
    pub fn add(&mut self, sample: usize, row: &[f64], residual: f64) {
        if let Some(sum) = self.sums.get_mut(sample * BATCHES / self.samples) {
            sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value * residual);
        }
    }

    /// Covariance of the sum over all parts, estimated from their spread.
    pub fn spread(&self) -> DMatrix<f64> {
        let columns = self.sums.first().map_or(0, DVector::len);
        let sum = self.sums.iter().fold(DVector::zeros(columns), |sum: DVector<f64>, one| sum + one);
        let mean = sum / BATCHES as f64;
        let mut spread = DMatrix::zeros(columns, columns);
        for off in self.sums.iter().map(|one| one - &mean) {
            spread.ger(BATCHES as f64 / Self::FREEDOM, &off, &off, 1.0);
        }
        spread
    }

    /// Degrees of freedom of the spread.
    pub const FREEDOM: f64 = BATCHES as f64 - 1.0;
}
