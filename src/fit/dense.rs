//! The two inner loops of the solves, out of line: on a board every double-precision operation is a call, so unrolled
//! copies would buy nothing and fill the flash.

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

/// Whether every number is finite.
#[inline(never)]
pub(crate) fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|v| v.to_bits() >> 52 & 0x7ff != 0x7ff)
}

/// Whether every number is finite.
#[inline(never)]
pub(crate) fn all_finite_f32(values: &[f32]) -> bool {
    values.iter().all(|v| v.to_bits() >> 23 & 0xff != 0xff)
}
