//! How many of the samples are independent, learned without keeping any.
//!
//! The fit's noise σ̂² holds everything that is not on the ellipsoid: white noise, but also slow noise and effects that
//! nobody modelled, which averaging does not remove. Differences of successive samples hold the quick part only: a turning
//! board moves nearly evenly from sample to sample. For noise of the first order (AR(1), correlation ρ from sample to
//! sample) the second differences have the variance `σ²(6 − 8ρ + 2ρ²)` and the third ones `σ²(20 − 30ρ + 12ρ² − 2ρ³)`; so the
//! ratio to σ̂² tells ρ, and the number of independent samples is `n (1−ρ)/(1+ρ)`. The third ones are freer of the motion:
//! a board turned by hand at 50 samples a second leaves a thousandth of the field in its second differences, a ten
//! thousandth in its third. Blocks are averaged by their logarithms: a jump or a jerk spoils its own block only.

use crate::gate::Gated;
use crate::math;

/// Running mean square of third differences of the samples that passed the rest gate.
#[derive(Clone, Debug)]
pub struct ThirdDifferences {
    ut_per_count: [f32; 3],
    last: [[i16; 3]; 3],
    seen: u8,
    block_ut2: f32,
    block_count: u32,
    logarithms: f64,
    blocks: u32,
}

impl ThirdDifferences {
    /// Nothing seen yet; scale in µT per count.
    pub fn new(ut_per_count: [f32; 3]) -> Self {
        Self {
            ut_per_count,
            last: [[0; 3]; 3],
            seen: 0,
            block_ut2: 0.0,
            block_count: 0,
            logarithms: 0.0,
            blocks: 0,
        }
    }

    /// Takes a sample into the open block.
    pub fn push(&mut self, counts: [i16; 3]) {
        let [a, b, c] = self.last;
        if self.seen >= 3 {
            for axis in 0..3 {
                let third = i32::from(counts[axis]) - i32::from(a[axis])
                    + 3 * (i32::from(b[axis]) - i32::from(c[axis]));
                let third_ut = third as f32 * self.ut_per_count[axis];
                self.block_ut2 += third_ut * third_ut;
            }
            self.block_count += 1;
        } else {
            self.seen += 1;
        }
        self.last = [b, c, counts];
    }

    /// Samples are missing here: no difference is taken across the gap.
    pub fn interrupt(&mut self) {
        self.seen = 0;
    }

    /// Keeps or forgets the open block, as the rest gate did: a board at rest with less noise than a count shows none.
    pub fn close(&mut self, gated: Gated) {
        match gated {
            Gated::Pending => return,
            Gated::Added(_) if self.block_count > 0 => {
                // A sensor's step is the least that a block can show; a hundredth of it keeps the logarithm finite.
                let [x, y, z] = self.ut_per_count;
                let floor = 0.01 * (x * x + y * y + z * z);
                let mean = (self.block_ut2 / self.block_count as f32).max(floor.max(f32::MIN_POSITIVE));
                self.logarithms += math::ln(mean.into());
                self.blocks = self.blocks.saturating_add(1);
            }
            Gated::Added(_) | Gated::Dropped(_) => {}
        }
        self.block_ut2 = 0.0;
        self.block_count = 0;
    }

    /// The noise variance per axis that white noise of these third differences would have, µT²; `None` before there are any.
    pub fn variance_ut2(&self) -> Option<f64> {
        (self.blocks > 0).then(|| math::exp(self.logarithms / f64::from(self.blocks)) / 60.0)
    }

    /// The share of independent samples, 0 … 1, for noise of variance `total_ut2`, of which the steps of the sensor are
    /// `quantisation_ut2`: those are white, whatever the rest is. `None` before there are any differences.
    pub fn independent_share(&self, total_ut2: f64, quantisation_ut2: f64) -> Option<f64> {
        self.variance_ut2().map(|white| share_of_third(white, total_ut2, quantisation_ut2))
    }
}

/// See [`ThirdDifferences::independent_share`]; `white` is the variance that the third differences would have as white noise.
fn share_of_third(white: f64, total: f64, quantisation: f64) -> f64 {
    let quantisation = quantisation.min(total).max(0.0);
    let slow = total - quantisation;
    let ratio = (white - quantisation) / slow;
    if !(slow > 0.0 && ratio.is_finite()) || ratio >= 1.0 {
        return 1.0;
    }
    // 20 ratio = 20 − 30ρ + 12ρ² − 2ρ³ falls from 20 at ρ = 0 to 0 at ρ = 1: halve.
    let (mut low, mut high) = (0.0, MOST_CORRELATED);
    for _ in 0..40 {
        let rho = 0.5 * (low + high);
        if 1.0 - rho * (1.5 - rho * (0.6 - 0.1 * rho)) > ratio {
            low = rho;
        } else {
            high = rho;
        }
    }
    // The averages of the two parts: the slow one as of fewer samples.
    total / (slow * (1.0 + high) / (1.0 - high) + quantisation)
}

/// The most correlation that is told from the differences; beyond it rounding decides.
const MOST_CORRELATED: f64 = 0.999;

/// The share of independent samples, 0 … 1, for noise of variance `total` whose second differences look like white noise
/// of variance `white`.
pub fn independent_share(white: f64, total: f64) -> f64 {
    if !(total > 0.0 && white >= 0.0) {
        return 1.0;
    }
    // 6 white/total = 6 − 8ρ + 2ρ².
    let rho = (2.0 - math::sqrt(1.0 + 3.0 * white / total)).clamp(0.0, 1.0);
    (1.0 - rho) / (1.0 + rho)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_order_noise_is_recognised_in_third_differences_through_steps() {
        for rho in [0.0f64, 0.5, 0.9] {
            for quantisation in [0.0, 0.4] {
                let white = 1.0 - 1.5 * rho + 0.6 * rho * rho - 0.1 * rho * rho * rho;
                let share = share_of_third(white + quantisation, 1.0 + quantisation, quantisation);
                let right = (1.0 + quantisation) / ((1.0 + rho) / (1.0 - rho) + quantisation);
                assert!((share - right).abs() < 1e-6, "{rho} {quantisation}: {share} {right}");
            }
        }
        assert_eq!(share_of_third(50.0, 1.0, 0.0), 1.0);
        assert_eq!(share_of_third(f64::NAN, 1.0, 0.0), 1.0);
        assert_eq!(share_of_third(1.0, 1.0, 2.0), 1.0);
        assert!(share_of_third(0.0, 1.0, 0.0) > 0.0);
    }

    #[test]
    fn first_order_noise_is_recognised() {
        for rho in [0.0f64, 0.5, 0.9] {
            let white = 1.0 - 4.0 / 3.0 * rho + rho * rho / 3.0;
            let share = independent_share(white, 1.0);
            assert!((share - (1.0 - rho) / (1.0 + rho)).abs() < 1e-12, "{rho}: {share}");
        }
        // Jumps from attitude to attitude are no sign of correlation.
        assert_eq!(independent_share(50.0, 1.0), 1.0);
        assert_eq!(independent_share(f64::NAN, 1.0), 1.0);
    }
}
