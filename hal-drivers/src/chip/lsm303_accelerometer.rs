//! ST LSM303DLHC and LSM303AGR, the accelerometer half: 12 bits, ±2 to ±16 g.
//!
//! From the datasheets LSM303DLHC (DocID 018771; linear acceleration sensitivity table 3, registers 7.1) and LSM303AGR (DocID
//! 027765; table 4, registers section 8).
//!
//! | what | where |
//! |---|---|
//! | address | 0x19, no other |
//! | identity | LSM303AGR: WHO_AM_I_A 0x0f = 0x33; LSM303DLHC: none documented |
//! | output | OUT_X_L_A 0x28 to 0x2d, low byte first, 12 bits left-justified; bit 7 of the sub-address lets the pointer go on |
//! | scale | LSM303DLHC 1, 2, 4, 12 mg a count; LSM303AGR 0.98, 1.95, 3.9, 11.72 |

use super::description::Write;

/// The only address.
pub const ADDRESS: u8 = 0x19;
/// Who it is (LSM303AGR).
pub const WHO_AM_I: u8 = 0x0f;
/// What [`WHO_AM_I`] reads (LSM303AGR).
pub const IDENTITY: u8 = 0x33;
/// Rate (bits 7–4), low power (3), axes (2–0).
pub const CTRL_1: u8 = 0x20;
/// Block data update (bit 7), byte order (6), range (5–4), high resolution (3).
pub const CTRL_4: u8 = 0x23;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x28;
/// Lets the register pointer go on.
pub const INCREMENT: u8 = 0x80;
/// Standard gravity, m/s².
const G_MPS2: f32 = 9.806_65;

/// Which of the chips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Model {
    #[default]
    Lsm303dlhc,
    Lsm303agr,
}

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    #[default]
    G2,
    G4,
    G8,
    G16,
}

/// The whole configuration: always 100 Hz at high resolution. The default: LSM303DLHC, ±2 g.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Which chip it is.
    pub model: Model,
    /// Measuring range.
    pub range: Range,
}

impl Config {
    /// The registers to write.
    pub const fn writes(&self) -> [Write; 2] {
        [Write::kept(CTRL_1, 0x57), Write::kept(CTRL_4, 0x88 | (self.range as u8) << 4)]
    }

    /// m/s² of a count.
    pub const fn mps2_per_count(&self) -> f32 {
        let mg = match (self.model, self.range) {
            (Model::Lsm303dlhc, Range::G2) => 1.0,
            (Model::Lsm303dlhc, Range::G4) => 2.0,
            (Model::Lsm303dlhc, Range::G8) => 4.0,
            (Model::Lsm303dlhc, Range::G16) => 12.0,
            (Model::Lsm303agr, Range::G2) => 0.98,
            (Model::Lsm303agr, Range::G4) => 1.95,
            (Model::Lsm303agr, Range::G8) => 3.9,
            (Model::Lsm303agr, Range::G16) => 11.72,
        };
        mg * (G_MPS2 / 1000.0)
    }

    /// m/s² from the six output bytes; `None` where an axis stands at the end of its 12 bits.
    pub fn mps2(&self, [xl, xh, yl, yh, zl, zh]: [u8; 6]) -> Option<[f32; 3]> {
        let counts = [[xl, xh], [yl, yh], [zl, zh]].map(|axis| i16::from_le_bytes(axis) >> 4);
        let clipped = counts.iter().any(|&count| count >= 2047 || count <= -2048);
        (!clipped).then(|| counts.map(|count| f32::from(count) * self.mps2_per_count()))
    }
}
