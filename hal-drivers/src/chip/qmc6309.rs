//! QST QMC6309: 16 bits, ±8 to ±32 G, 10 to 200 Hz. Registers as a QMC6310 has them, with other bits in its two control registers and
//! other ranges.
//!
//! From the datasheet (revision C) as quoted by SensorLib, SlimeVR and a published register list with the bits of each register.
//!
//! | what | where |
//! |---|---|
//! | address | 0x7c, which I²C reserves for 10-bit addresses: some bus drivers refuse it |
//! | identity | 0x00 = 0x90 |
//! | output | 0x01 to 0x06, low byte first |
//! | status | 0x09: bit 0 DRDY, bit 1 OVFL: an axis is beyond ±32 000 counts, the end of each range; both fall when it is read |
//! | temperature | none |
//! | self-test | 0x0e; published lists differ in its bit and its limits, so that it is not offered here |
//!
//! The QMC6309H (address 0x0c) has bits of its own in its control registers and is not driven here.

use super::description::{Chip, Identity, Write};
use super::qst::reading;
use ironout_sensor::{AxisMap, Reading, Sensor};

pub use super::qst::DataRate;

/// The only address.
pub const ADDRESS: u8 = 0x7c;
/// Who it is.
pub const CHIP_ID: u8 = 0x00;
/// What [`CHIP_ID`] reads.
pub const IDENTITY: u8 = 0x90;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x01;
/// Data ready (bit 0), overflow (1), memory read (4–3).
pub const STATUS: u8 = 0x09;
/// Low-pass filter (bits 7–5), over-sampling (4–3), mode (1–0).
pub const CONTROL_1: u8 = 0x0a;
/// Reset (bit 7), rate (6–4), range (3–2), set and reset (1–0).
pub const CONTROL_2: u8 = 0x0b;
/// [`STATUS`]: a set of data waits.
pub const DRDY: u8 = 1 << 0;
/// [`CONTROL_1`]: "normal" mode, measurements at the rate.
pub const NORMAL: u8 = 1;
/// The largest magnitude of a count that is a measurement.
pub const FULL_SCALE: u16 = 32_000;

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    #[default]
    Gauss8,
    Gauss16,
    Gauss32,
}

impl Range {
    /// All ranges, the finest first.
    pub const ALL: [Range; 3] = [Range::Gauss8, Range::Gauss16, Range::Gauss32];

    /// The range bits of [`CONTROL_2`].
    pub const fn bits(self) -> u8 {
        (2 - self as u8) << 2
    }

    /// Counts per gauss.
    pub const fn counts_per_gauss(self) -> u16 {
        match self {
            Range::Gauss8 => 4_000,
            Range::Gauss16 => 2_000,
            Range::Gauss32 => 1_000,
        }
    }
}

/// The whole configuration. The default: ±8 G, 100 Hz; over-sampling 8, no low-pass filter, set and reset at each measurement.
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
    const OUTPUT: u8 = OUT_X_L;
    const DROPPED: u8 = 1;
    type Output = [u8; 6];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        ADDRESS
    }

    fn writes(&self) -> [Write; 3] {
        [
            // From one mode to another only through "suspend".
            Write::unread(CONTROL_1, 0),
            Write::kept(CONTROL_2, ((self.rate.code() + 1) << 4) | self.range.bits()),
            Write::kept(CONTROL_1, NORMAL),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "QMC6309",
            ut_per_count: [100.0 / f32::from(self.range.counts_per_gauss()); 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: FULL_SCALE,
            bits: 16,
            shift: 0,
        }
    }

    fn decode(&self, bytes: &[u8; 6]) -> Reading {
        reading(bytes, FULL_SCALE)
    }
}
