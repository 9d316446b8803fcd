//! What the residual says about the noise.

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
}
