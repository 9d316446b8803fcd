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
    fn second_differences_see_white_noise_and_no_wave() {
        let noise = correlated(0.0, 8000, 3);
        let with: Vec<f64> =
            noise.iter().enumerate().map(|(i, v)| v + 5.0 * (i as f64 / 90.0).sin()).collect();
        assert!((second_difference_sigma(&with) / rms(&noise) - 1.0).abs() < 0.05);
    }
}
