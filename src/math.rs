//! The one gateway to `libm`.
//!
//! Everything transcendental in this crate goes through here, by name, so that the board and the host run the same
//! code and give the same bits: glibc's functions differ from `libm`'s in the last place.

use nalgebra::RealField;

/// A scalar the core computes with: `f32` on the board's live path, `f64` for solves and on the host.
pub trait Real: RealField + Copy + 'static {
    /// The nearest value to `value`.
    fn of(value: f64) -> Self;
    /// The same value in double precision.
    fn as_f64(self) -> f64;
    /// Square root, correctly rounded; NaN for a negative argument.
    fn root(self) -> Self;
}

impl Real for f32 {
    #[inline]
    fn of(value: f64) -> Self {
        value as f32
    }
    #[inline]
    fn as_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline]
    fn root(self) -> Self {
        libm::sqrtf(self)
    }
}

impl Real for f64 {
    #[inline]
    fn of(value: f64) -> Self {
        value
    }
    #[inline]
    fn as_f64(self) -> f64 {
        self
    }
    #[inline]
    fn root(self) -> Self {
        libm::sqrt(self)
    }
}

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
    libm::sin(x)
}

/// Cosine of an angle in radians.
#[inline]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Arc cosine in radians; the argument is clamped to −1 … 1, so rounding never makes a NaN.
#[inline]
pub fn acos(x: f64) -> f64 {
    libm::acos(x.clamp(-1.0, 1.0))
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
    libm::exp(x)
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

/// Natural logarithm of the gamma function.
#[inline]
pub fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}
