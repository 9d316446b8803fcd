//! QST QMC6310 (U and N): 16 bits, ±2 to ±30 G, 10 to 200 Hz. The registers are those of the [QMC5883P](super::qmc5883p), at other
//! addresses.
//!
//! From QST's register list as SensorLib publishes it: registers, ranges, sensitivities.
//!
//! | what | where |
//! |---|---|
//! | address | 0x1c (QMC6310U), 0x3c (QMC6310N) |
//! | identity | 0x00 = 0x80 |
//! | output | 0x01 to 0x06, low byte first |
//! | status | 0x09: bit 0 DRDY, bit 1 OVFL: an axis is beyond ±30 000 counts, the end of each range |
//! | temperature | none |
//! | self-test | 0x0b bit 6; its limits could not be checked, so that it is not offered here |
//!
//! Displays (SSD1306, SH1106) have address 0x3c too: `probe` takes a chip there for a QMC6310N only if its status register has nothing
//! in the empty bits either.

use super::description::{Chip, Identity, Write};
use super::qst::reading;
use ironout_sensor::{AxisMap, Reading, Sensor};

pub use super::qmc5883p::{
    CHIP_ID, CONTROL_1, CONTROL_2, DRDY, DataRate, IDENTITY, NORMAL, OUT_X_L, OVFL, Range, SIGNS,
    SIGNS_AS_DRAWN, STATUS,
};

/// The addresses: QMC6310U, QMC6310N.
pub const ADDRESSES: [u8; 2] = [0x1c, 0x3c];
/// Bits of [`STATUS`] that are always 0.
pub const STATUS_EMPTY: u8 = 0xfc;
/// The largest magnitude of a count that is a measurement.
pub const FULL_SCALE: u16 = 30_000;

/// The whole configuration. The default: address 0x1c, ±8 G, 100 Hz; over-sampling 8, no down-sampling, set and reset on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
    /// Measuring range.
    pub range: Range,
    /// Measurements a second.
    pub rate: DataRate,
}

impl Default for Config {
    fn default() -> Self {
        Self { address: ADDRESSES[0], range: Range::default(), rate: DataRate::default() }
    }
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: CHIP_ID, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STATUS, DRDY);
    const OUTPUT: u8 = OUT_X_L;
    const DROPPED: u8 = 1;
    type Output = [u8; 6];
    type Writes = [Write; 4];

    fn address(&self) -> u8 {
        self.address
    }

    fn writes(&self) -> [Write; 4] {
        [
            // From one mode to another only through "suspend".
            Write::unread(CONTROL_1, 0),
            Write::kept(SIGNS, SIGNS_AS_DRAWN),
            Write::kept(CONTROL_2, self.range.bits()),
            Write::kept(CONTROL_1, (self.rate.code() << 2) | NORMAL),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "QMC6310",
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
