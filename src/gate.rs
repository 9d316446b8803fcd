//! The sample gate: a resting board adds nothing, and a moving one loses none of its averaging.
//!
//! A board left on the table would otherwise drown the directions that matter under copies of one. A wide gate (a new
//! sample only every 8°, as some flight controllers have it) throws the averaging of a moving board away. So rest is
//! gated, not motion: samples are taken in short blocks, and blocks are dropped only if their means have not moved from the
//! last block kept, within what their own noise allows, for two seconds. With a noise of σ = 1 µT in 50 µT at 50 Hz, turning faster
//! than 1.2°/s loses nothing.

use crate::math;
use crate::moments::{AxisSums, Moments};

/// A mean that moved less than this is rest whatever the noise says: 0.35° of a 50 µT field, µT.
const REST_FLOOR_UT: f32 = 0.3;
/// A block noisier than this (σ per axis) is never rest: no magnetometer is, but a tumbling board is, µT.
const MAX_REST_SIGMA_UT: f32 = 2.5;
/// The chance that a block at rest passes for motion is 10⁻⁶: an hour at rest has some ten thousand blocks, and one let
/// through by chance is an extreme of the noise, which pulls the fit and becomes the anchor of the next. This is the point of
/// χ² with three degrees of freedom that is exceeded so rarely; see [`limit`].
const CHI_SQUARE_3: f32 = 30.665;
/// Fewest degrees of freedom that tell a variance: those of four samples on three axes.
const LEAST_FREEDOM: f32 = 9.0;
/// The variance at rest is that of the last so many blocks, more or less.
const BLOCKS_POOLED: f32 = 8.0;
/// Blocks (some two seconds) that a board may stay where it was before it counts as resting. A noisy sensor that turns
/// slowly needs a few blocks to show that it moved; they must not be lost.
const UNDECIDED_BLOCKS: u8 = 6;
/// Length of a block, seconds; [`block_samples`] turns it into samples.
pub const BLOCK_S: f64 = 0.32;

/// The number of samples of a block at a sampling rate in hertz: 0.32 s worth, 4 … 256. Without a rate: 16.
pub fn block_samples(rate_hz: f64) -> u16 {
    if rate_hz.is_finite() && rate_hz > 0.0 {
        // Rounds to the nearest: the cast cuts off.
        (math::within(BLOCK_S * rate_hz, 4.0, 256.0) + 0.5) as u16
    } else {
        16
    }
}

/// What a block is, seen beside the last block of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// It moved: it counts, and so do the undecided blocks before it, which were slow motion.
    Moved,
    /// It has not moved yet; it is held until it is clear whether the board rests.
    Undecided,
    /// The board rests: neither this block nor the undecided ones before it count.
    Rest,
}

/// How far apart two means of a resting sensor may be: the point that their squared distance over its estimated variance per
/// axis exceeds with a probability of at most 10⁻⁶, where that variance has so many degrees of freedom, nine or more.
///
/// The distance goes as χ² on three degrees only where the variance is known; estimated, it goes as three times Fisher's F on
/// `(3, freedom)`, whose tail is far longer: 230 instead of 30.7 for a single block of four samples. This is an upper bound of
/// its quantile, too high by at most 5 % (and by under 1 % from 27 degrees on). White noise, equal on the three axes.
fn limit(freedom: f32) -> f32 {
    CHI_SQUARE_3 * (1.0 + 14.95 / (freedom - 9.0 + 186.0 / (freedom * freedom)))
}

/// Decides block by block whether the board moved. Pure: it sees means and variances, no samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestDetector {
    anchor_ut: Option<[f32; 3]>,
    /// Squared deviations of the blocks since the anchor from their own means, µT², and how many of them are free.
    squares_ut2: f32,
    freedom: f32,
    undecided: u8,
}

impl RestDetector {
    /// A detector that has seen nothing: the first block is motion.
    pub const fn new() -> Self {
        Self { anchor_ut: None, squares_ut2: 0.0, freedom: 0.0, undecided: 0 }
    }

    /// What a block of `samples` samples with this mean (µT) and mean variance per axis (µT²) is. A block that moved becomes
    /// the one the next are compared with; rest does not, so that slow creeping is motion in the end.
    ///
    /// The noise is learned from all blocks since that one: the longer a board rests, the better it is known. A block that is
    /// noisier than they were is measured by its own noise.
    pub fn judge(&mut self, mean_ut: [f32; 3], variance_ut2: f32, samples: u32) -> Motion {
        let freedom = 3.0 * samples.saturating_sub(1) as f32;
        // What it was is forgotten slowly, since noise changes.
        let kept = if self.freedom > BLOCKS_POOLED * freedom { 1.0 - 1.0 / BLOCKS_POOLED } else { 1.0 };
        let squares_ut2 = kept * self.squares_ut2 + freedom * variance_ut2;
        let freedom = kept * self.freedom + freedom;
        let rest = self.anchor_ut.is_some_and(|anchor| {
            let moved2: f32 = (0..3).map(|a| (mean_ut[a] - anchor[a]) * (mean_ut[a] - anchor[a])).sum();
            let variance_ut2 = variance_ut2.max(squares_ut2 / freedom.max(1.0));
            let noise2 = limit(freedom) * 2.0 * variance_ut2 / samples.max(1) as f32;
            // The last samples of a log may be too few to say anything.
            variance_ut2 <= MAX_REST_SIGMA_UT * MAX_REST_SIGMA_UT
                && (moved2 <= noise2.max(REST_FLOOR_UT * REST_FLOOR_UT) || freedom < LEAST_FREEDOM)
        });
        if !rest {
            *self = Self { anchor_ut: Some(mean_ut), ..Self::new() };
            return Motion::Moved;
        }
        (self.squares_ut2, self.freedom) = (squares_ut2, freedom);
        if self.undecided < UNDECIDED_BLOCKS {
            self.undecided += 1;
            Motion::Undecided
        } else {
            Motion::Rest
        }
    }
}

/// What the gate did with a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gated {
    /// Not decided yet.
    Pending,
    /// The board moved, and the samples since the last decision were added.
    Added(u64),
    /// The board rests, and the samples since the last decision were dropped.
    Dropped(u64),
}

/// The gate in front of the sums: [`Moments`] of the samples in motion, and the same with those on which it is not decided
/// yet, so that it keeps no samples. A block that moved makes the one the other; a block at rest sets the other back.
#[derive(Clone, Debug)]
pub struct RestGate {
    decided: Moments,
    /// The decided ones, the held blocks, which are neither motion nor rest yet, and the open block.
    ahead: Moments,
    /// Sums of the counts and of their squares before the open block.
    before: AxisSums,
    detector: RestDetector,
    ut_per_count: [f32; 3],
    in_block: u16,
    block_samples: u16,
}

impl RestGate {
    /// A gate for a sensor of this scale; see [`block_samples`] for the length.
    pub fn new(ut_per_count: [f64; 3], block_samples: u16) -> Self {
        Self {
            decided: Moments::new(),
            ahead: Moments::new(),
            before: AxisSums::default(),
            detector: RestDetector::new(),
            ut_per_count: ut_per_count.map(|scale| scale as f32),
            in_block: 0,
            // With fewer, a block's own spread hides that it moved.
            block_samples: block_samples.max(4),
        }
    }

    /// Takes one sample; with a full block, it and what is held are added, held on, or dropped.
    #[inline]
    pub fn push(&mut self, counts: [i16; 3]) -> Gated {
        self.ahead.push(counts);
        self.in_block += 1;
        if self.in_block < self.block_samples { Gated::Pending } else { self.close() }
    }

    /// Decides on what is not decided yet, at the end of the collection: a pause that was too short to be rest was motion.
    pub fn flush(&mut self) -> Gated {
        let gated = if self.in_block == 0 { Gated::Pending } else { self.close() };
        if gated == Gated::Pending && self.pending() > 0 { self.add() } else { gated }
    }

    /// The sums of the samples in motion.
    pub const fn moments(&self) -> &Moments {
        &self.decided
    }

    /// Samples that are not decided on yet.
    pub const fn pending(&self) -> u64 {
        self.ahead.count() - self.decided.count()
    }

    /// Whether the last sample closed no block.
    pub const fn block_is_open(&self) -> bool {
        self.in_block > 0
    }

    fn add(&mut self) -> Gated {
        let n = self.pending();
        self.decided = self.ahead;
        Gated::Added(n)
    }

    /// One decision a block, in single precision: exact sums give its mean and its variance, each rounded once.
    #[inline(never)]
    fn close(&mut self) -> Gated {
        let sums = self.ahead.axis_sums();
        let n = i64::from(self.in_block);
        self.in_block = 0;
        let mut mean_ut = [0.0; 3];
        let mut variance_ut2 = 0.0;
        let per_sample = 1.0 / n as f32;
        let per_pair = per_sample / (n - 1).max(1) as f32 / 3.0;
        for axis in 0..3 {
            let scale = self.ut_per_count[axis];
            // Of fewer than 2¹⁶ counts the sum fits 32 bits, that of the squares 46, and n Σx² − (Σx)² 62.
            let sum = sums.linear[axis] - self.before.linear[axis];
            let square = sums.square[axis] - self.before.square[axis];
            mean_ut[axis] = sum as f32 * per_sample * scale;
            variance_ut2 += (n * square - sum * sum) as f32 * per_pair * scale * scale;
        }
        self.before = sums;
        match self.detector.judge(mean_ut, variance_ut2, n as u32) {
            Motion::Undecided => Gated::Pending,
            Motion::Moved => self.add(),
            Motion::Rest => {
                let n = self.pending();
                self.ahead = self.decided;
                self.before = self.ahead.axis_sums();
                Gated::Dropped(n)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fdist::f_tail;

    /// Samples of 1600 that pass, at a turning rate of `degrees_per_sample` and a noise of about `noise` counts.
    fn passed(degrees_per_sample: f64, noise: f64) -> u64 {
        let mut gate = RestGate::new([0.1; 3], 16);
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        // Four uniform numbers: near enough to a normal one of σ = √(4/12).
        let mut normal = || (uniform() + uniform() + uniform() + uniform()) * 1.732;
        for i in 0..1600u32 {
            let angle = f64::from(i) * degrees_per_sample.to_radians();
            let field = [500.0 * math::cos(angle), 500.0 * math::sin(angle), 100.0];
            gate.push(field.map(|v| math::round(v + noise * normal()) as i16));
        }
        gate.flush();
        gate.moments().count()
    }

    #[test]
    fn a_resting_board_adds_one_block_and_a_slow_one_everything() {
        for noise in [0.0, 0.3, 3.0, 10.0, 20.0] {
            assert_eq!(passed(0.0, noise), 16, "at rest, noise {noise} counts");
        }
        // At 50 Hz: 1°/s of a quiet sensor, 2°/s with 1 µT of noise, 5°/s with 2 µT.
        assert_eq!(passed(0.02, 1.0), 1600);
        assert_eq!(passed(0.04, 10.0), 1600);
        assert_eq!(passed(0.1, 20.0), 1600);
    }

    #[test]
    fn random_directions_are_motion() {
        let mut gate = RestGate::new([0.1; 3], 16);
        for i in 0..160i16 {
            let a = f64::from(i) * 2.4;
            gate.push([
                math::round(500.0 * math::cos(a)) as i16,
                math::round(500.0 * math::sin(a)) as i16,
                0,
            ]);
        }
        assert_eq!(gate.moments().count(), 160);
    }

    /// Normal numbers of a seed, by Box and Muller: the tails are what the tests are about.
    struct Normal(u64);

    impl Normal {
        fn next(&mut self) -> f32 {
            let mut uniform = || {
                self.0 =
                    self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                ((self.0 >> 12) as f64 + 0.5) / (1u64 << 52) as f64
            };
            let length = math::sqrt(-2.0 * math::ln(uniform()));
            (length * math::cos(core::f64::consts::TAU * uniform())) as f32
        }

        /// Mean and variance of a block at rest.
        fn block(&mut self, samples: u32, sigma_ut: f32) -> ([f32; 3], f32) {
            let mut variance = 0.0;
            let mean = core::array::from_fn(|_| {
                let (mut sum, mut squares) = (0.0, 0.0);
                for _ in 0..samples {
                    let value = sigma_ut * self.next();
                    sum += value;
                    squares += value * value;
                }
                variance += (squares - sum * sum / samples as f32) / (3.0 * (samples - 1) as f32);
                sum / samples as f32
            });
            (mean, variance)
        }
    }

    /// Resting blocks of 100 000 that pass for motion, each compared with one before it, or all in one long rest.
    fn passed_at_rest(samples: u32, sigma_ut: f32, long: bool) -> u32 {
        let mut normal = Normal(u64::from(samples) + 17);
        let mut detector = RestDetector::new();
        let mut passed = 0;
        for i in 0..100_000 {
            if i == 0 || !long {
                detector = RestDetector::new();
                let (mean, variance) = normal.block(samples, sigma_ut);
                assert_eq!(detector.judge(mean, variance, samples), Motion::Moved, "the first block");
            }
            let (mean, variance) = normal.block(samples, sigma_ut);
            passed += u32::from(detector.judge(mean, variance, samples) == Motion::Moved);
        }
        passed
    }

    #[test]
    fn of_a_hundred_thousand_resting_blocks_none_passes_whatever_their_length() {
        // The known-variance limit lets 295 of those of four samples pass. One of the eight runs may have one in 10⁵, as ten
        // in a million would, before it is worth a look.
        for samples in [4, 5, 8, 16] {
            let alone = passed_at_rest(samples, 1.0, false);
            let long = passed_at_rest(samples, 1.0, true);
            assert!(
                alone <= 1 && long <= 1,
                "{samples} samples a block: {alone} alone, {long} in a long rest"
            );
        }
    }

    #[test]
    fn the_limit_is_that_of_fishers_distribution() {
        for blocks in 1..=8 {
            for samples in [4, 5, 6, 8, 12, 16, 32, 100, 256] {
                let freedom = f64::from(3 * (samples - 1) * blocks);
                let chance = f_tail(f64::from(limit(freedom as f32)) / 3.0, 3.0, freedom);
                assert!((0.5e-6..=1.0e-6).contains(&chance), "{blocks} blocks of {samples}: {chance:e}");
            }
        }
    }

    #[test]
    fn a_moving_sensor_stands_out_of_a_rest_and_the_longer_it_lasted_the_sooner() {
        let step_ut = |rested: u32| {
            let mut detector = RestDetector::new();
            for _ in 0..=rested {
                detector.judge([0.0; 3], 1.0, 4);
            }
            // The least step along x that is motion.
            (1..200).map(|tenths| tenths as f32 * 0.1).find(|step| {
                let mut detector = detector;
                detector.judge([*step, 0.0, 0.0], 1.0, 4) == Motion::Moved
            })
        };
        let (soon, late) = (step_ut(1).unwrap_or(99.0), step_ut(8).unwrap_or(99.0));
        assert!(late < 5.0 && late < 0.8 * soon, "{soon} uT after one block, {late} uT after eight");
    }

    #[test]
    fn what_was_held_is_added_with_the_motion_after_it_and_dropped_with_rest() {
        let mut gate = RestGate::new([0.1; 3], 4);
        let push = |gate: &mut RestGate, x: i16| (0..4).map(|i| gate.push([x + i % 2, 0, 0])).last();
        assert_eq!(push(&mut gate, 100), Some(Gated::Added(4)));
        assert_eq!(push(&mut gate, 100), Some(Gated::Pending));
        assert_eq!((gate.moments().count(), gate.pending()), (4, 4));
        assert_eq!(push(&mut gate, 900), Some(Gated::Added(8)), "what was held was slow motion");
        for _ in 0..6 {
            assert_eq!(push(&mut gate, 900), Some(Gated::Pending));
        }
        assert_eq!(push(&mut gate, 900), Some(Gated::Dropped(28)));
        assert_eq!(push(&mut gate, 900), Some(Gated::Dropped(4)));
        assert_eq!(push(&mut gate, 100), Some(Gated::Added(4)));
        assert_eq!(gate.push([103, 0, 0]), Gated::Pending);
        assert_eq!(gate.flush(), Gated::Added(1));
        // Exactly these are in the sums: at 100, 100, 900, 100, each as x, x+1, x, x+1, and the last.
        assert_eq!(gate.moments().count(), 17);
        assert_eq!(gate.moments().sum(1, 0, 0), Some(4 * (100 + 100 + 900 + 100) + 8 + 103));
        assert_eq!(gate.pending(), 0);
    }
}
