//! Self-tests as data: what to write, and which answer of the chip is a good one.

use super::description::Write;

/// What a good answer is, in counts along each of the chip's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Good {
    /// The measurement with the test's field, less the one without it, has a magnitude between these, of either sign.
    Step([(i32, i32); 3]),
    /// The measurement itself is between these.
    Level([(i32, i32); 3]),
    /// With the test on the outputs are those without it turned around, to this many counts.
    Inverted(i32),
}

/// A self-test of a chip that is a [`Chip`](super::description::Chip).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plan<W> {
    /// The configuration it is done in.
    pub before: W,
    /// What starts it, after the measurements without it.
    pub start: Write,
    /// How long the chip takes to settle after either, ms.
    pub settling_ms: u32,
    /// Measurements that are averaged; one more is taken before and dropped, except for a [`Good::Level`], which is one.
    pub samples: u8,
    /// The longest time to wait for one measurement, ms.
    pub patience_ms: u32,
    /// What is good.
    pub good: Good,
}

/// A chip with a self-test.
pub trait SelfTest: super::description::Chip {
    /// How it is done.
    fn plan(&self) -> Plan<Self::Writes>;
}

/// What came of a self-test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// The answer on every axis is as the datasheet wants it.
    Passed {
        /// The answer in counts of the chip.
        counts: [i32; 3],
    },
    /// An axis answers too little, too much, or not at all.
    Failed {
        /// The answer in counts of the chip.
        counts: [i32; 3],
        /// Which axes are good.
        good: [bool; 3],
    },
    /// The chip answers on the bus but did not measure in time.
    NoData,
}

impl Outcome {
    /// Whether the test was passed.
    pub fn passed(&self) -> bool {
        matches!(self, Outcome::Passed { .. })
    }

    /// The outcome of these answers.
    pub fn of(counts: [i32; 3], good: [bool; 3]) -> Self {
        if good == [true; 3] { Outcome::Passed { counts } } else { Outcome::Failed { counts, good } }
    }
}

impl Good {
    /// The outcome of the mean counts without and with the test's field.
    pub fn judge(self, without: [i32; 3], with: [i32; 3]) -> Outcome {
        let [[ax, ay, az], [bx, by, bz]] = [without, with];
        let pairs = [(ax, bx), (ay, by), (az, bz)];
        match self {
            Good::Step([x, y, z]) => {
                let counts = pairs.map(|(without, with)| with.saturating_sub(without));
                let within =
                    |count: i32, (least, most): (i32, i32)| (least..=most).contains(&count.saturating_abs());
                let [cx, cy, cz] = counts;
                Outcome::of(counts, [within(cx, x), within(cy, y), within(cz, z)])
            }
            Good::Level([x, y, z]) => {
                let within = |count: i32, (least, most): (i32, i32)| (least..=most).contains(&count);
                Outcome::of(with, [within(bx, x), within(by, y), within(bz, z)])
            }
            Good::Inverted(most) => {
                let counts = pairs.map(|(without, with)| with.saturating_add(without));
                Outcome::of(counts, counts.map(|sum| sum.saturating_abs() <= most))
            }
        }
    }
}
