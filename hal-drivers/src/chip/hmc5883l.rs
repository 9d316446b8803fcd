//! Honeywell HMC5883L: 12 bits, ±0.88 to ±8.1 G, 0.75 to 75 Hz.
//!
//! From the datasheet (900405 Rev E): registers table 2, rates table 5, gains table 9, self-test section "Self test operation".
//!
//! | what | where |
//! |---|---|
//! | address | 0x1e |
//! | identity | registers 0x0a to 0x0c = "H43" |
//! | output | 0x03 to 0x08, in the order x, **z, y**, high byte first; −4096 is an overflow |
//! | status | 0x09, bit 0 RDY |
//! | temperature | none |
//! | self-test | configuration A bits 1–0 = 1, at gain 5: 243 to 575 counts on each axis |
//!
//! The magnetic half of an LSM303DLHC has the same address, the same identity and other scales: see
//! [`probe`](crate::probe).

use super::description::{Chip, Identity, Write};
use super::self_test::{Good, Plan, SelfTest};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// The only address.
pub const ADDRESS: u8 = 0x1e;
/// Averaging (bits 6–5), rate (4–2), self-test (1–0).
pub const CONFIG_A: u8 = 0x00;
/// Gain (bits 7–5).
pub const CONFIG_B: u8 = 0x01;
/// Mode: 0 is continuous.
pub const MODE: u8 = 0x02;
/// The first of the six output bytes.
pub const OUT_X_H: u8 = 0x03;
/// Bit 0: a set of data waits.
pub const STATUS: u8 = 0x09;
/// The first of the three identification bytes.
pub const IDENTIFICATION_A: u8 = 0x0a;
/// What they read.
pub const IDENTITY: [u8; 3] = *b"H43";
/// [`CONFIG_A`]: eight measurements are averaged to one.
pub const AVERAGE_8: u8 = 3 << 5;
/// [`CONFIG_A`]: a positive test field.
pub const POSITIVE_BIAS: u8 = 1;
/// [`STATUS`]: a set of data waits.
pub const RDY: u8 = 1 << 0;
/// What an output reads when its axis is out of range.
pub const OVERFLOW: i16 = -4096;

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    Gauss0_88,
    /// The chip's default.
    #[default]
    Gauss1_3,
    Gauss1_9,
    Gauss2_5,
    Gauss4_0,
    Gauss4_7,
    Gauss5_6,
    Gauss8_1,
}

impl Range {
    /// All ranges, the finest first.
    pub const ALL: [Range; 8] = [
        Range::Gauss0_88,
        Range::Gauss1_3,
        Range::Gauss1_9,
        Range::Gauss2_5,
        Range::Gauss4_0,
        Range::Gauss4_7,
        Range::Gauss5_6,
        Range::Gauss8_1,
    ];

    /// The byte for [`CONFIG_B`].
    pub const fn bits(self) -> u8 {
        (self as u8) << 5
    }

    /// Counts per gauss, the same on all axes.
    pub const fn counts_per_gauss(self) -> u16 {
        match self {
            Range::Gauss0_88 => 1370,
            Range::Gauss1_3 => 1090,
            Range::Gauss1_9 => 820,
            Range::Gauss2_5 => 660,
            Range::Gauss4_0 => 440,
            Range::Gauss4_7 => 390,
            Range::Gauss5_6 => 330,
            Range::Gauss8_1 => 230,
        }
    }
}

/// Measurements a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz0_75,
    Hz1_5,
    Hz3,
    Hz7_5,
    Hz15,
    Hz30,
    #[default]
    Hz75,
}

impl DataRate {
    /// The rate bits of [`CONFIG_A`].
    pub const fn bits(self) -> u8 {
        (self as u8) << 2
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz0_75 => 0.75,
            DataRate::Hz1_5 => 1.5,
            DataRate::Hz3 => 3.0,
            DataRate::Hz7_5 => 7.5,
            DataRate::Hz15 => 15.0,
            DataRate::Hz30 => 30.0,
            DataRate::Hz75 => 75.0,
        }
    }
}

/// The whole configuration. The default: ±1.3 G, 75 Hz, averages of eight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measuring range.
    pub range: Range,
    /// Measurements a second.
    pub rate: DataRate,
    /// Each measurement is the mean of eight.
    pub averaged: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self { range: Range::default(), rate: DataRate::default(), averaged: true }
    }
}

impl Config {
    fn registers(config_a: u8, config_b: u8) -> [Write; 3] {
        [Write::kept(CONFIG_A, config_a), Write::kept(CONFIG_B, config_b), Write::kept(MODE, 0)]
    }
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: IDENTIFICATION_A, bytes: &IDENTITY };
    const STATUS: (u8, u8) = (STATUS, RDY);
    const OUTPUT: u8 = OUT_X_H;
    // "The first measurement after a gain change maintains the same gain as the previous setting."
    const DROPPED: u8 = 1;
    type Output = [u8; 6];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        ADDRESS
    }

    fn writes(&self) -> [Write; 3] {
        let average = if self.averaged { AVERAGE_8 } else { 0 };
        Self::registers(average | self.rate.bits(), self.range.bits())
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "HMC5883L",
            ut_per_count: [100.0 / f32::from(self.range.counts_per_gauss()); 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: 2047,
            bits: 12,
            shift: 0,
        }
    }

    fn decode(&self, &[xh, xl, zh, zl, yh, yl]: &[u8; 6]) -> Reading {
        let counts = [[xh, xl], [yh, yl], [zh, zl]].map(i16::from_be_bytes);
        Reading { counts, overflow: counts.map(|count| !(-2048..=2047).contains(&count)) }
    }
}

impl SelfTest for Config {
    /// The test's measurement is the difference that the test's field makes, taken by the chip itself: averages of eight,
    /// ±4.7 G, and the limits that the datasheet gives for that gain. The first is of the gain before.
    fn plan(&self) -> Plan<[Write; 3]> {
        Plan {
            before: Self::registers(
                AVERAGE_8 | DataRate::Hz15.bits() | POSITIVE_BIAS,
                Range::Gauss4_7.bits(),
            ),
            start: Write::kept(MODE, 0),
            // Two periods at 15 Hz: what waits then is of the new gain and of the test.
            settling_ms: 150,
            samples: 1,
            patience_ms: 250,
            good: Good::Level([(243, 575); 3]),
        }
    }
}
