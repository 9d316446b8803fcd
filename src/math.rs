//! The one gateway to `libm`.
//!
//! Everything transcendental in this crate goes through here, by name, so that the board and the host run the same
//! code and give the same bits: glibc's functions differ from `libm`'s in the last place.

pub use crate::real::Real;
pub(crate) use crate::trig::power_of_two;

/// Square root in double precision; NaN for a negative argument.
#[inline]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// Square root in single precision; NaN for a negative argument.
#[inline]
pub fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Sine of an angle in radians.
#[inline]
pub fn sin(x: f64) -> f64 {
    crate::trig::sin_cos(x).0
}

/// Cosine of an angle in radians.
#[inline]
pub fn cos(x: f64) -> f64 {
    crate::trig::sin_cos(x).1
}

/// Sine and cosine of an angle in radians.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    crate::trig::sin_cos(x)
}

/// Arc cosine in radians; the argument is clamped to −1 … 1, so rounding never makes a NaN.
#[inline]
pub fn acos(x: f64) -> f64 {
    libm::acos(within(x, -1.0, 1.0))
}

/// Arc cosine in single precision, radians; the argument is clamped to −1 … 1.
#[inline]
pub fn acosf(x: f32) -> f32 {
    libm::acosf(x.clamp(-1.0, 1.0))
}

/// Arc sine in radians; the argument is clamped to −1 … 1, so rounding never makes a NaN.
#[inline]
pub fn asin(x: f64) -> f64 {
    libm::asin(within(x, -1.0, 1.0))
}

/// Angle of the vector `(x, y)` in radians, −π … π.
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Exponential function.
#[inline]
pub fn exp(x: f64) -> f64 {
    crate::trig::exp(x)
}

/// Nearest integer, ties away from zero.
#[inline]
pub fn round(x: f64) -> f64 {
    libm::round(x)
}

/// Largest integer not above `x`.
#[inline]
pub fn floor(x: f64) -> f64 {
    libm::floor(x)
}

/// Absolute value.
#[inline]
pub fn abs(x: f64) -> f64 {
    libm::fabs(x)
}

/// The nearest number from `least` to `most`; a NaN stays one. Unlike the standard library's it has no panic for limits in the wrong
/// order, which would bring the printing of numbers into every firmware.
#[inline(never)]
pub const fn within(x: f64, least: f64, most: f64) -> f64 {
    if x < least {
        least
    } else if x > most {
        most
    } else {
        x
    }
}

/// The eigenvalues of a symmetric 3×3 matrix, ascending, by the trigonometric formula: a fixed number of operations,
/// so it cannot fail to converge. The absolute error is some 1e-15 of the largest eigenvalue.
pub fn symmetric_eigenvalues_3x3(m: &[[f64; 3]; 3]) -> [f64; 3] {
    let mean = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
    let off = m[0][1] * m[0][1] + m[0][2] * m[0][2] + m[1][2] * m[1][2];
    let d = [m[0][0] - mean, m[1][1] - mean, m[2][2] - mean];
    let p2 = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + 2.0 * off) / 6.0;
    if p2 <= 0.0 {
        return [mean; 3];
    }
    let p = sqrt(p2);
    let det = d[0] * (d[1] * d[2] - m[1][2] * m[1][2]) - m[0][1] * (m[0][1] * d[2] - m[1][2] * m[0][2])
        + m[0][2] * (m[0][1] * m[1][2] - d[1] * m[0][2]);
    let phi = acos(det / (2.0 * p2 * p)) / 3.0;
    let high = mean + 2.0 * p * cos(phi);
    let low = mean + 2.0 * p * cos(phi + 2.0 * core::f64::consts::FRAC_PI_3);
    [low, 3.0 * mean - high - low, high]
}

/// The eigenvalues of a symmetric 3×3 matrix (entries 11, 12, 13, 22, 23, 33) in single precision, ascending, by cyclic
/// Jacobi rotations: what a gate needs, at a tenth of the price of [`symmetric_eigenvalues_3x3`] where double precision
/// is emulated. The absolute error is some 1e-6 of the largest eigenvalue; NaN for input that is not finite.
#[inline(never)]
pub fn eigenvalues_3x3_f32(m: &[f32; 6]) -> [f32; 3] {
    let mut d = [m[0], m[3], m[5]];
    // Off-diagonal entries, each named by the axis it leaves out.
    let mut off = [m[4], m[2], m[1]];
    // Four sweeps leave nothing: convergence is cubic. The axes take turns at being the first, which is left out.
    for _ in 0..12 {
        let ([first, mut p, mut q], [left_out, mut a, mut b]) = (d, off);
        if left_out != 0.0 {
            let theta = (q - p) / (2.0 * left_out);
            let magnitude = 1.0 / (theta.abs() + sqrtf(theta * theta + 1.0));
            let t = if theta < 0.0 { -magnitude } else { magnitude };
            let c = 1.0 / sqrtf(t * t + 1.0);
            let s = t * c;
            p -= t * left_out;
            q += t * left_out;
            // b couples p with the first axis, a couples q with it.
            (a, b) = (s * b + c * a, c * b - s * a);
            off[0] = 0.0;
        }
        (d, off) = ([p, q, first], [a, b, off[0]]);
    }
    let [mut low, mut middle, mut high] = d;
    if low > middle {
        (low, middle) = (middle, low);
    }
    if middle > high {
        (middle, high) = (high, middle);
    }
    if low > middle {
        (low, middle) = (middle, low);
    }
    [low, middle, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_eigenvalue_functions_agree() {
        for m in [
            [1.0, 0.0, 0.0, 1.0, 0.0, 1.0],
            [4.0, 1.0, -0.5, 2.0, 0.3, 0.7],
            [1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
            [0.3, 0.1, 0.2, 0.5, -0.25, 0.4],
            [1e-3, 2e-4, 0.0, 5.0, 1e-5, 40.0],
        ] {
            let [a, b, c, d, e, f] = m;
            let exact = symmetric_eigenvalues_3x3(&[[a, b, c], [b, d, e], [c, e, f]]);
            let single = eigenvalues_3x3_f32(&m.map(|v| v as f32));
            for (x, y) in exact.iter().zip(single) {
                assert!((x - f64::from(y)).abs() <= 2e-6 * exact[2], "{exact:?} {single:?}");
            }
        }
    }
}
