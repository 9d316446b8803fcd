//! PNI RM3100 (three sensor coils and a MagI2C): 24 bits, ±800 µT, 2 to 300 Hz.
//!
//! From the user manual: gains and rates by cycle count, register map, self-test; the bytes of the continuous mode, the rate and the
//! self-test as Linux and PX4 write them.
//!
//! | what | where |
//! |---|---|
//! | address | 0x20 to 0x23, by pins SA0 and SA1 |
//! | identity | REVID 0x36 = 0x22 |
//! | output | 0x24 to 0x2c, three bytes an axis, high byte first |
//! | status | STATUS 0x34, bit 7 DRDY |
//! | temperature | none |
//! | self-test | BIST 0x33, started by POLL 0x00: bits 6–4 for z, y, x |
//!
//! Counts are carried with [`Config::shift`] low bits left out, so that ±800 µT fit 16 bits; with 200 cycles that is one bit, 13
//! nT, below the chip's noise.

use super::description::{Chip, Identity, Write};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// All addresses, by the levels of pins SA0 and SA1.
pub const ADDRESSES: [u8; 4] = [0x20, 0x21, 0x22, 0x23];
/// Asks for a single measurement: bits 6–4, one an axis.
pub const POLL: u8 = 0x00;
/// Continuous measurements.
pub const CMM: u8 = 0x01;
/// The first of the six bytes of the cycle counts, high byte first.
pub const CC_X_H: u8 = 0x04;
/// The rate of continuous measurements.
pub const TMRC: u8 = 0x0b;
/// The first of the nine output bytes.
pub const OUT_X_2: u8 = 0x24;
/// Self-test.
pub const BIST: u8 = 0x33;
/// Bit 7: a set of data waits.
pub const STATUS: u8 = 0x34;
/// Who it is.
pub const REVID: u8 = 0x36;
/// What [`REVID`] reads.
pub const IDENTITY: u8 = 0x22;
/// [`CMM`]: all axes, started.
pub const CONTINUOUS: u8 = 0x71;
/// [`POLL`]: all axes.
pub const POLL_ALL: u8 = 0x70;
/// [`STATUS`]: a set of data waits.
pub const DRDY: u8 = 1 << 7;
/// [`BIST`]: test enabled, four periods, the longest time-out.
pub const BIST_START: u8 = 0x8f;

/// Cycles of an oscillation a measurement: more are finer and slower.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum CycleCount {
    C50,
    C100,
    /// 13 nT a count, 15 nT of noise.
    #[default]
    C200,
}

impl CycleCount {
    /// The number of cycles.
    pub const fn cycles(self) -> u8 {
        match self {
            CycleCount::C50 => 50,
            CycleCount::C100 => 100,
            CycleCount::C200 => 200,
        }
    }

    /// Counts per µT.
    pub const fn counts_per_ut(self) -> u8 {
        match self {
            CycleCount::C50 => 20,
            CycleCount::C100 => 38,
            CycleCount::C200 => 75,
        }
    }

    /// The most measurements of all three axes a second.
    pub const fn most_hz(self) -> f32 {
        match self {
            CycleCount::C50 => 533.0,
            CycleCount::C100 => 283.0,
            CycleCount::C200 => 147.0,
        }
    }

    /// The low bits to leave out so that ±800 µT fit 16 bits.
    pub const fn shift(self) -> u8 {
        match self {
            CycleCount::C50 | CycleCount::C100 => 0,
            CycleCount::C200 => 1,
        }
    }
}

/// Measurements a second ("about", says the manual).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz300,
    Hz150,
    #[default]
    Hz75,
    Hz37,
    Hz18,
    Hz9,
}

impl DataRate {
    /// The byte for [`TMRC`].
    pub const fn bits(self) -> u8 {
        0x93 + self as u8
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz300 => 300.0,
            DataRate::Hz150 => 150.0,
            DataRate::Hz75 => 75.0,
            DataRate::Hz37 => 37.0,
            DataRate::Hz18 => 18.0,
            DataRate::Hz9 => 9.0,
        }
    }
}

/// The whole configuration. The default: address 0x20, 200 cycles, 75 Hz, ±800 µT.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
    /// Cycles a measurement.
    pub cycles: CycleCount,
    /// Measurements a second.
    pub rate: DataRate,
    /// Low bits of the chip's counts that are left out. [`CycleCount::shift`] carries the whole range; less is finer, and a field
    /// beyond 32 767 counts is then out of range.
    pub shift: u8,
}

impl Default for Config {
    fn default() -> Self {
        let cycles = CycleCount::default();
        Self { address: ADDRESSES[0], cycles, rate: DataRate::default(), shift: cycles.shift() }
    }
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: REVID, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STATUS, DRDY);
    const OUTPUT: u8 = OUT_X_2;
    // Of the cycle count before.
    const DROPPED: u8 = 1;
    type Output = [u8; 9];
    type Writes = [Write; 9];

    fn address(&self) -> u8 {
        self.address
    }

    fn check(&self) -> Result<(), &'static str> {
        if self.rate.hz() > self.cycles.most_hz() {
            return Err(
                "RM3100: that many cycles take longer than the rate leaves: fewer cycles, or a lower rate",
            );
        }
        if self.shift > 8 {
            return Err("RM3100: more than 8 bits left out of 24: at most 8");
        }
        Ok(())
    }

    fn writes(&self) -> [Write; 9] {
        let cycles = self.cycles.cycles();
        [
            // A new rate is taken over when continuous measurements begin.
            Write::unread(CMM, 0),
            Write::kept(CC_X_H, 0),
            Write::kept(CC_X_H + 1, cycles),
            Write::kept(CC_X_H + 2, 0),
            Write::kept(CC_X_H + 3, cycles),
            Write::kept(CC_X_H + 4, 0),
            Write::kept(CC_X_H + 5, cycles),
            Write::kept(TMRC, self.rate.bits()),
            Write::kept(CMM, CONTINUOUS),
        ]
    }

    fn sensor(&self) -> Sensor {
        let shifted = f32::from(1_u16 << self.shift.min(8));
        Sensor {
            name: "RM3100",
            ut_per_count: [shifted / f32::from(self.cycles.counts_per_ut()); 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: i16::MAX as u16,
            bits: 24,
            shift: self.shift,
        }
    }

    fn decode(&self, &[x2, x1, x0, y2, y1, y0, z2, z1, z0]: &[u8; 9]) -> Reading {
        // Into the high bytes of a word and down again: the sign comes along.
        let wide =
            [[x2, x1, x0, 0], [y2, y1, y0, 0], [z2, z1, z0, 0]].map(|axis| i32::from_be_bytes(axis) >> 8);
        // The counter's end is no flag of the chip's, but nothing beyond the specified range is a measurement.
        let most = 800 * u32::from(self.cycles.counts_per_ut());
        Reading::carried(wide, self.shift, wide.map(|count| count.unsigned_abs() > most))
    }
}
