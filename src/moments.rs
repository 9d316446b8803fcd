//! The streaming accumulator: 34 exact integer sums and a count, from which every fit reads its normal matrix.
//!
//! The paper (Dong, Chou, Fang 2014, eqs. (13)–(15)) stacks one row per sample and solves `p̂ = (DᵀD)⁻¹DᵀĤ²`. All that
//! the samples contribute are the sums of the monomials `xⁱyʲzᵏ`, `i+j+k ≤ 4`. Magnetometers deliver integers, so the
//! sums are kept exactly: no drift, no dependence on order, and the same bits on the board and on the host. In `f32`
//! the same sums on raw counts are wrong by percents once the hard iron is larger than the field.

use crate::monomial::{self, at};

/// Bits kept in the low word of a 96-bit sum between carries.
///
/// A quartic of 16-bit counts is at most 2⁶⁰ in magnitude. With 61 bits left after a carry, six more samples reach at
/// most 2⁶¹ − 1 + 6·2⁶⁰ = 2⁶³ − 1, the largest `i64`. The high word then counts units of 2⁶¹: 2³¹ of them hold the
/// quartics of 2³² full-scale samples.
const LOW_BITS: u32 = 61;
const LOW_MASK: i64 = (1 << LOW_BITS) - 1;
/// Samples between two carries of the quartic sums.
const CARRY_EVERY: u8 = 6;
/// The cubic sums (45 bits a sample) are carried once in 65 536 samples, at a sample where the quartics are not.
const CUBIC_CARRY_PERIOD: u32 = 1 << 16;

const QUADRATICS: usize = 6;
const CUBICS: usize = 10;
const QUARTICS: usize = 15;

/// Which reading of the paper's eq. (14) a normal matrix is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Normalisation {
    /// The paper's nine columns of eq. (13), `[x² x y² y z² z xy zy xz]`, with the constant 1 on the left:
    /// `Ĥ²` of eq. (14) is the squared magnitude of the *true* field, a constant, less `bᵀQb`; scaled to 1.
    Constant,
    /// The columns `[x²+y²−2z², x²+z²−2y², 2xy, 2xz, 2yz, 2x, 2y, 2z, 1]` with the measured `x²+y²+z²` on the left:
    /// no singular position, and unchanged when the data are moved or rotated.
    Trace,
}

/// A normal matrix `DᵀD` (9×9) and right side `DᵀĤ²` (9) in counts, row and column order as in [`Normalisation`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NormalMatrix {
    /// `DᵀD`, symmetric, counts to the power of the two columns' degrees.
    pub dtd: [[f64; 9]; 9],
    /// `DᵀĤ²`.
    pub dth: [f64; 9],
}

/// Exact sums of all monomials up to degree four over a stream of 16-bit samples. 384 bytes.
///
/// ```
/// use ironout::moments::Moments;
/// let mut moments = Moments::new();
/// moments.push([120, -340, 55]);
/// moments.push([-20, 310, 45]);
/// assert_eq!(moments.count(), 2);
/// assert_eq!(moments.sum(1, 0, 0), Some(100)); // Σx
/// assert_eq!(moments.sum(2, 0, 0), Some(120 * 120 + 20 * 20)); // Σx²
/// ```
#[derive(Clone, Copy)]
pub struct Moments {
    quartic_low: [i64; QUARTICS],
    cubic_low: [i64; CUBICS],
    quadratic: [i64; QUADRATICS],
    linear: [i64; 3],
    quartic_high: [i32; QUARTICS],
    cubic_high: [i32; CUBICS],
    count: u32,
    since_carry: u8,
}

impl Default for Moments {
    fn default() -> Self {
        Self::new()
    }
}

/// `Σx` and `Σx²` on each axis, counts and counts².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct AxisSums {
    pub(crate) linear: [i64; 3],
    pub(crate) square: [i64; 3],
}

/// Adds to the places of an array.
macro_rules! add {
    ($sums:expr, [$($place:literal $value:expr),*]) => {
        $($sums[$place] += i64::from($value);)*
    };
}

impl Moments {
    /// Samples the sums hold without overflow, at full scale: 2³². One less is the limit of the counter.
    pub const CAPACITY: u32 = u32::MAX;

    /// An empty accumulator.
    pub const fn new() -> Self {
        Self {
            quartic_low: [0; QUARTICS],
            cubic_low: [0; CUBICS],
            quadratic: [0; QUADRATICS],
            linear: [0; 3],
            quartic_high: [0; QUARTICS],
            cubic_high: [0; CUBICS],
            count: 0,
            since_carry: 0,
        }
    }

    /// Adds one sample. At [`Self::CAPACITY`] further samples are left out, so the sums never wrap.
    #[inline(never)]
    pub fn push(&mut self, counts: [i16; 3]) {
        if self.count == Self::CAPACITY {
            return;
        }
        self.count += 1;
        let [x, y, z] = counts.map(i32::from);
        // (−32768)² = 2³⁰ fits an i32, so each quartic is one 32×32→64 multiply-accumulate.
        let long = |a: i32, b: i32| i64::from(a) * i64::from(b);
        let (xx, xy, xz, yy, yz, zz) = (x * x, x * y, x * z, y * y, y * z, z * z);
        // Written out, so that it is straight code also where the crate is compiled for size.
        add!(self.linear, [0 x, 1 y, 2 z]);
        add!(self.quadratic, [0 xx, 1 xy, 2 xz, 3 yy, 4 yz, 5 zz]);
        add!(self.cubic_low, [
            0 long(xx, x), 1 long(xx, y), 2 long(xx, z), 3 long(yy, x), 4 long(yz, x), 5 long(zz, x), 6 long(yy, y),
            7 long(yy, z), 8 long(zz, y), 9 long(zz, z)
        ]);
        add!(self.quartic_low, [
            0 long(xx, xx), 1 long(xx, xy), 2 long(xx, xz), 3 long(xx, yy), 4 long(xx, yz), 5 long(xx, zz),
            6 long(xy, yy), 7 long(xz, yy), 8 long(xy, zz), 9 long(xz, zz), 10 long(yy, yy), 11 long(yy, yz),
            12 long(yy, zz), 13 long(yz, zz), 14 long(zz, zz)
        ]);
        self.since_carry += 1;
        if self.since_carry >= CARRY_EVERY {
            self.carry_quartics();
        } else if self.count % CUBIC_CARRY_PERIOD < u32::from(CARRY_EVERY) {
            // One of six samples in a row: at least five of them are not carry samples of the quartics, so the
            // cubics are carried in time and the two never fall on one sample.
            self.carry_cubics();
        }
    }

    #[inline]
    fn carry_quartics(&mut self) {
        self.since_carry = 0;
        for (low, high) in self.quartic_low.iter_mut().zip(self.quartic_high.iter_mut()) {
            *high += (*low >> LOW_BITS) as i32;
            *low &= LOW_MASK;
        }
    }

    #[inline(never)]
    fn carry_cubics(&mut self) {
        for (low, high) in self.cubic_low.iter_mut().zip(self.cubic_high.iter_mut()) {
            *high += (*low >> LOW_BITS) as i32;
            *low &= LOW_MASK;
        }
    }

    /// Adds all samples of `other`; exact and associative. `false`, and nothing changed, if the sum of the counts
    /// exceeds [`Self::CAPACITY`].
    pub fn merge(&mut self, other: &Self) -> bool {
        let Some(count) = self.count.checked_add(other.count) else { return false };
        let mut other = *other;
        self.carry_quartics();
        self.carry_cubics();
        other.carry_quartics();
        other.carry_cubics();
        let add = |a: &mut [i64], b: &[i64]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        add(&mut self.quartic_low, &other.quartic_low);
        add(&mut self.cubic_low, &other.cubic_low);
        add(&mut self.quadratic, &other.quadratic);
        add(&mut self.linear, &other.linear);
        for (a, b) in self.quartic_high.iter_mut().zip(other.quartic_high) {
            *a += b;
        }
        for (a, b) in self.cubic_high.iter_mut().zip(other.cubic_high) {
            *a += b;
        }
        self.carry_quartics();
        self.carry_cubics();
        self.count = count;
        true
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// The sums of the counts and of their squares on each axis.
    pub(crate) const fn axis_sums(&self) -> AxisSums {
        let [xx, _, _, yy, _, zz] = self.quadratic;
        AxisSums { linear: self.linear, square: [xx, yy, zz] }
    }

    /// Number of samples.
    pub const fn count(&self) -> u64 {
        self.count as u64
    }

    /// The exact sum of `xⁱyʲzᵏ` over all samples, in counts to the power `i+j+k`; `None` above degree four.
    pub fn sum(&self, i: usize, j: usize, k: usize) -> Option<i128> {
        monomial::index(i, j, k).map(|position| self.sum_at(position))
    }

    fn sum_at(&self, position: usize) -> i128 {
        let wide = |low: i64, high: i32| (i128::from(high) << LOW_BITS) + i128::from(low);
        match position {
            0 => i128::from(self.count),
            1..=3 => i128::from(self.linear[position - 1]),
            4..=9 => i128::from(self.quadratic[position - 4]),
            10..=19 => wide(self.cubic_low[position - 10], self.cubic_high[position - 10]),
            20..=34 => wide(self.quartic_low[position - 20], self.quartic_high[position - 20]),
            _ => 0,
        }
    }

    /// All 35 sums, ordered as [`monomial::EXPONENTS`]; the first is the count.
    pub fn sums(&self) -> [i128; monomial::COUNT] {
        core::array::from_fn(|position| self.sum_at(position))
    }

    /// The accumulator with these sums, as [`Self::sums`] gives them: for sums that were sent from another process. `None` for sums that no
    /// samples have, as far as that shows in their size.
    pub fn from_sums(sums: &[i128; monomial::COUNT]) -> Option<Self> {
        let mut moments = Self { count: u32::try_from(sums[0]).ok()?, ..Self::new() };
        for (place, sum) in sums.iter().enumerate() {
            let (low, high) = ((*sum & i128::from(LOW_MASK)) as i64, i32::try_from(*sum >> LOW_BITS));
            match place {
                0 => {}
                1..=3 => moments.linear[place - 1] = i64::try_from(*sum).ok()?,
                4..=9 => moments.quadratic[place - 4] = i64::try_from(*sum).ok()?,
                10..=19 => {
                    (moments.cubic_low[place - 10], moments.cubic_high[place - 10]) = (low, high.ok()?);
                }
                _ => (moments.quartic_low[place - 20], moments.quartic_high[place - 20]) = (low, high.ok()?),
            }
        }
        let largest = i128::from(moments.count) << 60;
        sums.iter().all(|sum| sum.abs() <= largest).then_some(moments)
    }

    /// The paper's normal matrix `DᵀD` and right side `DᵀĤ²` (eq. (15)) of all samples so far, read off the sums.
    /// Each entry is the exact integer, rounded once to `f64`.
    pub fn normal_matrix(&self, normalisation: Normalisation) -> NormalMatrix {
        let sums = self.sums();
        let columns: &[Column; 9] = match normalisation {
            Normalisation::Constant => &CONSTANT_COLUMNS,
            Normalisation::Trace => &TRACE_COLUMNS,
        };
        let left: Column = match normalisation {
            Normalisation::Constant => &[(1, [0, 0, 0])],
            Normalisation::Trace => &[(1, [2, 0, 0]), (1, [0, 2, 0]), (1, [0, 0, 2])],
        };
        let product = |a: Column, b: Column| {
            let mut total = 0i128;
            for (ca, ea) in a {
                for (cb, eb) in b {
                    total += i128::from(ca * cb) * sums[at(ea[0] + eb[0], ea[1] + eb[1], ea[2] + eb[2])];
                }
            }
            total as f64
        };
        NormalMatrix {
            dtd: core::array::from_fn(|row| {
                core::array::from_fn(|column| product(columns[row], columns[column]))
            }),
            dth: core::array::from_fn(|row| product(columns[row], left)),
        }
    }
}

impl PartialEq for Moments {
    /// Equal sums, whatever the state of the carries.
    fn eq(&self, other: &Self) -> bool {
        self.sums() == other.sums()
    }
}

impl Eq for Moments {}

impl core::fmt::Debug for Moments {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Moments")
            .field("count", &self.count)
            .field("linear", &self.linear)
            .finish_non_exhaustive()
    }
}

/// A column of `D`: integer coefficients and exponents of its monomials.
type Column = &'static [(i64, [usize; 3])];

const CONSTANT_COLUMNS: [Column; 9] = [
    &[(1, [2, 0, 0])],
    &[(1, [1, 0, 0])],
    &[(1, [0, 2, 0])],
    &[(1, [0, 1, 0])],
    &[(1, [0, 0, 2])],
    &[(1, [0, 0, 1])],
    &[(1, [1, 1, 0])],
    &[(1, [0, 1, 1])],
    &[(1, [1, 0, 1])],
];

const TRACE_COLUMNS: [Column; 9] = [
    &[(1, [2, 0, 0]), (1, [0, 2, 0]), (-2, [0, 0, 2])],
    &[(1, [2, 0, 0]), (1, [0, 0, 2]), (-2, [0, 2, 0])],
    &[(2, [1, 1, 0])],
    &[(2, [1, 0, 1])],
    &[(2, [0, 1, 1])],
    &[(2, [1, 0, 0])],
    &[(2, [0, 1, 0])],
    &[(2, [0, 0, 1])],
    &[(1, [0, 0, 0])],
];

const _: () = assert!(core::mem::size_of::<Moments>() <= 400, "the accumulator's memory is a promise");

#[cfg(test)]
mod tests {
    use super::Moments;

    #[test]
    fn a_degree_that_is_not_kept_has_no_sum_however_large_it_is() {
        let mut moments = Moments::new();
        moments.push([3, -2, 1]);
        assert_eq!(moments.sum(2, 1, 1), Some(-18));
        for large in [3, 5, usize::MAX] {
            for [i, j, k] in [[large, 1, 1], [1, large, 1], [1, 1, large], [large, large, large]] {
                assert_eq!(moments.sum(i, j, k), None, "{i} {j} {k}");
            }
        }
    }
}
