//! The sample gate: a resting board adds nothing, and a moving one loses none of its averaging.
//!
//! A board left on the table would otherwise drown the directions that matter under copies of one. A wide gate (a new
//! sample only every 8°, as some flight controllers have it) throws the averaging of a moving board away. So rest is
//! gated, not motion: samples are taken in short blocks, and blocks are dropped only if their means have not moved from the
//! last block kept, within what their own noise allows, for two seconds. With a noise of σ = 1 µT in 50 µT at 50 Hz, turning faster
//! than 1.2°/s loses nothing.

use crate::math;
use crate::moments::Moments;

/// A mean that moved less than this is rest whatever the noise says: 0.35° of a 50 µT field, µT.
const REST_FLOOR_UT: f64 = 0.3;
/// A block noisier than this (σ per axis) is never rest: no magnetometer is, but a tumbling board is, µT.
const MAX_REST_SIGMA_UT: f64 = 2.5;
/// 1 − 10⁻⁶ point of χ² with three degrees of freedom: an hour at rest has some ten thousand blocks, and one let through
/// by chance is an extreme of the noise, which pulls the fit and becomes the anchor of the next.
const CHI_SQUARE_3: f64 = 30.66;
/// Blocks (some two seconds) that a board may stay where it was before it counts as resting. A noisy sensor that turns
/// slowly needs a few blocks to show that it moved; they must not be lost.
const UNDECIDED_BLOCKS: u8 = 6;
/// Length of a block, seconds; [`block_samples`] turns it into samples.
pub const BLOCK_S: f64 = 0.32;

/// The number of samples of a block at a sampling rate in hertz: 0.32 s worth, 4 … 256. Without a rate: 16.
pub fn block_samples(rate_hz: f64) -> u16 {
    if rate_hz.is_finite() && rate_hz > 0.0 {
        math::round(BLOCK_S * rate_hz).clamp(4.0, 256.0) as u16
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

/// Decides block by block whether the board moved. Pure: it sees means and variances, no samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestDetector {
    anchor_ut: Option<[f64; 3]>,
    undecided: u8,
}

impl RestDetector {
    /// A detector that has seen nothing: the first block is motion.
    pub const fn new() -> Self {
        Self { anchor_ut: None, undecided: 0 }
    }

    /// What a block of `samples` samples with this mean (µT) and mean variance per axis (µT²) is. A block that moved becomes
    /// the one the next are compared with; rest does not, so that slow creeping is motion in the end.
    pub fn judge(&mut self, mean_ut: [f64; 3], variance_ut2: f64, samples: u64) -> Motion {
        let rest = self.anchor_ut.is_some_and(|anchor| {
            let moved2: f64 = (0..3).map(|a| (mean_ut[a] - anchor[a]) * (mean_ut[a] - anchor[a])).sum();
            let noise2 = CHI_SQUARE_3 * 2.0 * variance_ut2 / samples.max(1) as f64;
            variance_ut2 <= MAX_REST_SIGMA_UT * MAX_REST_SIGMA_UT
                && moved2 <= noise2.max(REST_FLOOR_UT * REST_FLOOR_UT)
        });
        if !rest {
            self.anchor_ut = Some(mean_ut);
            self.undecided = 0;
            return Motion::Moved;
        }
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

/// The gate in front of a [`Moments`]: it collects blocks in exact sums of its own and merges or forgets them whole, so
/// it keeps no samples.
#[derive(Clone, Debug)]
pub struct RestGate {
    detector: RestDetector,
    block: Moments,
    /// Full blocks that are neither motion nor rest yet.
    held: Moments,
    block_samples: u16,
    ut_per_count: [f64; 3],
}

impl RestGate {
    /// A gate for a sensor of this scale; see [`block_samples`] for the length.
    pub fn new(ut_per_count: [f64; 3], block_samples: u16) -> Self {
        Self {
            detector: RestDetector::new(),
            block: Moments::new(),
            held: Moments::new(),
            // With fewer, a block's own spread hides that it moved.
            block_samples: block_samples.max(4),
            ut_per_count,
        }
    }

    /// Takes one sample; a full block goes to `into`, is held, or is dropped.
    #[inline]
    pub fn push(&mut self, counts: [i16; 3], into: &mut Moments) -> Gated {
        self.block.push(counts);
        if self.block.count() < u64::from(self.block_samples) { Gated::Pending } else { self.close(into) }
    }

    /// Decides on what is not decided yet, at the end of the collection: a pause that was too short to be rest was motion.
    pub fn flush(&mut self, into: &mut Moments) -> Gated {
        let waiting = self.pending();
        let first = if self.block.count() == 0 { Gated::Pending } else { self.close(into) };
        match first {
            Gated::Pending if waiting > 0 && into.merge(&self.held) => {
                self.held.clear();
                Gated::Added(waiting)
            }
            decided => decided,
        }
    }

    /// Samples that are not decided on yet.
    pub fn pending(&self) -> u64 {
        self.block.count() + self.held.count()
    }

    fn close(&mut self, into: &mut Moments) -> Gated {
        let n = self.block.count();
        let sums = self.block.sums();
        let mut mean_ut = [0.0; 3];
        let mut variance_ut2 = 0.0;
        for (axis, square) in [4usize, 7, 9].into_iter().enumerate() {
            let scale = self.ut_per_count[axis];
            mean_ut[axis] = sums[axis + 1] as f64 / n as f64 * scale;
            if n > 1 {
                // n Σx² − (Σx)² is exact; dividing the small difference loses nothing.
                let spread = (n as i128 * sums[square] - sums[axis + 1] * sums[axis + 1]) as f64;
                variance_ut2 += spread / (n as f64 * (n - 1) as f64) * scale * scale / 3.0;
            }
        }
        let motion = self.detector.judge(mean_ut, variance_ut2, n);
        // Blocks are far below the capacity, so that holding one always succeeds.
        self.held.merge(&self.block);
        self.block.clear();
        let n = self.held.count();
        let gated = match motion {
            Motion::Undecided => return Gated::Pending,
            Motion::Moved if into.merge(&self.held) => Gated::Added(n),
            Motion::Moved | Motion::Rest => Gated::Dropped(n),
        };
        self.held.clear();
        gated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of 1600 that pass, at a turning rate of `degrees_per_sample` and a noise of about `noise` counts.
    fn passed(degrees_per_sample: f64, noise: f64) -> u64 {
        let mut gate = RestGate::new([0.1; 3], 16);
        let mut moments = Moments::new();
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
            gate.push(field.map(|v| math::round(v + noise * normal()) as i16), &mut moments);
        }
        gate.flush(&mut moments);
        moments.count()
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
        let mut moments = Moments::new();
        for i in 0..160i16 {
            let a = f64::from(i) * 2.4;
            gate.push(
                [math::round(500.0 * math::cos(a)) as i16, math::round(500.0 * math::sin(a)) as i16, 0],
                &mut moments,
            );
        }
        assert_eq!(moments.count(), 160);
    }
}
