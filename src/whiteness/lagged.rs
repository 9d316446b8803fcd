//! How much a quadric differs between two samples, for a quadric that is not known yet.
//!
//! `q(x) = (x−b)ᵀQ(x−b)` differs between the samples `x` and `x + Δ` by `ΔᵀQσ − 2(Qb)ᵀΔ` with `σ = 2x + Δ`: nine products of
//! the samples with nine coefficients. The sums of the products of these nine with each other give the mean square of the
//! difference for every quadric, once one is fitted. The constant has dropped out, and with it the hard iron's size: what
//! cancels is the motion between the two samples only.
//!
//! The 45 sums are 32-bit integers that share a scale, which grows with them: a sum keeps 27 bits and more, and rounding is
//! without bias. Noise of 0.05 % of the field shows through motion of a field between the two samples.

use crate::calibration::Calibration;
use crate::dense;
use crate::math::{self, power_of_two};

/// Products of nine with nine.
const SUMS: usize = 45;
/// Pairs after which every other one is left out from there on.
const MOST_PAIRS: u16 = 2048;
/// Bits of a scaled difference between two samples.
const DIFFERENCE_BITS: u32 = 28;
/// The sums are scaled down from here: another pair adds 2²⁸ at most.
const LARGE: i32 = 1 << 29;

/// Sums over pairs of samples a fixed lag apart.
#[derive(Clone, Debug)]
pub(super) struct Lagged {
    sums: [i32; SUMS],
    /// What the last product left below the sums' unit.
    left: u32,
    pairs: u16,
    /// A difference is counted in units of 2^−resolution.
    resolution: u8,
    /// The sum of two samples is counted in units of 2^unit.
    unit: u8,
    /// One of 2^thinning pairs is taken.
    thinning: u8,
}

/// What the sums say of a quadric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Differences {
    /// Mean square of the difference between two samples.
    pub mean_square: f64,
    /// What the rounding of the sums makes of that, 1σ.
    pub rounding: f64,
    /// Mean square of the difference between the gradients at the two, per µT².
    pub gradient2: f64,
    /// Pairs behind it.
    pub pairs: u16,
}

/// Adds the upper halves of products to the sums, in the order of the upper triangle. What is below, each leaves to the next:
/// as good as a random threshold of rounding, so that nothing adds up, and on a microcontroller one multiply-accumulate.
macro_rules! add_products {
    ($sums:expr, $left:expr, $v:expr, $([$i:literal; $($at:literal $j:literal),*])*) => {
        $( $(
            let sum = (i64::from($sums[$at]) << 32) + i64::from($left) + i64::from($v[$i]) * i64::from($v[$j]);
            $sums[$at] = (sum >> 32) as i32;
            $left = sum as u32;
        )* )*
    };
}

/// The upper half of a product, rounded.
#[inline(always)]
fn upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b) + 0x8000_0000) >> 32) as i32
}

/// Bits that the largest of three magnitudes takes.
#[inline(always)]
fn bits(x: i32, y: i32, z: i32) -> u32 {
    32 - (x.unsigned_abs() | y.unsigned_abs() | z.unsigned_abs()).leading_zeros()
}

impl Lagged {
    pub const fn new() -> Self {
        Self { sums: [0; SUMS], left: 1 << 31, pairs: 0, resolution: 24, unit: 4, thinning: 0 }
    }

    /// Pairs behind the sums; those before a thinning count half.
    #[cfg(test)]
    pub fn pairs(&self) -> u16 {
        self.pairs
    }

    /// Whether the pair with this number, counted from the start, is to be taken.
    #[inline]
    pub fn takes(&self, number: u16) -> bool {
        number & ((1 << self.thinning) - 1) == 0
    }

    /// Takes a pair, counts; `centre` is the same for all.
    #[inline(never)]
    pub fn push(&mut self, from: &[i16; 3], to: &[i16; 3], centre: &[i16; 3]) {
        // Written out, so that it is straight code also where the crate is compiled for size.
        let wide = |a: i16| i32::from(a);
        let (ax, ay, az) = (wide(from[0]), wide(from[1]), wide(from[2]));
        let (bx, by, bz) = (wide(to[0]), wide(to[1]), wide(to[2]));
        let (x, y, z) = (bx - ax, by - ay, bz - az);
        let (sx, sy, sz) =
            (bx + ax - 2 * wide(centre[0]), by + ay - 2 * wide(centre[1]), bz + az - 2 * wide(centre[2]));
        self.fit_scale(bits(x, y, z), bits(sx, sy, sz));
        // |difference| < 2²⁸ and |sum| < 2³¹, so that the upper half of their product is below 2²⁷.
        let (fine, wide) = (self.resolution & 31, 29 - (self.unit & 31).min(29));
        let (x, y, z) = (x << fine, y << fine, z << fine);
        let (sx, sy, sz) = (sx << wide, sy << wide, sz << wide);
        let v = [
            upper(x, sx) << 2,
            upper(y, sy) << 2,
            upper(z, sz) << 2,
            (upper(x, sy) + upper(y, sx)) << 2,
            (upper(x, sz) + upper(z, sx)) << 2,
            (upper(y, sz) + upper(z, sy)) << 2,
            x >> 1,
            y >> 1,
            z >> 1,
        ];
        let mut left = self.left;
        add_products!(self.sums, left, v,
            [0; 0 0, 1 1, 2 2, 3 3, 4 4, 5 5, 6 6, 7 7, 8 8]
            [1; 9 1, 10 2, 11 3, 12 4, 13 5, 14 6, 15 7, 16 8]
            [2; 17 2, 18 3, 19 4, 20 5, 21 6, 22 7, 23 8]
            [3; 24 3, 25 4, 26 5, 27 6, 28 7, 29 8]
            [4; 30 4, 31 5, 32 6, 33 7, 34 8]
            [5; 35 5, 36 6, 37 7, 38 8]
            [6; 39 6, 40 7, 41 8]
            [7; 42 7, 43 8]
            [8; 44 8]);
        self.left = left;
        self.pairs += 1;
        if self.pairs == MOST_PAIRS {
            self.pairs /= 2;
            self.thinning = (self.thinning + 1).min(15);
            self.scale_down(1, 0);
        }
    }

    /// Makes room for a pair, whose difference and sum take this many bits, and for what it adds.
    #[inline]
    fn fit_scale(&mut self, difference_bits: u32, sum_bits: u32) {
        let mut coarser = (difference_bits + u32::from(self.resolution)).saturating_sub(DIFFERENCE_BITS);
        // None is negative, and none reaches twice this.
        let s = &self.sums;
        if s[0] | s[9] | s[17] | s[24] | s[30] | s[35] | s[39] | s[42] | s[44] >= LARGE {
            coarser = coarser.max(1);
        }
        let wider = sum_bits.saturating_sub(u32::from(self.unit) + 2);
        if coarser > 0 || wider > 0 {
            // Both stay far within a byte: counts have 16 bits.
            self.resolution = self.resolution.saturating_sub(coarser as u8);
            self.unit += wider as u8;
            self.scale_down(2 * coarser, wider);
        }
    }

    /// Divides each sum by 2 to the power of `by`, rounded, and once more by 2 to the power of `wider` for each of its factors
    /// that is quadratic.
    #[inline(never)]
    fn scale_down(&mut self, by: u32, wider: u32) {
        let mut sums = self.sums.iter_mut();
        for row in 0..9u32 {
            let (quadratic, linear) = if row < 6 { (by + 2 * wider, by + wider) } else { (by, by) };
            // The columns first: they end before the sums do, and take none that belongs to the next row.
            for (column, sum) in (row..9).zip(&mut sums) {
                let by = if column < 6 { quadratic } else { linear }.min(31);
                // Below 2³⁰, so that half a unit more does not overflow.
                *sum = (*sum + ((1i32 << by >> 1) & i32::MAX)) >> by;
            }
        }
    }

    /// What the pairs say of the ellipsoid of `calibration`; `None` before there are any.
    pub fn of(&self, ellipsoid: &Weights) -> Option<Differences> {
        if self.pairs == 0 {
            return None;
        }
        let unit = power_of_two(self.unit.into());
        let scale = power_of_two(34 - i32::from(self.resolution))
            / power_of_two(self.resolution.into())
            / f64::from(self.pairs);
        let mut weights = ellipsoid.difference;
        weights.iter_mut().take(6).for_each(|weight| *weight *= unit);
        let (mut mean_square, mut gradient2) = (0.0, 0.0);
        let (mut squares, mut fourths) = (0.0, 0.0);
        let mut sums = self.sums.iter();
        for (row, weight) in weights.iter().enumerate() {
            let mut along = 0.0;
            // The columns first: they end before the sums do, and take none that belongs to the next row.
            for ((column, weight), sum) in weights.iter().enumerate().skip(row).zip(&mut sums) {
                let sum = f64::from(*sum) * if column == row { 1.0 } else { 2.0 };
                along += weight * sum;
                if row >= 6 {
                    let gradient =
                        ellipsoid.gradient.get(row - 6).map_or(0.0, |row| dense::of(row, column - 6));
                    gradient2 += gradient * sum;
                }
            }
            mean_square += weight * along;
            let square = (weight * weight) as f32;
            squares += square;
            fourths += square * square;
        }
        mean_square *= scale;
        gradient2 *= scale;
        // Rounding at random has a variance of a sixth on average; sums off the diagonal count twice.
        let rounding2 = (2.0 * squares * squares - fourths) * f32::from(self.pairs) / 6.0;
        let rounding = scale * f64::from(math::sqrtf(rounding2));
        Some(Differences { mean_square, rounding, gradient2, pairs: self.pairs })
    }
}

/// `MᵀM`.
#[inline(never)]
fn squared(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut product = [[0.0; 3]; 3];
    for from in m {
        for (row, a) in product.iter_mut().zip(from) {
            dense::add_scaled(row, *a, from);
        }
    }
    product
}

/// The quadric `‖C(x−b)‖²/F² − 1` of a calibration, over differences of counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// Of the nine products, in the order of [`Lagged::push`].
    difference: [f64; 9],
    /// Of the products of the difference with itself in the square of the difference of the gradients, per µT².
    gradient: [[f64; 3]; 3],
}

impl Weights {
    /// For counts about `centre`; `ut_per_count` is the scale of each axis.
    pub fn of(calibration: &Calibration<f64>, ut_per_count: [f64; 3], centre: [i16; 3]) -> Self {
        let f2 = calibration.field_ut * calibration.field_ut;
        // Q = CᵀC/F², µT⁻².
        let mut q = squared(&calibration.matrix);
        for entry in q.iter_mut().flatten() {
            *entry /= f2;
        }
        let off_ut: [f64; 3] =
            core::array::from_fn(|i| calibration.offset_ut[i] - f64::from(centre[i]) * ut_per_count[i]);
        let mut of_counts = q;
        for (row, own) in of_counts.iter_mut().zip(ut_per_count) {
            for (entry, other) in row.iter_mut().zip(ut_per_count) {
                *entry = *entry * own * other;
            }
        }
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = of_counts;
        let mut difference = [xx, yy, zz, xy, xz, yz, 0.0, 0.0, 0.0];
        for ((linear, row), own) in difference.iter_mut().skip(6).zip(&q).zip(ut_per_count) {
            *linear = -2.0 * own * dense::dot(row, &off_ut);
        }
        // The gradient is 2Q(x−b).
        let mut gradient = squared(&q);
        for (row, own) in gradient.iter_mut().zip(ut_per_count) {
            for (entry, other) in row.iter_mut().zip(ut_per_count) {
                *entry *= 4.0 * own * other;
            }
        }
        Self { difference, gradient }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers, −1 … 1.
    fn uniform(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    }

    /// The sums' answers over the exact ones, for samples `step` rad apart of a field of `field` counts and noise of `noise`
    /// fields.
    fn over_exact(field: f64, step: f64, noise: f64, pairs: usize, offset: [f64; 3]) -> [f64; 3] {
        let cal = Calibration {
            offset_ut: offset.map(|b| b * 50.0),
            matrix: [[1.1, 0.1, -0.05], [0.0, 0.95, 0.07], [0.0, 0.0, 1.0]],
            field_ut: 50.0,
        };
        let scale = 50.0 / field;
        let mut state = 7;
        let mut sample = |angle: f64| {
            let (tilt, turn) = (0.37 * angle, angle);
            let h = [
                crate::math::cos(tilt) * crate::math::cos(turn),
                crate::math::cos(tilt) * crate::math::sin(turn),
                crate::math::sin(tilt),
            ]
            .map(|h| 50.0 * (h + 1.7 * noise * uniform(&mut state)));
            let x = cal.distort(h).expect("it is regular");
            x.map(|x| crate::math::round(x / scale) as i16)
        };
        let mut lagged = Lagged::new();
        let centre = sample(0.0);
        let q = |x: [i16; 3]| {
            let corrected = cal.apply(x.map(|x| f64::from(x) * scale));
            corrected.iter().map(|h| h * h).sum::<f64>() / 2500.0 - 1.0
        };
        let (mut square, mut gradient2, mut n) = (0.0, 0.0, 0.0);
        for i in 0..pairs {
            let angle = 0.21 * i as f64;
            let (from, to) = (sample(angle), sample(angle + step));
            if !lagged.takes(i as u16) {
                continue;
            }
            let before = lagged.thinning;
            lagged.push(&from, &to, &centre);
            square += (q(to) - q(from)) * (q(to) - q(from));
            let moved = core::array::from_fn(|a| cal.offset_ut[a] + f64::from(to[a] - from[a]) * scale);
            let along = cal.apply(moved);
            let c = &cal.matrix;
            let change: [f64; 3] = core::array::from_fn(|j| (0..3).map(|i| 2.0 * c[i][j] * along[i]).sum());
            gradient2 += change.iter().map(|g| g * g).sum::<f64>() / 2500.0 / 2500.0;
            n += 1.0;
            if lagged.thinning > before {
                // What came before counts half from here on.
                (square, gradient2, n) = (0.5 * square, 0.5 * gradient2, 0.5 * n);
            }
        }
        let found = lagged.of(&Weights::of(&cal, [scale; 3], centre)).expect("there are pairs");
        let square = square / n;
        [found.mean_square / square, found.rounding / square, found.gradient2 / (gradient2 / n)]
    }

    #[test]
    fn the_mean_square_of_any_quadric_comes_out_of_the_sums() {
        for (field, step, noise, pairs, tolerance) in [
            (500.0, 0.02, 0.01, 500, 1e-4),
            (330.0, 0.02, 0.001, 300, 1e-3),
            (5000.0, 0.14, 0.0005, 1000, 0.01),
            (500.0, 1.0, 0.001, 1000, 0.06),
            (500.0, 1.0, 0.001, 2100, 0.25),
            (500.0, 1.0, 0.001, 40_000, 0.25),
            (3000.0, 0.3, 0.0005, 30_000, 0.2),
            (3000.0, 2.0, 0.01, 1000, 1e-2),
        ] {
            for offset in [[0.0; 3], [4.0, -3.0, 2.0]] {
                let [square, rounding, gradient2] = over_exact(field, step, noise, pairs, offset);
                let what = format_args!("{field} counts, {step} rad, noise {noise}, {offset:?}");
                assert!((square - 1.0).abs() < 4.0 * rounding, "{what}: {square} {rounding}");
                assert!(rounding < tolerance, "{what}: {rounding}");
                // Before the thinning every pair counts the same.
                assert!((gradient2 - 1.0).abs() < 1e-3, "{what}: {gradient2}");
            }
        }
    }

    #[test]
    fn the_ends_of_the_range_do_not_overflow() {
        let mut lagged = Lagged::new();
        for i in 0..20_000u16 {
            let (low, high) = (i16::MIN, i16::MAX);
            let [from, to] = if i % 2 == 0 { [low, high] } else { [high, low] };
            lagged.push(&[from; 3], &[to, 0, i as i16], &[low; 3]);
        }
        // The squares of the differences, row by row.
        for at in [0, 9, 17, 24, 30, 35, 39, 42, 44] {
            assert!(lagged.sums[at] > 0, "{at}: {lagged:?}");
        }
        assert!(lagged.sums.iter().all(|sum| sum.abs() < 2 * LARGE), "{lagged:?}");
    }
}
