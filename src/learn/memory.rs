//! How much memory the noise has, from differences of the residual as it streams: what changes slowly falls out of them.

use crate::math;
use crate::whiteness::{Pairs, share_of_pairs};

/// Samples between the two of a far pair.
const LAG: usize = 7;
/// From so many pairs on all count half: as long a memory as that of the blocks, and sums that single precision still adds to.
const MOST_PAIRS: u32 = 1 << 17;
/// No correlation of neighbours beyond this is told from two differences.
const MOST_CORRELATED: f64 = 0.97;

/// A sum of squared differences.
#[derive(Clone, Copy, Debug)]
struct Differences {
    squares: f32,
    pairs: u32,
}

impl Differences {
    const NONE: Self = Self { squares: 0.0, pairs: 0 };

    #[inline]
    fn push(&mut self, difference: f32) {
        self.squares += difference * difference;
        self.pairs += 1;
        if self.pairs == MOST_PAIRS {
            *self = Self { squares: 0.5 * self.squares, pairs: self.pairs / 2 };
        }
    }

    fn mean(self) -> Option<Pairs> {
        let Self { squares, pairs } = self;
        (pairs > 0).then(|| Pairs { mean_square: f64::from(squares) / f64::from(pairs), pairs })
    }
}

/// Squared differences of a residual, of neighbours and of samples seven apart.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    last: [f32; LAG],
    next: u8,
    in_a_row: u8,
    near: Differences,
    far: Differences,
}

impl Memory {
    pub(super) const fn new() -> Self {
        Self { last: [0.0; LAG], next: 0, in_a_row: 0, near: Differences::NONE, far: Differences::NONE }
    }

    #[inline]
    pub(super) fn push(&mut self, residual: f32) {
        let next = usize::from(self.next) % LAG;
        let before = self.last.get((next + LAG - 1) % LAG).copied().unwrap_or(0.0);
        if self.in_a_row > 0 {
            self.near.push(residual - before);
        }
        if let Some(slot) = self.last.get_mut(next) {
            if usize::from(self.in_a_row) == LAG {
                self.far.push(residual - *slot);
            }
            *slot = residual;
        }
        self.next = ((next + 1) % LAG) as u8;
        self.in_a_row = (self.in_a_row + 1).min(LAG as u8);
    }

    /// Samples are missing here: no pair reaches across the gap.
    pub(super) fn interrupt(&mut self) {
        self.in_a_row = 0;
    }

    fn pairs(&self) -> Option<(Pairs, Pairs)> {
        Some((self.near.mean()?, self.far.mean()?))
    }

    /// The variance of what is new from one sample to the next; zero where that is not known.
    pub(super) fn quick(&self) -> f32 {
        0.5 * self.near.squares / self.near.pairs.max(1) as f32
    }

    /// How many samples are as good as one independent one, of a residual of this variance; at least 1.
    pub(super) fn time(&self, variance: f64, samples: f64, parameters: f64) -> f64 {
        let share = self
            .pairs()
            .and_then(|(near, far)| share_of_pairs(variance, near, far, LAG as i32, samples, parameters));
        1.0 / share.unwrap_or(1.0)
    }

    /// The variance that is noise, of a residual of this variance: as much as noise with the memory that both differences show,
    /// which forgets exponentially.
    pub(super) fn noise(&self, variance: f64) -> f64 {
        let Some((near, far)) = self.pairs() else { return variance };
        let half = 0.5 * near.mean_square;
        if half <= 0.0 {
            return variance;
        }
        // (1 − ρ⁷)/(1 − ρ) = 1 + ρ + … + ρ⁶ is the quotient of both.
        let quotient = far.mean_square / near.mean_square;
        let sum = |rho: f64| (0..LAG).fold(0.0, |sum, _| sum * rho + 1.0);
        let (mut low, mut high) = (0.0, MOST_CORRELATED);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if sum(middle) < quotient { low = middle } else { high = middle }
        }
        (half / (1.0 - low)).min(variance)
    }

    /// Root of [`Memory::noise`].
    pub(super) fn floor(&self, variance: f64) -> f64 {
        math::sqrt(self.noise(variance).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_with_a_memory_is_noise_and_what_is_slow_is_not() {
        for rho in [0.0, 0.6, 0.9f64] {
            let mut memory = Memory::new();
            let (mut state, mut value) = (7u64, 0.0);
            let (mut squares, n) = (0.0, 40_000);
            for i in 0..n {
                let fresh: f64 = (0..12)
                    .map(|_| {
                        state = state
                            .wrapping_mul(6_364_136_223_846_793_005)
                            .wrapping_add(1_442_695_040_888_963_407);
                        (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
                    })
                    .sum();
                value = rho * value + math::sqrt(1.0 - rho * rho) * fresh;
                // Three times the noise, once in 40 s.
                let slow = 3.0 * math::sin(f64::from(i) * 0.02 * 0.157);
                memory.push((value + slow) as f32);
                squares += (value + slow) * (value + slow);
            }
            let variance = squares / f64::from(n);
            assert!((memory.floor(variance) - 1.0).abs() < 0.12, "{rho}: {}", memory.floor(variance));
            let time = memory.time(1.0, f64::from(n), 9.0);
            let right = (1.0 + rho) / (1.0 - rho);
            assert!((time / right - 1.0).abs() < 0.35, "{rho}: {time} for {right}");
            assert!(memory.time(variance, f64::from(n), 9.0) > 20.0, "structure counts as few samples");
        }
    }
}
