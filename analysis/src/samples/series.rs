//! Statistics of one series: independence, noise, structure.

use crate::samples::fft;

/// Median; NaN of nothing.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Root mean square; zero of nothing.
pub fn rms(values: &[f64]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
    }
}

/// Noise from second differences: what a smooth structure leaves out. Exact for white noise.
pub fn second_difference_sigma(values: &[f64]) -> f64 {
    let n = values.len();
    if n < 3 {
        return rms(values);
    }
    let sum: f64 = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2)).sum();
    (sum / (6.0 * (n - 2) as f64)).sqrt()
}

/// The slowest decay from one sample to the next that an extrapolation is trusted with.
const SLOWEST_DECAY: f64 = 0.93;

/// A part that falls faster than this from one sample to the next is noise.
const SLOW_PART_DECAY: f64 = 0.8;

/// The longest memory that passes for noise, samples.
pub const LONGEST_MEMORY: usize = 60;

/// The autocorrelation of a series and what follows from it.
#[derive(Debug, Clone)]
pub struct Autocorrelation {
    /// Correlation at lag 0, 1, …
    pub at: Vec<f64>,
    /// Integrated autocorrelation time in samples, at least 1.
    pub time: f64,
}

impl Autocorrelation {
    /// Of a series, its mean removed.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len();
        if n < 8 {
            return Autocorrelation { at: vec![1.0], time: 1.0 };
        }
        let mean = values.iter().sum::<f64>() / n as f64;
        let size = (2 * n).next_power_of_two();
        let mut data: Vec<(f64, f64)> = values.iter().map(|v| (v - mean, 0.0)).collect();
        data.resize(size, (0.0, 0.0));
        fft::forward(&mut data);
        for value in &mut data {
            *value = (value.0 * value.0 + value.1 * value.1, 0.0);
        }
        fft::forward(&mut data);
        let zero = data[0].0;
        if zero <= 0.0 || !zero.is_finite() {
            return Autocorrelation { at: vec![1.0], time: 1.0 };
        }
        let lags = n / 3;
        let at: Vec<f64> = data[..lags].iter().map(|value| value.0 / zero).collect();
        // Sokal's window: sum until it is five times as long as the time it gives.
        let mut time = 1.0;
        for (lag, value) in at.iter().enumerate().skip(1) {
            time += 2.0 * value;
            if lag as f64 >= 5.0 * time.max(1.0) {
                break;
            }
        }
        // A correlation that white noise shows by chance is none.
        let chance = 3.0 / (n as f64).sqrt();
        let white = at.iter().skip(1).take(3).all(|value| value.abs() < chance) && time < 1.0 + 6.0 * chance;
        // A fit takes out mostly slow changes, and there the sum above is decided: with few independent samples it comes
        // out too short. The decay over the first lags hardly suffers, nor does it from a share of white noise on top.
        let at_lag = |lag: usize| at.get(lag).copied().unwrap_or(0.0);
        let first = at_lag(1).clamp(0.0, 1.0);
        let decay =
            if first > 0.05 { (at_lag(4).max(0.0) / first).cbrt().clamp(0.0, SLOWEST_DECAY) } else { 0.0 };
        let by_decay = 1.0 + 2.0 * first / (1.0 - decay);
        Autocorrelation { at, time: if white { 1.0 } else { time.max(by_decay) } }
    }

    /// The lag beyond which noise with a short memory has forgotten. Its decay is read between the first and the fourth
    /// lag, so that a share of white noise on top does not shorten it; no sensor's noise remembers for longer than
    /// [`LONGEST_MEMORY`] samples.
    pub fn horizon(&self) -> usize {
        let at = |lag: usize| self.at.get(lag).copied().unwrap_or(0.0);
        if at(1) < 0.05 {
            return 2;
        }
        let decay = (at(4).max(1e-3) / at(1)).powf(1.0 / 3.0).clamp(0.05, 0.999);
        let lag = (0.03 / at(1).clamp(0.05, 1.0)).ln() / decay.ln();
        (lag.ceil().max(2.0) as usize).min(LONGEST_MEMORY)
    }

    /// A slow part under noise that is independent from sample to sample: `c₁²/c₂` is the variance of a part that decays
    /// steadily, and what is missing to the whole is independent. Gives the shares of the independent and of the slow
    /// part, and how many standard errors the partial correlation at the second lag is from that of steady decay alone.
    pub fn two_parts(&self, n: usize) -> Option<(f64, f64, f64)> {
        let (first, second) = (self.at.get(1).copied()?, self.at.get(2).copied()?);
        if first <= 0.05 || second <= SLOW_PART_DECAY * first {
            return None;
        }
        let slow = (first * first / second).min(1.0);
        let partial = (second - first * first) / (1.0 - first * first).max(1e-12);
        Some((1.0 - slow, slow, partial * (n as f64).sqrt()))
    }

    /// After how many samples the correlation has fallen to 60 % of that of neighbours.
    pub fn fades_after(&self) -> usize {
        let first = self.at.get(1).copied().unwrap_or(0.0);
        self.at.iter().skip(1).position(|value| *value < 0.6 * first).map_or(self.at.len(), |lag| lag + 1)
    }

    /// How far the correlation beyond the horizon exceeds what noise of the same memory shows there by chance: the ratio
    /// of mean squares, 1 for noise. The squares, because structure that turns with the board changes its sign.
    pub fn structure(&self, n: usize) -> f64 {
        let horizon = self.horizon();
        let window = (4 * horizon).max(200);
        let end = (horizon + window).min(self.at.len());
        let Some(tail) = self.at.get(horizon..end).filter(|tail| tail.len() >= 20) else { return 1.0 };
        let square = tail.iter().map(|value| value * value).sum::<f64>() / tail.len() as f64;
        // Bartlett: a correlation that is none has the variance Σρ²/n.
        let memory: f64 = self.at.iter().take(horizon).skip(1).map(|value| value * value).sum();
        square / ((1.0 + 2.0 * memory) / n as f64)
    }
}

/// The smallest step between two readings of a column.
pub fn quantum(values: &[f64]) -> f64 {
    // A decimal fraction is not an exact step: what is left of two equal readings is none.
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 1e-6);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    fn correlated(rho: f64, n: usize, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut x = 0.0;
        (0..n)
            .map(|_| {
                let fresh: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
                x = rho * x + (1.0 - rho * rho).sqrt() * fresh;
                x
            })
            .collect()
    }

    #[test]
    fn the_time_of_a_first_order_process_is_known() {
        for rho in [0.0_f64, 0.5, 0.9] {
            let expected = (1.0 + rho) / (1.0 - rho);
            let mean =
                (0..20).map(|seed| Autocorrelation::of(&correlated(rho, 8000, seed)).time).sum::<f64>()
                    / 20.0;
            assert!((mean / expected - 1.0).abs() < 0.12, "rho {rho}: {mean} against {expected}");
        }
    }

    #[test]
    fn noise_with_a_short_memory_is_no_structure_and_a_slow_wave_is() {
        for seed in 0..20 {
            for rho in [0.0, 0.5, 0.9, 0.95] {
                let noise = correlated(rho, 4000, seed);
                let ratio = Autocorrelation::of(&noise).structure(4000);
                assert!(ratio < 6.0, "seed {seed}, rho {rho}: {ratio}");
            }
            let white = correlated(0.0, 4000, seed);
            for strength in [0.5, 1.0, 4.0, 20.0] {
                let wave: Vec<f64> =
                    white.iter().enumerate().map(|(i, v)| v + strength * (i as f64 / 80.0).sin()).collect();
                let ratio = Autocorrelation::of(&wave).structure(4000);
                assert!(ratio > 6.0, "seed {seed}, strength {strength}: {ratio}");
            }
        }
    }

    #[test]
    fn second_differences_see_white_noise_and_no_wave() {
        let noise = correlated(0.0, 8000, 3);
        let with: Vec<f64> =
            noise.iter().enumerate().map(|(i, v)| v + 5.0 * (i as f64 / 90.0).sin()).collect();
        assert!((second_difference_sigma(&with) / rms(&noise) - 1.0).abs() < 0.05);
    }
}
