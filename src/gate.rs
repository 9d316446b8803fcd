//! The sample gate: a resting board adds nothing, and a moving one loses none of its averaging.
//!
//! A board left on the table would otherwise drown the directions that matter under copies of one. A wide gate (a new
//! sample only every 8°, as some flight controllers have it) throws the averaging of a moving board away. So rest is
//! gated, not motion: samples are taken in short blocks, and a block is dropped only if its mean has not moved from the
//! last block kept, within what its own noise allows.

use crate::math;
use crate::moments::Moments;

/// A mean that moved less than this is rest whatever the noise says: 0.35° of a 50 µT field, µT.
const REST_FLOOR_UT: f64 = 0.3;
/// A block noisier than this (σ per axis) is never rest: no magnetometer is, but a tumbling board is, µT.
const MAX_REST_SIGMA_UT: f64 = 2.5;
/// 1 − 10⁻⁶ point of χ² with three degrees of freedom: an hour at rest has some ten thousand blocks, and one let through
/// by chance is an extreme of the noise, which pulls the fit and becomes the anchor of the next.
const CHI_SQUARE_3: f64 = 30.66;
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

/// Decides block by block whether the board moved. Pure: it sees means and variances, no samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestDetector {
    anchor_ut: Option<[f64; 3]>,
}

impl RestDetector {
    /// A detector that has seen nothing: the first block is motion.
    pub const fn new() -> Self {
        Self { anchor_ut: None }
    }

    /// Whether a block of `samples` samples with this mean (µT) and mean variance per axis (µT²) is motion. A block of
    /// motion becomes the one the next are compared with; rest does not, so that slow creeping is motion in the end.
    pub fn is_motion(&mut self, mean_ut: [f64; 3], variance_ut2: f64, samples: u64) -> bool {
        let rest = self.anchor_ut.is_some_and(|anchor| {
            let moved2: f64 = (0..3).map(|a| (mean_ut[a] - anchor[a]) * (mean_ut[a] - anchor[a])).sum();
            let noise2 = CHI_SQUARE_3 * 2.0 * variance_ut2 / samples.max(1) as f64;
            variance_ut2 <= MAX_REST_SIGMA_UT * MAX_REST_SIGMA_UT
                && moved2 <= noise2.max(REST_FLOOR_UT * REST_FLOOR_UT)
        });
        if !rest {
            self.anchor_ut = Some(mean_ut);
        }
        !rest
    }
}

/// What the gate did with a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gated {
    /// The block is not full yet.
    Pending,
    /// The block was motion and its samples were added.
    Added(u64),
    /// The block was rest and its samples were dropped.
    Dropped(u64),
}

/// The gate in front of a [`Moments`]: it collects a block in exact sums of its own and merges or forgets it whole, so
/// it keeps no samples.
#[derive(Clone, Debug)]
pub struct RestGate {
    detector: RestDetector,
    block: Moments,
    block_samples: u16,
    ut_per_count: [f64; 3],
}

impl RestGate {
    /// A gate for a sensor of this scale; see [`block_samples`] for the length.
    pub fn new(ut_per_count: [f64; 3], block_samples: u16) -> Self {
        Self {
            detector: RestDetector::new(),
            block: Moments::new(),
            block_samples: block_samples.max(2),
            ut_per_count,
        }
    }

    /// Takes one sample; a full block goes to `into` or is dropped.
    #[inline]
    pub fn push(&mut self, counts: [i16; 3], into: &mut Moments) -> Gated {
        self.block.push(counts);
        if self.block.count() < u64::from(self.block_samples) { Gated::Pending } else { self.close(into) }
    }

    /// Decides on a block that is not full yet: at the end of the collection.
    pub fn flush(&mut self, into: &mut Moments) -> Gated {
        if self.block.count() == 0 { Gated::Pending } else { self.close(into) }
    }

    /// Samples in the block that is not decided on yet.
    pub fn pending(&self) -> u64 {
        self.block.count()
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
        let motion = self.detector.is_motion(mean_ut, variance_ut2, n);
        let gated = if motion && into.merge(&self.block) { Gated::Added(n) } else { Gated::Dropped(n) };
        self.block.clear();
        gated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resting_board_adds_one_block_and_a_slow_one_everything() {
        let run = |degrees_per_sample: f64| {
            let mut gate = RestGate::new([0.1; 3], 16);
            let mut moments = Moments::new();
            for i in 0..1600u32 {
                let angle = f64::from(i) * degrees_per_sample.to_radians();
                // A field of 50 µT and a noise of ±2 counts that repeats with period 5 and 7.
                let wobble = |m: u32| f64::from(i % m) - f64::from(m - 1) / 2.0;
                let v = [500.0 * math::cos(angle) + wobble(5), 500.0 * math::sin(angle), 100.0 + wobble(7)];
                gate.push(v.map(|x| math::round(x) as i16), &mut moments);
            }
            gate.flush(&mut moments);
            moments.count()
        };
        assert_eq!(run(0.0), 16);
        // 5°/s at 50 Hz.
        assert_eq!(run(0.1), 1600);
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
