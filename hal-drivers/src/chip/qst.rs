//! What the chips of QST share: four rates, and an overflow that the counts tell.

use ironout_sensor::Reading;

/// Measurements a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz10,
    Hz50,
    #[default]
    Hz100,
    Hz200,
}

impl DataRate {
    /// Its number, the slowest 0: each chip has it at another place of a control register.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz10 => 10.0,
            DataRate::Hz50 => 50.0,
            DataRate::Hz100 => 100.0,
            DataRate::Hz200 => 200.0,
        }
    }
}

/// A reading of six bytes, the low ones first. Its overflow is what the chip's flag says, axis by axis: reading the status to see whether
/// data wait has cleared the flag.
pub(super) fn reading(&[xl, xh, yl, yh, zl, zh]: &[u8; 6], full_scale: u16) -> Reading {
    let counts = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
    Reading { counts, overflow: counts.map(|count| count.unsigned_abs() > full_scale) }
}
