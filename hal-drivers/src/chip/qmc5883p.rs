//! QST QMC5883P: 16 bits, ±2 to ±30 G, 10 to 200 Hz. The successor of the QMC5883L, with other registers and another address.
//!
//! From the datasheet (13-52-19, revision C) as quoted by the register lists of PX4 and RT-Thread; sensitivities of its table 2.
//!
//! | what | where |
//! |---|---|
//! | address | 0x2c |
//! | identity | 0x00 = 0x80 |
//! | output | 0x01 to 0x06, low byte first |
//! | status | 0x09: bit 0 DRDY, bit 1 OVFL |
//! | temperature | none |
//! | self-test | 0x0b bit 6; its limits could not be checked, so that it is not offered here |

use super::description::{Chip, Identity, Write};
use ironout_sensor::{AxisMap, Reading, Sensor};

pub use super::qst::DataRate;

/// The only address.
pub const ADDRESS: u8 = 0x2c;
/// Who it is.
pub const CHIP_ID: u8 = 0x00;
/// What [`CHIP_ID`] reads.
pub const IDENTITY: u8 = 0x80;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x01;
/// Data ready (bit 0), overflow (1).
pub const STATUS: u8 = 0x09;
/// Down-sampling (bits 7–6), over-sampling (5–4), rate (3–2), mode (1–0).
pub const CONTROL_1: u8 = 0x0a;
/// Reset (bit 7), self-test (6), range (3–2), set and reset (1–0).
pub const CONTROL_2: u8 = 0x0b;
/// The signs of the axes.
pub const SIGNS: u8 = 0x29;
/// [`SIGNS`]: those that the datasheet's application example sets.
pub const SIGNS_AS_DRAWN: u8 = 0x06;
/// [`STATUS`]: a set of data waits.
pub const DRDY: u8 = 1 << 0;
/// [`STATUS`]: an axis was out of range.
pub const OVFL: u8 = 1 << 1;
/// [`CONTROL_1`]: "normal" mode, measurements at the rate.
pub const NORMAL: u8 = 1;

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    Gauss2,
    #[default]
    Gauss8,
    Gauss12,
    Gauss30,
}

impl Range {
    /// All ranges, the finest first.
    pub const ALL: [Range; 4] = [Range::Gauss2, Range::Gauss8, Range::Gauss12, Range::Gauss30];

    /// The range bits of [`CONTROL_2`].
    pub const fn bits(self) -> u8 {
        (3 - self as u8) << 2
    }

    /// Counts per gauss.
    pub const fn counts_per_gauss(self) -> u16 {
        match self {
            Range::Gauss2 => 15_000,
            Range::Gauss8 => 3_750,
            Range::Gauss12 => 2_500,
            Range::Gauss30 => 1_000,
        }
    }
}

/// The whole configuration. The default: ±8 G, 100 Hz; over-sampling 8, no down-sampling, set and reset on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measuring range.
    pub range: Range,
    /// Measurements a second.
    pub rate: DataRate,
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: CHIP_ID, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STATUS, DRDY);
    // Up to and with the status: its overflow belongs to the measurement.
    const OUTPUT: u8 = OUT_X_L;
    const DROPPED: u8 = 1;
    type Output = [u8; 9];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        ADDRESS
    }

    fn writes(&self) -> [Write; 3] {
        [
            Write::kept(SIGNS, SIGNS_AS_DRAWN),
            Write::kept(CONTROL_2, self.range.bits()),
            Write::kept(CONTROL_1, (self.rate.code() << 2) | NORMAL),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "QMC5883P",
            ut_per_count: [100.0 / f32::from(self.range.counts_per_gauss()); 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: i16::MAX as u16,
            bits: 16,
            shift: 0,
        }
    }

    fn decode(&self, &[xl, xh, yl, yh, zl, zh, _, _, status]: &[u8; 9]) -> Reading {
        let counts = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
        // One flag for all axes. Where no axis stands at its end, none is known to be good.
        let ends = counts.map(|count| count == i16::MAX || count == i16::MIN);
        let overflow = if status & OVFL != 0 && ends == [false; 3] { [true; 3] } else { ends };
        Reading { counts, overflow }
    }
}
