//! How many of the samples are independent, learned without keeping any.
//!
//! The fit's noise σ̂² holds everything that is not on the ellipsoid: white noise, but also slow noise and effects that
//! nobody modelled, which averaging does not remove. Second differences of the samples hold the white part only: a turning
//! board moves nearly evenly from sample to sample. For noise of the first order (AR(1), correlation ρ from sample to
//! sample) the second differences have the variance `σ²(6 − 8ρ + 2ρ²)`, so the ratio of the two tells ρ, and the
//! number of independent samples is `n (1−ρ)/(1+ρ)`.

use crate::gate::Gated;
use crate::math;

/// Running mean square of second differences of the samples that passed the rest gate.
#[derive(Clone, Debug)]
pub struct SecondDifferences {
    ut_per_count: [f32; 3],
    last: [[i16; 3]; 2],
    seen: u8,
    block_ut2: f32,
    block_count: u32,
    total_ut2: f64,
    count: u64,
}

impl SecondDifferences {
    /// Nothing seen yet; scale in µT per count.
    pub fn new(ut_per_count: [f32; 3]) -> Self {
        Self {
            ut_per_count,
            last: [[0; 3]; 2],
            seen: 0,
            block_ut2: 0.0,
            block_count: 0,
            total_ut2: 0.0,
            count: 0,
        }
    }

    /// Takes a sample into the open block.
    pub fn push(&mut self, counts: [i16; 3]) {
        if self.seen >= 2 {
            let [before, last] = self.last;
            for axis in 0..3 {
                let second = i32::from(counts[axis]) - 2 * i32::from(last[axis]) + i32::from(before[axis]);
                let second_ut = second as f32 * self.ut_per_count[axis];
                self.block_ut2 += second_ut * second_ut;
            }
            self.block_count += 1;
        } else {
            self.seen += 1;
        }
        self.last = [self.last[1], counts];
    }

    /// Keeps or forgets the open block, as the rest gate did: a board at rest with less noise than a count shows none.
    pub fn close(&mut self, gated: Gated) {
        match gated {
            Gated::Pending => return,
            Gated::Added(_) => {
                self.total_ut2 += f64::from(self.block_ut2);
                self.count += u64::from(self.block_count);
            }
            Gated::Dropped(_) => {}
        }
        self.block_ut2 = 0.0;
        self.block_count = 0;
    }

    /// The noise variance per axis that white noise of these second differences would have, µT²; `None` before there are any.
    pub fn variance_ut2(&self) -> Option<f64> {
        (self.count > 0).then(|| self.total_ut2 / (18.0 * self.count as f64))
    }
}

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
