//! What the residual says about the noise: its floor, and how many samples are independent.

/// Longest correlation that is looked for, in samples.
const LONGEST: usize = 2000;
/// The sum of autocorrelations is stopped at this many correlation times: beyond, it is only noise (Sokal's window).
const WINDOW: f64 = 5.0;

/// Standard deviation of the fast part of a residual, from its second differences: slow structure cancels in
/// `r₋ − 2r + r₊`, whose variance is six times that of independent noise. Only neighbours are compared.
pub fn second_difference_sigma(samples: &[u32], residual: &[f64]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u64);
    for (at, r) in samples.windows(3).zip(residual.windows(3)) {
        if at[2] - at[0] == 2 {
            let difference = r[0] - 2.0 * r[1] + r[2];
            sum += difference * difference;
            count += 1;
        }
    }
    (count >= 20).then(|| (sum / (6.0 * count as f64)).sqrt())
}

/// Samples that together are worth one independent sample: the integrated autocorrelation time of the residual,
/// at least 1.
pub fn correlation_samples(residual: &[f64]) -> f64 {
    let n = residual.len();
    if n < 20 {
        return 1.0;
    }
    let mean = residual.iter().sum::<f64>() / n as f64;
    let centred: Vec<f64> = residual.iter().map(|r| r - mean).collect();
    let variance: f64 = centred.iter().map(|r| r * r).sum();
    if variance <= 0.0 || !variance.is_finite() {
        return 1.0;
    }
    let mut time = 1.0;
    for lag in 1..LONGEST.min(n / 4) {
        let product: f64 = centred.iter().zip(&centred[lag..]).map(|(a, b)| a * b).sum();
        time += 2.0 * product / variance;
        if time <= 1.0 || lag as f64 >= WINDOW * time {
            break;
        }
    }
    time.clamp(1.0, n as f64 / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        (0..n).map(|_| (0..12).map(|_| uniform()).sum()).collect()
    }

    #[test]
    fn second_differences_see_the_noise_and_not_the_structure() {
        let samples: Vec<u32> = (0..20_000).collect();
        let residual: Vec<f64> =
            noise(20_000).iter().enumerate().map(|(i, w)| w + 5.0 * (i as f64 / 500.0).sin()).collect();
        let sigma = second_difference_sigma(&samples, &residual).expect("enough samples");
        assert!((sigma - 1.0).abs() < 0.02, "{sigma}");
    }

    #[test]
    fn white_noise_is_independent_and_filtered_noise_is_not() {
        let white = noise(50_000);
        assert!((correlation_samples(&white) - 1.0).abs() < 0.1);
        let mut filtered = 0.0;
        let red: Vec<f64> = white
            .iter()
            .map(|w| {
                filtered = 0.9 * filtered + w;
                filtered
            })
            .collect();
        // AR(1): (1 + 0.9)/(1 - 0.9) = 19.
        let time = correlation_samples(&red);
        assert!((15.0..23.0).contains(&time), "{time}");
    }
}
