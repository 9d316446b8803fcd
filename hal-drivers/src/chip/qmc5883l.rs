//! QST QMC5883L: 16 bits, ±2 or ±8 G, 10 to 200 Hz. Often sold as "HMC5883L"; the two share no register.
//!
//! From the datasheet (13-52-04, revision 1.0): register map table 13, control registers sections 9.2.4 and 9.2.5, sensitivity
//! table 2.
//!
//! | what | where |
//! |---|---|
//! | address | 0x0d |
//! | identity | 0x0d = 0xff; a weak one, [`probe`](crate::probe) asks for more |
//! | output | 0x00 to 0x05, low byte first |
//! | status | 0x06: bit 0 DRDY, bit 1 OVL, bit 2 DOR |
//! | temperature | 0x07, low byte first, 100 counts per °C, its zero not calibrated |
//! | self-test | none |

use super::description::{Chip, Identity, Thermometer, Write};
use ironout_sensor::{AxisMap, Reading, Sensor};

pub use super::qst::DataRate;

/// The only address.
pub const ADDRESS: u8 = 0x0d;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x00;
/// Data ready (bit 0), overflow (1), data skipped (2).
pub const STATUS: u8 = 0x06;
/// The first of the two temperature bytes.
pub const TEMP_L: u8 = 0x07;
/// Over-sampling (bits 7–6), range (5–4), rate (3–2), mode (1–0).
pub const CONTROL_1: u8 = 0x09;
/// Reset (bit 7), roll-over (6), interrupt off (0).
pub const CONTROL_2: u8 = 0x0a;
/// The period of set and reset; 1 is recommended.
pub const SET_RESET_PERIOD: u8 = 0x0b;
/// Who it is.
pub const CHIP_ID: u8 = 0x0d;
/// What [`CHIP_ID`] reads.
pub const IDENTITY: u8 = 0xff;
/// [`STATUS`]: a set of data waits.
pub const DRDY: u8 = 1 << 0;
/// [`STATUS`]: an axis was out of range.
pub const OVL: u8 = 1 << 1;
/// [`CONTROL_1`]: continuous measurements.
pub const CONTINUOUS: u8 = 1;

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    Gauss2,
    #[default]
    Gauss8,
}

impl Range {
    /// Both ranges, the finer first.
    pub const ALL: [Range; 2] = [Range::Gauss2, Range::Gauss8];

    /// The range bits of [`CONTROL_1`].
    pub const fn bits(self) -> u8 {
        (self as u8) << 4
    }

    /// Counts per gauss.
    pub const fn counts_per_gauss(self) -> u16 {
        match self {
            Range::Gauss2 => 12_000,
            Range::Gauss8 => 3_000,
        }
    }
}

/// The whole configuration. The default: ±8 G (hard iron of a module's own board easily leaves ±2 G), 100 Hz, over-sampling 512.
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
    // The flags of overflow come in front of nothing: status stands behind the outputs, so that all seven are one measurement's.
    const OUTPUT: u8 = OUT_X_L;
    const DROPPED: u8 = 1;
    type Output = [u8; 7];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        ADDRESS
    }

    fn writes(&self) -> [Write; 3] {
        [
            // Interrupt pin as after power-up, no roll-over of the pointer.
            Write::kept(CONTROL_2, 0),
            Write::kept(SET_RESET_PERIOD, 1),
            Write::kept(CONTROL_1, self.range.bits() | (self.rate.code() << 2) | CONTINUOUS),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "QMC5883L",
            ut_per_count: [100.0 / f32::from(self.range.counts_per_gauss()); 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: i16::MAX as u16,
            bits: 16,
            shift: 0,
        }
    }

    fn decode(&self, &[xl, xh, yl, yh, zl, zh, status]: &[u8; 7]) -> Reading {
        let counts = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
        // One flag for all axes. Where no axis stands at its end, none is known to be good.
        let ends = counts.map(|count| count == i16::MAX || count == i16::MIN);
        let flagged = status & OVL != 0;
        let overflow = if flagged && ends == [false; 3] { [true; 3] } else { ends };
        Reading { counts, overflow }
    }

    fn thermometer(&self) -> Thermometer {
        Thermometer::Burst(TEMP_L)
    }

    /// Good for differences only: the zero is not calibrated and differs from chip to chip by tens of degrees.
    fn celsius(&self, bytes: [u8; 2]) -> f32 {
        f32::from(i16::from_le_bytes(bytes)) / 100.0
    }
}
