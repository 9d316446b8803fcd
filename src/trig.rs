//! Sine and cosine, in a quarter of the flash that `libm`'s take: that one reduces arguments of any size exactly, with two kilobytes
//! of code for those beyond 10⁶ rad. And the exponential function in half of the flash: with `libm`'s bits, where it neither overflows
//! nor loses bits.
//!
//! The kernels and the reductions are FreeBSD's (`k_sin.c`, `k_cos.c`, `e_rem_pio2.c`, `e_exp.c`):
//! Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at SunPro, a Sun Microsystems, Inc. business.
//! Permission to use, copy, modify, and distribute this software is freely granted, provided that this notice is preserved.

use core::f64::consts::{FRAC_2_PI, LOG2_E};

/// A number to which adding rounds to the nearest integer.
const TO_INTEGER: f64 = 1.5 / f64::EPSILON;
/// π/2 as three numbers of 33 bits, and what is left after each.
const PARTS: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_711_166_5e-21];
const LEFT: [f64; 3] = [6.077_100_506_506_192e-11, 2.022_266_248_795_950_6e-21, 8.478_427_660_368_9e-32];
/// Quarter turns up to which their product with the first part is exact.
const MOST_QUARTERS: f64 = 1_048_576.0;

/// From the highest power to the lowest.
const SINE: [f64; 6] = [
    1.589_690_995_211_55e-10,
    -2.505_076_025_340_686_3e-8,
    2.755_731_370_707_006_8e-6,
    -1.984_126_982_985_795e-4,
    8.333_333_333_322_49e-3,
    -1.666_666_666_666_663_2e-1,
];
const COSINE: [f64; 6] = [
    -1.135_964_755_778_819_5e-11,
    2.087_572_321_298_175e-9,
    -2.755_731_435_139_066_3e-7,
    2.480_158_728_947_673e-5,
    -1.388_888_888_887_411e-3,
    4.166_666_666_666_66e-2,
];

/// `x (eˣ + 1)/(eˣ − 1) = 2 + x²(…)`.
const EXPONENTIAL: [f64; 5] = [
    4.138_136_797_057_238_5e-8,
    -1.653_390_220_546_525_2e-6,
    6.613_756_321_437_934e-5,
    -2.777_777_777_701_559_3e-3,
    1.666_666_666_666_660_2e-1,
];
/// ln 2 as two numbers: products of the first with an exponent are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// Exponent of a number as its bits have it.
fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 & 0x7ff
}

#[inline(never)]
fn horner(z: f64, coefficients: &[f64]) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * z + coefficient)
}

/// Sine and cosine of an angle in radians, to a unit in the last place up to 10⁶ rad; beyond, to what a rounding of the angle
/// makes of them. NaN for what is not finite.
#[inline(never)]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    let mut x = angle;
    let mut quarters = x * FRAC_2_PI;
    while quarters.abs() >= MOST_QUARTERS {
        // Whole multiples of 2²⁰ quarter turns change neither function.
        let whole = (quarters * (1.0 / MOST_QUARTERS) + TO_INTEGER - TO_INTEGER) * MOST_QUARTERS;
        let less = x - whole * PARTS[0] - whole * LEFT[0];
        if !(less.abs() < x.abs()) {
            return (f64::NAN, f64::NAN);
        }
        x = less;
        quarters = x * FRAC_2_PI;
    }
    let n = quarters + TO_INTEGER - TO_INTEGER;
    let mut rest = x - n * PARTS[0];
    let mut low = n * LEFT[0];
    let mut y = rest - low;
    // Where the angle is near a multiple, more bits of π count.
    for (lost_bits, (part, left)) in [16, 49].into_iter().zip(PARTS.iter().zip(&LEFT).skip(1)) {
        if exponent(x) - exponent(y) <= lost_bits {
            break;
        }
        let before = rest;
        low = n * part;
        rest = before - low;
        low = n * left - ((before - rest) - low);
        y = rest - low;
    }
    let tail = (rest - y) - low;
    let z = y * y;
    let cube = z * y;
    // All but the lowest term of the sine apart, for the sake of its last bit.
    let (first, others) = (SINE[5], horner(z, &SINE) - SINE[5]);
    let sine = y - ((z * 0.5 * tail - cube * others - tail) - cube * first);
    let half = 0.5 * z;
    let main = 1.0 - half;
    let cosine = main + (((1.0 - main) - half) + (z * z * horner(z, &COSINE) - y * tail));
    match n as i32 & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// 2 to the power of an exponent from −1022 to 1023: written as bits.
#[inline]
pub(crate) const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Exponential function: infinite where it overflows, 0 where it underflows, NaN of NaN.
#[inline(never)]
pub fn exp(x: f64) -> f64 {
    // Beyond, it is what it is there.
    let x = x.clamp(-746.0, 710.0);
    let doublings = (x * LOG2_E + 0.5_f64.copysign(x)) as i32;
    let whole = f64::from(doublings);
    let (high, low) = (x - whole * LN_2[0], whole * LN_2[1]);
    let rest = high - low;
    let square = rest * rest;
    let c = rest - square * horner(square, &EXPONENTIAL);
    let y = 1.0 + (rest * c / (2.0 - c) - low + high);
    // In two steps: the whole power may have no number, where the product has one.
    let half = doublings >> 1;
    y * power_of_two(half) * power_of_two(doublings - half)
}

#[cfg(test)]
mod tests {
    use super::{exp, sin_cos};

    #[test]
    fn the_exponential_function_has_the_bits_of_libm() {
        for i in -700_000..700_000 {
            let x = f64::from(i) * 1e-3;
            assert_eq!(exp(x).to_bits(), libm::exp(x).to_bits(), "{x}");
            let x = x * 1.7e-7;
            assert_eq!(exp(x).to_bits(), libm::exp(x).to_bits(), "{x}");
        }
        for (x, exact) in [(-800.0, 0.0), (f64::NEG_INFINITY, 0.0), (0.0, 1.0), (800.0, f64::INFINITY)] {
            assert_eq!(exp(x), exact, "{x}");
        }
        assert!(exp(f64::NAN).is_nan());
        assert!((exp(-744.0) / libm::exp(-744.0) - 1.0).abs() < 0.5, "few bits are left");
    }

    #[test]
    fn agrees_with_libm_to_the_last_place() {
        let mut worst = 0.0_f64;
        let mut check = |x: f64, tolerance: f64| {
            let (sine, cosine) = sin_cos(x);
            for (got, expected) in [(sine, libm::sin(x)), (cosine, libm::cos(x))] {
                let error = (got - expected).abs();
                worst = worst.max(error);
                assert!(error <= tolerance, "{x}: {got:e} against {expected:e}");
            }
        };
        for i in -200_000..200_000 {
            let x = f64::from(i) * 1e-4;
            check(x, 2.3e-16);
            check(x * 7919.0, 2.3e-16);
            // Multiples of a quarter turn, where all of it cancels.
            check(f64::from(i) * core::f64::consts::FRAC_PI_2, 2.3e-16);
        }
        for x in [3e6, -1e8, 1e9] {
            check(x, 1e-6 * 1e-6 * x.abs());
        }
        assert!(worst > 0.0, "two texts that differ do so in some last place");
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (sine, cosine) = sin_cos(x);
            assert!(sine.is_nan() && cosine.is_nan());
        }
        // Ends for every angle.
        assert!(sin_cos(1e300).0.is_nan() || sin_cos(1e300).0.abs() <= 1.0);
    }
}
