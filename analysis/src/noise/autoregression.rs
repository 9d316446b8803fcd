//! The short memory of a noise: a driver's rolling mean, differences, an output filter.

/// Autoregressive coefficients by Burg's method with the order of the least −2 log likelihood + order·ln n, and that cost per
/// sample sum: `n ln σ² + order ln n`.
pub fn burg(series: &[f64], most: usize) -> (Vec<f64>, f64, f64) {
    let n = series.len() as f64;
    let mut variance = series.iter().map(|v| v * v).sum::<f64>() / n.max(1.0);
    let mut ar = vec![1.0];
    let mut best = (ar.clone(), variance, n * variance.max(1e-300).ln());
    let (mut forward, mut backward) = (series.to_vec(), series.to_vec());
    let rows = series.len();
    for order in 1..=most.min(rows / 40) {
        let (f, b) = (&forward[order..], &backward[order - 1..rows - 1]);
        let (mut cross, mut power) = (0.0, 0.0);
        for (f, b) in f.iter().zip(b) {
            cross += f * b;
            power += f * f + b * b;
        }
        let k = if power > 0.0 { -2.0 * cross / power } else { 0.0 };
        for row in (order..rows).rev() {
            let (f, b) = (forward[row], backward[row - 1]);
            forward[row] = f + k * b;
            backward[row] = b + k * f;
        }
        ar.push(0.0);
        let reversed: Vec<f64> = ar.iter().rev().copied().collect();
        ar.iter_mut().zip(reversed).for_each(|(a, r)| *a += k * r);
        variance *= (1.0 - k * k).max(1e-12);
        let cost = n * variance.max(1e-300).ln() + order as f64 * n.ln();
        if cost < best.2 {
            best = (ar.clone(), variance, cost);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::MAX_AR_ORDER;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    fn white(seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..2000).map(|_| (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()).collect()
    }

    #[test]
    fn white_noise_has_no_memory() {
        let (ar, variance, _) = burg(&white(1), MAX_AR_ORDER);
        assert!(ar.len() == 1 && (variance - 1.0).abs() < 0.1, "{ar:?} {variance}");
    }

    #[test]
    fn a_first_order_memory_has_its_coefficient() {
        let mut last = 0.0;
        let series: Vec<f64> = white(2)
            .into_iter()
            .map(|value| {
                last = 0.8 * last + value;
                last
            })
            .collect();
        let (ar, variance, _) = burg(&series, MAX_AR_ORDER);
        assert!((ar[1] + 0.8).abs() < 0.06 && (variance - 1.0).abs() < 0.1, "{ar:?} {variance}");
    }

    #[test]
    fn a_rolling_mean_is_a_short_memory() {
        let white = white(3);
        let mean: Vec<f64> =
            (0..white.len()).map(|k| white[k.saturating_sub(3)..=k].iter().sum::<f64>() / 4.0).collect();
        let (ar, variance, _) = burg(&mean, MAX_AR_ORDER);
        assert!(ar.len() > 2 && variance < 0.13, "{ar:?} {variance}");
    }
}
