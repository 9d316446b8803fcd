//! What a linear model with structured noise tells of its parameters next to a prior.
//!
//! Least squares `N θ = Jᵀr` with the errors of batch means, `N⁻¹ S N⁻¹`, give the information `N S⁻¹ N`; a direction that the data do not see has none
//! and keeps the prior.

use crate::samples::scores::Scores;
use nalgebra::{SMatrix, SVector};

/// Sums of a second pass over the data, at the estimate of the first.
pub struct Estimate<const P: usize> {
    normal: SMatrix<f64, P, P>,
    estimate: SVector<f64, P>,
    prior: SVector<f64, P>,
    scores: Scores,
    squares: f64,
    rows: f64,
}

impl<const P: usize> Estimate<P> {
    /// With `N = JᵀJ` and `Jᵀr`, the prior's information on each parameter, and the number of samples in order of time.
    pub fn new(
        normal: SMatrix<f64, P, P>,
        right: SVector<f64, P>,
        prior: SVector<f64, P>,
        samples: usize,
    ) -> Self {
        let damped = normal + SMatrix::from_diagonal(&(prior * DAMPING));
        let estimate = damped.cholesky().map_or_else(SVector::zeros, |factor| factor.solve(&right));
        Estimate { normal, estimate, prior, scores: Scores::new(P, samples), squares: 0.0, rows: 0.0 }
    }

    /// Adds a row `column·θ = value` of a sample.
    pub fn add(&mut self, sample: usize, column: SVector<f64, P>, value: f64) {
        let residual = value - column.dot(&self.estimate);
        self.scores.add(sample, column.as_slice(), residual);
        self.squares += residual * residual;
        self.rows += 1.0;
    }

    /// Mean and covariance of the parameters.
    pub fn posterior(&self) -> (SVector<f64, P>, SMatrix<f64, P, P>) {
        let unknown = SMatrix::from_diagonal(&self.prior.map(f64::recip));
        let spread = self.scores.spread();
        // Both are estimates of one spread: their sum is never below either.
        let white = (self.normal + SMatrix::from_diagonal(&(self.prior * DAMPING)))
            * (self.squares / self.rows.max(1.0)).max(f64::MIN_POSITIVE);
        let spread = SMatrix::<f64, P, P>::from_fn(|i, j| spread[(i, j)]) + white;
        let Some(weighed) = spread.cholesky().map(|factor| factor.solve(&self.normal)) else {
            return (SVector::zeros(), unknown);
        };
        let weighed_normal = self.normal * weighed;
        let Some(covariance) = (weighed_normal + SMatrix::from_diagonal(&self.prior)).cholesky() else {
            return (SVector::zeros(), unknown);
        };
        let (mean, covariance) = (covariance.solve(&(weighed_normal * self.estimate)), covariance.inverse());
        let finite = mean.iter().chain(covariance.iter()).all(|value| value.is_finite());
        if finite { (mean, covariance) } else { (SVector::zeros(), unknown) }
    }
}

/// The share of the prior's information that holds what nothing else does, and moves nothing.
const DAMPING: f64 = 1e-6;
