//! A radix-2 Fourier transform: all that spectra and autocorrelations of a residual need.

use std::cell::RefCell;
use std::f64::consts::TAU;

thread_local! {
    /// `e^(−2πi k/n)` for k < n/2 of the longest transform so far: a shorter one reads every second, fourth … of them.
    static TURNS: RefCell<Vec<(f64, f64)>> = const { RefCell::new(Vec::new()) };
}

/// Transforms in place, `Σ x_j e^(−2πi jk/n)`. The length must be a power of two; any other is left alone.
pub fn forward(data: &mut [(f64, f64)]) {
    let n = data.len();
    if n < 2 || !n.is_power_of_two() {
        return;
    }
    let shift = n.leading_zeros() + 1;
    for i in 0..n {
        let j = i.reverse_bits() >> shift;
        if i < j {
            data.swap(i, j);
        }
    }
    TURNS.with_borrow_mut(|turns| {
        if turns.len() < n / 2 {
            *turns = (0..n / 2)
                .map(|k| {
                    let (sin, cos) = (-TAU * k as f64 / n as f64).sin_cos();
                    (cos, sin)
                })
                .collect();
        }
        let mut half = 1;
        while half < n {
            let stride = turns.len() / half;
            for pair in data.chunks_exact_mut(2 * half) {
                let (low, high) = pair.split_at_mut(half);
                for ((a, b), w) in low.iter_mut().zip(high).zip(turns.iter().step_by(stride)) {
                    let t = (b.0 * w.0 - b.1 * w.1, b.0 * w.1 + b.1 * w.0);
                    *b = (a.0 - t.0, a.1 - t.1);
                    *a = (a.0 + t.0, a.1 + t.1);
                }
            }
            half *= 2;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::forward;

    #[test]
    fn equals_the_sum_it_stands_for() {
        let x: Vec<(f64, f64)> = (0..32).map(|i| ((f64::from(i) * 0.7).sin(), f64::from(i % 5))).collect();
        let mut fast = x.clone();
        forward(&mut fast);
        for (k, value) in fast.iter().enumerate() {
            let mut sum = (0.0, 0.0);
            for (j, (re, im)) in x.iter().enumerate() {
                let (sin, cos) = (-std::f64::consts::TAU * (j * k) as f64 / 32.0).sin_cos();
                sum = (sum.0 + re * cos - im * sin, sum.1 + re * sin + im * cos);
            }
            assert!((sum.0 - value.0).abs() < 1e-9 && (sum.1 - value.1).abs() < 1e-9, "bin {k}");
        }
    }
}
