//! The tail of Fisher's F distribution.
//!
//! Our own rather than `statrs`': the board asks the same test as the host, and both get the same bits only where every function
//! comes from `libm` by name, or is written out.

use crate::math;

/// Probability that an F-distributed value on `(d1, d2)` degrees of freedom is at least `f`.
///
/// 1 where the arguments make no test (`f` not positive, fewer than one degree of freedom, NaN). The regularised
/// incomplete beta function by Lentz's continued fraction (Abramowitz and Stegun 26.5.8), relative error some 1e-12.
pub fn f_tail(f: f64, d1: f64, d2: f64) -> f64 {
    if f.is_nan() || f <= 0.0 || d1.is_nan() || d1 < 1.0 || d2.is_nan() || d2 < 1.0 {
        return 1.0;
    }
    if f.is_infinite() {
        return 0.0;
    }
    incomplete_beta(0.5 * d2, 0.5 * d1, d2 / (d2 + d1 * f))
}

/// `I_x(a, b)`.
fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    let log_front = ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * math::ln(x) + b * math::ln(1.0 - x);
    let front = math::exp(log_front);
    let value = if x < (a + 1.0) / (a + b + 2.0) {
        front * fraction(a, b, x) / a
    } else {
        1.0 - front * fraction(b, a, 1.0 - x) / b
    };
    math::within(value, 0.0, 1.0)
}

/// Natural logarithm of the gamma function of a number that is at least 1/2; relative error some 1e-14.
///
/// Stirling's series where it is good, by `Γ(x + 1) = x Γ(x)`: `libm`'s function for every number is three kilobytes on a board.
#[inline(never)]
fn ln_gamma(x: f64) -> f64 {
    const HALF_LN_TAU: f64 = 0.918_938_533_204_672_7;
    // B₂ₙ / (2n (2n − 1)), from the last to the first.
    const SERIES: [f64; 6] =
        [-691.0 / 360_360.0, 1.0 / 1188.0, -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0];
    let (mut x, mut below) = (x, 1.0);
    while x < 10.0 {
        below *= x;
        x += 1.0;
    }
    let square = 1.0 / (x * x);
    let rest = SERIES.iter().fold(0.0, |sum, term| sum * square + term) / x;
    (x - 0.5) * math::ln(x) - x + HALF_LN_TAU + rest - math::ln(below)
}

fn fraction(a: f64, b: f64, x: f64) -> f64 {
    let guard = |value: f64| if math::abs(value) < 1e-300 { 1e-300 } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / guard(1.0 - (a + b) * x / (a + 1.0));
    let mut result = d;
    for step in 1..500 {
        let m = f64::from(step);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / guard(1.0 + even * d);
        c = guard(1.0 + even / c);
        result *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / guard(1.0 + odd * d);
        c = guard(1.0 + odd / c);
        result *= d * c;
        if math::abs(d * c - 1.0) < 1e-14 {
            break;
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::f_tail;

    #[test]
    fn agrees_with_scipy() {
        // scipy.stats.f.sf, scipy 1.17.
        let cases = [
            (1.0, 3.0, 100.0, 0.396_186_249_618_006_5),
            (4.2, 3.0, 3000.0, 0.005_650_068_341_515_174),
            (25.0, 6.0, 40.0, 4.319_539_349_508_756_4e-12),
            (0.3, 1.0, 12.0, 0.593_924_092_107_765_2),
            (60.0, 3.0, 2500.0, 1.877_234_588_459_504_9e-37),
        ];
        for (f, d1, d2, expected) in cases {
            let got = f_tail(f, d1, d2);
            assert!((got / expected - 1.0_f64).abs() < 1e-9, "{f} {d1} {d2}: {got:e} against {expected:e}");
        }
    }

    #[test]
    fn the_logarithm_of_gamma_agrees_with_libm() {
        for halves in 1..20_000 {
            let x = 0.5 * f64::from(halves);
            let (got, expected) = (super::ln_gamma(x), libm::lgamma(x));
            assert!(
                (got - expected).abs() < 1e-14 * expected.abs().max(1.0),
                "{x}: {got} against {expected}"
            );
        }
    }

    #[test]
    fn no_test_is_no_evidence() {
        let no_tests = [
            (-1.0, 3.0, 10.0),
            (f64::NAN, 3.0, 10.0),
            (2.0, 0.0, 10.0),
            (2.0, 3.0, 0.5),
            (2.0, 3.0, f64::NAN),
        ];
        for (f, d1, d2) in no_tests {
            assert_eq!(f_tail(f, d1, d2), 1.0);
        }
        // One degree of freedom is enough: 1 − 2/π · atan √f.
        assert!((f_tail(1.0, 1.0, 1.0) - 0.5).abs() < 1e-9);
        assert_eq!(f_tail(f64::INFINITY, 3.0, 10.0), 0.0);
    }
}
