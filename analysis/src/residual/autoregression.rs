//! The autoregression that a residual's short memory is described by.

use crate::samples::fft;

/// A series that follows from its own past and fresh noise.
pub(super) struct Autoregression {
    /// What each of the last values adds, the last first.
    pub(super) coefficients: Vec<f64>,
    /// Variance of the fresh noise.
    pub(super) error: f64,
}

impl Autoregression {
    /// That of the autocovariance `covariance` from `n` values, of the order that Akaike's criterion likes best.
    pub(super) fn of(covariance: &[f64], n: f64) -> Autoregression {
        let mut now: Vec<f64> = Vec::new();
        let mut error = covariance[0].max(f64::MIN_POSITIVE);
        let mut best = (n * error.ln(), now.clone(), error);
        for order in 1..covariance.len() {
            // Levinson's recursion.
            let expected: f64 = now.iter().enumerate().map(|(i, a)| a * covariance[order - 1 - i]).sum();
            let reflection = (covariance[order] - expected) / error;
            if !reflection.is_finite() || reflection.abs() >= 1.0 {
                break;
            }
            let mut next: Vec<f64> =
                (0..now.len()).map(|i| now[i] - reflection * now[now.len() - 1 - i]).collect();
            next.push(reflection);
            now = next;
            error *= 1.0 - reflection * reflection;
            let criterion = n * error.ln() + 2.0 * order as f64;
            if criterion < best.0 {
                best = (criterion, now.clone(), error);
            }
        }
        Autoregression { coefficients: best.1, error: best.2 }
    }

    /// Its power by bin.
    pub(super) fn power(&self, size: usize) -> Vec<f64> {
        let mut filter = vec![(0.0, 0.0); size];
        filter[0].0 = 1.0;
        for (slot, a) in filter.iter_mut().skip(1).zip(&self.coefficients) {
            slot.0 = -a;
        }
        fft::forward(&mut filter);
        let power = |(re, im): &(f64, f64)| self.error / (re * re + im * im).max(1e-12);
        filter.iter().take(size / 2 + 1).map(power).collect()
    }
}
