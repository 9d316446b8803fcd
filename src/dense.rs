//! The two inner loops of the solves, out of line: on a board every double-precision operation is a call, so unrolled
//! copies would buy nothing and fill the flash.

use crate::math;

/// `Σ aᵢbᵢ`, over the shorter of the two.
#[inline(never)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// `y ← y + a x`, over the shorter of the two.
#[inline(never)]
pub(crate) fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `y ← y + a x` in single precision, over the shorter of the two.
#[inline(never)]
pub(crate) fn add_scaled_f32(y: &mut [f32], a: f32, x: &[f32]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `y ← a y` in single precision.
#[inline(never)]
pub(crate) fn scale_f32(y: &mut [f32], a: f32) {
    for y in y {
        *y *= a;
    }
}

/// `Σ aᵢbᵢ` in single precision, over the shorter of the two.
#[inline(never)]
pub(crate) fn dot_f32(a: &[f32], b: &[f32]) -> f32 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// The number at a place, zero where there is none: an index that the compiler cannot follow brings no panic into the image.
#[inline(always)]
pub(crate) fn of<T: Copy + Default>(values: &[T], place: usize) -> T {
    values.get(place).copied().unwrap_or_default()
}

/// Puts a number in its place, for the same reason.
#[inline(always)]
pub(crate) fn put<T>(values: &mut [T], place: usize, value: T) {
    if let Some(slot) = values.get_mut(place) {
        *slot = value;
    }
}

/// Whether every number is finite.
#[inline(never)]
pub(crate) fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|v| v.to_bits() >> 52 & 0x7ff != 0x7ff)
}

/// Square root in double precision to a unit in the last place or two: a Newton step on the root in single precision, which
/// a Cortex-M4F has, where `libm`'s exact one is another half kilobyte. The caller keeps `x` within single precision's range.
#[inline(never)]
pub(crate) fn root(x: f64) -> f64 {
    let mut y = f64::from(math::sqrtf(x as f32));
    // Not where it has no root in single precision either.
    if y > 0.0 {
        // 1e-7, 1e-14, then rounding.
        for _ in 0..2 {
            y = 0.5 * (y + x / y);
        }
    }
    y
}

/// Natural logarithm of a positive number, to 0.06: exponent and mantissa of a float read as one number are a logarithm.
pub(crate) fn ln_f32(x: f32) -> f32 {
    (x.to_bits() as f32 / 8_388_608.0 - 126.957) * core::f32::consts::LN_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_is_as_good_as_double_precision_and_the_logarithm_as_said() {
        assert_eq!(root(0.0), 0.0);
        assert_eq!(root(1e-60), 0.0);
        for n in [1.0f32, 20.0, 777.0, 1e6, 4e9] {
            assert!((f64::from(ln_f32(n)) - math::ln(n.into())).abs() < 0.06, "{n}");
        }
        let mut x = 1.3e-30;
        while x < 1e30 {
            assert!((root(x) / math::sqrt(x) - 1.0).abs() < 5e-16, "{x}");
            x *= 1.37;
        }
    }
}
