//! The one gateway to the Fourier transform, which is `rustfft`'s.

use rustfft::FftPlannerScalar;
pub use rustfft::num_complex::Complex;
use std::cell::RefCell;

thread_local! {
    /// Plans of the lengths so far. The scalar planner: a vector unit would give other last digits on other hosts.
    static PLANS: RefCell<FftPlannerScalar<f64>> = RefCell::new(FftPlannerScalar::new());
    static SINGLE_PLANS: RefCell<FftPlannerScalar<f32>> = RefCell::new(FftPlannerScalar::new());
}

/// Transforms in place, `Σ x_j e^(−2πi jk/n)`, real and imaginary part in pairs; not normalised. Any length will do; products
/// of small primes are fast.
pub fn forward(data: &mut [(f64, f64)]) {
    let mut values: Vec<Complex<f64>> = data.iter().map(|&(re, im)| Complex::new(re, im)).collect();
    PLANS.with_borrow_mut(|plans| plans.plan_fft_forward(values.len())).process(&mut values);
    for (slot, value) in data.iter_mut().zip(values) {
        *slot = (value.re, value.im);
    }
}

/// Powers `|Σ z_j e^(−2πi jk/n)|²` of a series in single precision, for long series in which only the places of the peaks matter. In place,
/// in half the room.
pub fn powers(mut values: Vec<Complex<f32>>) -> impl Fn(usize) -> f64 {
    SINGLE_PLANS.with_borrow_mut(|plans| plans.plan_fft_forward(values.len())).process(&mut values);
    move |bin| f64::from(values[bin].norm_sqr())
}

#[cfg(test)]
mod tests {
    use super::{Complex, forward, powers};

    #[test]
    fn equals_the_sum_it_stands_for() {
        for n in [0, 1, 24, 32] {
            let x: Vec<(f64, f64)> = (0..n).map(|i| ((f64::from(i) * 0.7).sin(), f64::from(i % 5))).collect();
            let mut fast = x.clone();
            forward(&mut fast);
            for (k, value) in fast.iter().enumerate() {
                let mut sum = (0.0, 0.0);
                for (j, (re, im)) in x.iter().enumerate() {
                    let (sin, cos) = (-std::f64::consts::TAU * (j * k) as f64 / f64::from(n)).sin_cos();
                    sum = (sum.0 + re * cos - im * sin, sum.1 + re * sin + im * cos);
                }
                assert!((sum.0 - value.0).abs() < 1e-9 && (sum.1 - value.1).abs() < 1e-9, "{n}, bin {k}");
                let single = x.iter().map(|v| Complex::new(v.0 as f32, v.1 as f32)).collect();
                let (power, exact) = (powers(single)(k), sum.0 * sum.0 + sum.1 * sum.1);
                assert!((power - exact).abs() < 1e-3, "{n}, bin {k}: {power} {exact}");
            }
        }
    }
}
