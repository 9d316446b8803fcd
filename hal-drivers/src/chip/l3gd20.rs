//! ST L3GD20, L3GD20H and I3G4250D: gyroscopes of 16 bits, ±245 or ±250 to ±2000 °/s. The STM32F3DISCOVERY has one of them, on SPI.
//!
//! From the datasheets L3GD20 (DocID 022116) and I3G4250D (DocID 022768): sensitivities table 4, registers section 7.
//!
//! | what | where |
//! |---|---|
//! | address | 0x6a or 0x6b, by pin SDO; or SPI: bit 7 reads, bit 6 lets the pointer go on |
//! | identity | WHO_AM_I 0x0f = 0xd4 (L3GD20), 0xd7 (L3GD20H), 0xd3 (I3G4250D) |
//! | output | OUT_X_L 0x28 to 0x2d, low byte first |
//! | scale | 8.75, 17.5, 70 m°/s a count |

use super::description::Write;

/// Both addresses, by the level of pin SDO.
pub const ADDRESSES: [u8; 2] = [0x6a, 0x6b];
/// Who it is.
pub const WHO_AM_I: u8 = 0x0f;
/// Rate (bits 7–6), bandwidth (5–4), awake (3), axes (2–0).
pub const CTRL_1: u8 = 0x20;
/// Block data update (bit 7), byte order (6), range (5–4).
pub const CTRL_4: u8 = 0x23;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x28;
/// Lets the register pointer go on, on I²C.
pub const INCREMENT: u8 = 0x80;

/// Which of the chips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Model {
    L3gd20,
    L3gd20h,
    I3g4250d,
}

impl Model {
    /// The chip of an identity.
    pub const fn of(who_am_i: u8) -> Option<Self> {
        match who_am_i {
            0xd4 => Some(Model::L3gd20),
            0xd7 => Some(Model::L3gd20h),
            0xd3 => Some(Model::I3g4250d),
            _ => None,
        }
    }

    /// The chip's name.
    pub const fn name(self) -> &'static str {
        match self {
            Model::L3gd20 => "L3GD20",
            Model::L3gd20h => "L3GD20H",
            Model::I3g4250d => "I3G4250D",
        }
    }
}

/// Measuring range: 245 (or 250), 500 or 2000 °/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    #[default]
    Dps250,
    Dps500,
    Dps2000,
}

/// The whole configuration: always some 100 Hz. The default: ±250 °/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measuring range.
    pub range: Range,
}

impl Config {
    /// The registers to write.
    pub const fn writes(&self) -> [Write; 2] {
        [Write::kept(CTRL_1, 0x0f), Write::kept(CTRL_4, 0x80 | (self.range as u8) << 4)]
    }

    /// rad/s of a count.
    pub const fn radps_per_count(&self) -> f32 {
        let mdps = match self.range {
            Range::Dps250 => 8.75,
            Range::Dps500 => 17.5,
            Range::Dps2000 => 70.0,
        };
        mdps * (core::f32::consts::PI / 180_000.0)
    }

    /// rad/s from the six output bytes; `None` where an axis stands at the end of its range.
    pub fn radps(&self, [xl, xh, yl, yh, zl, zh]: [u8; 6]) -> Option<[f32; 3]> {
        let counts = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
        let clipped = counts.iter().any(|&count| count == i16::MAX || count == i16::MIN);
        (!clipped).then(|| counts.map(|count| f32::from(count) * self.radps_per_count()))
    }
}
