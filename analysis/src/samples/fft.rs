//! The one gateway to the Fourier transform, which is `rustfft`'s.

use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};
use std::cell::RefCell;
use std::collections::BTreeMap;

thread_local! {
    /// Plans of the lengths so far. Powers of two alone: a planner for any length would bring code for all primes, which costs more to build
    /// than the rest of this crate.
    static PLANS: RefCell<BTreeMap<usize, Radix4<f64>>> = const { RefCell::new(BTreeMap::new()) };
}

/// Transforms `Σ x_j e^(−2πi jk/n)`, real and imaginary part in pairs, not normalised, with zeros behind them up to a power of two.
pub fn forward(data: &mut Vec<(f64, f64)>) {
    let length = data.len().next_power_of_two();
    let mut values: Vec<Complex<f64>> = data.iter().map(|&(re, im)| Complex::new(re, im)).collect();
    values.resize(length, Complex::new(0.0, 0.0));
    PLANS.with_borrow_mut(|plans| {
        plans
            .entry(length)
            .or_insert_with(|| Radix4::new(length, FftDirection::Forward))
            .process(&mut values);
    });
    data.clear();
    data.extend(values.iter().map(|value| (value.re, value.im)));
}

#[cfg(test)]
mod tests {
    use super::forward;

    #[test]
    fn equals_the_sum_it_stands_for() {
        for n in [0, 1, 2, 24, 32, 64, 128] {
            let x: Vec<(f64, f64)> = (0..n).map(|i| ((f64::from(i) * 0.7).sin(), f64::from(i % 5))).collect();
            let mut fast = x.clone();
            forward(&mut fast);
            assert_eq!(fast.len(), x.len().next_power_of_two());
            for (k, value) in fast.iter().enumerate() {
                let mut sum = (0.0, 0.0);
                for (j, (re, im)) in x.iter().enumerate() {
                    let (sin, cos) = (-std::f64::consts::TAU * (j * k) as f64 / fast.len() as f64).sin_cos();
                    sum = (sum.0 + re * cos - im * sin, sum.1 + re * sin + im * cos);
                }
                assert!((sum.0 - value.0).abs() < 1e-9 && (sum.1 - value.1).abs() < 1e-9, "{n}, bin {k}");
            }
        }
    }
}
