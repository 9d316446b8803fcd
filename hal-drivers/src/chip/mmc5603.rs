//! MEMSIC MMC5603NJ (and MMC5633NJL, whose registers are the same): 20 bits, ±30 G, 1 to 255 Hz. Its SET and RESET turn the sensing
//! direction around, which separates its own offset from the field.
//!
//! From the datasheet (revision B) as Linux, ArduPilot, Zephyr and the register lists of others quote it.
//!
//! | what | where |
//! |---|---|
//! | address | 0x30 |
//! | identity | 0x39 = 0x10 (parts that read 0 there have been seen: they are not found) |
//! | output | 0x00 to 0x08: bits 19–4 of x, y, z, high byte first, then four bits of each in a byte of its own; no field is 524 288; 16 384 counts per gauss |
//! | status | 0x18: bit 6 field measured, bit 7 temperature measured |
//! | rate | 0x1a, in Hz |
//! | control | 0x1b to 0x1d; they cannot be read back |
//! | temperature | 0x09, 0.8 °C a count from −75 °C, measured when told (0x1b bit 1), between continuous measurements |
//! | self-test | compares with a value of each chip's; not offered here |
//!
//! The chip can SET and RESET by itself at each measurement (0x1b bit 5). The driver does not use it: what the chip does with the two
//! measurements is described too loosely to be sure that the offset is out. It measures the offset as it does with an MMC5983MA
//! ([`set_reset`](super::set_reset)).
//!
//! Whether the flag of a measurement falls when the outputs are read is not said of continuous measurements; a close relative (MMC5616WA)
//! does it. If a chip does not, a measurement is told more than once.

use super::description::{Identity, Write};
use super::set_reset::{Raw, SetReset};
use ironout_sensor::{AxisMap, Sensor};

/// The only address.
pub const ADDRESS: u8 = 0x30;
/// The first of the nine output bytes.
pub const OUT_X_0: u8 = 0x00;
/// Temperature.
pub const T_OUT: u8 = 0x09;
/// Field measured (bit 6), temperature measured (7).
pub const STATUS: u8 = 0x18;
/// Measurements a second, in Hz.
pub const RATE: u8 = 0x1a;
/// Starts measurements, SET and RESET; continuous measurements at the rate (bit 7).
pub const CONTROL_0: u8 = 0x1b;
/// Bandwidth (bits 1–0), reset (7).
pub const CONTROL_1: u8 = 0x1c;
/// Continuous measurements (bit 4).
pub const CONTROL_2: u8 = 0x1d;
/// Who it is.
pub const PRODUCT_ID: u8 = 0x39;
/// What [`PRODUCT_ID`] reads.
pub const IDENTITY: u8 = 0x10;
/// [`CONTROL_0`]: the rate is that of [`RATE`].
pub const CMM_FREQ_EN: u8 = 1 << 7;
/// [`CONTROL_2`]: continuous measurements.
pub const CMM_EN: u8 = 1 << 4;
/// What an output reads without a field.
pub const ZERO: i32 = 1 << 19;
/// ±30 G in counts: what is beyond is not specified.
pub const FULL_SCALE: u32 = 30 * 16_384;

/// The whole configuration. The default: 75 Hz, ±3000 µT, the offset anew every 1000 measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measurements a second, 1 to 255. Up to 75 the chip averages longest (0.2 µT of noise), up to 150 half as long.
    pub rate_hz: u8,
    /// Low bits of the chip's counts that are left out: 4 carries the whole range (98 nT a count), 2 a quarter of it.
    pub shift: u8,
    /// Measurements after which the chip's offset and temperature are measured anew, which takes the time of some four; 0 for only
    /// at each configuration.
    pub refresh_every: u16,
}

impl Default for Config {
    fn default() -> Self {
        Self { rate_hz: 75, shift: 4, refresh_every: 1000 }
    }
}

impl Config {
    /// The byte for [`CONTROL_1`]: the longest measurement that the rate leaves time for.
    pub const fn bandwidth(&self) -> u8 {
        match self.rate_hz {
            0..=75 => 0,
            76..=150 => 1,
            _ => 2,
        }
    }
}

impl SetReset for Config {
    const IDENTITY: Identity = Identity { register: PRODUCT_ID, bytes: &[IDENTITY] };
    const ADDRESS: u8 = ADDRESS;
    const STATUS: u8 = STATUS;
    const FIELD_DONE: u8 = 1 << 6;
    const TEMPERATURE_DONE: u8 = 1 << 7;
    const CONTROL: u8 = CONTROL_0;
    // "SET or RESET to other operations" in the timing diagram.
    const PULSE_MS: u32 = 1;
    const OUTPUT: u8 = OUT_X_0;
    const TEMPERATURE: u8 = T_OUT;
    const STOP: Write = Write::unread(CONTROL_2, 0);
    const COUNTS_PER_GAUSS: f32 = 16_384.0;
    type Output = [u8; 9];
    type Writes = [Write; 1];
    type Start = [Write; 3];

    fn check(&self) -> Result<(), &'static str> {
        if self.rate_hz == 0 {
            Err("MMC5603: no measurements a second: 1 to 255")
        } else if self.shift > 8 {
            Err("MMC5603: more than 8 bits left out of 20: at most 8")
        } else {
            Ok(())
        }
    }

    fn writes(&self) -> [Write; 1] {
        [Write::unread(CONTROL_1, self.bandwidth())]
    }

    fn start(&self) -> [Write; 3] {
        [
            Write::unread(RATE, self.rate_hz),
            // The measurement period is computed from the rate when this is written, and has to be there before the next.
            Write::unread(CONTROL_0, CMM_FREQ_EN),
            Write::unread(CONTROL_2, CMM_EN),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "MMC5603",
            ut_per_count: [100.0 * f32::from(1_u16 << self.shift.min(8)) / Self::COUNTS_PER_GAUSS; 3],
            axes: AxisMap::IDENTITY,
            rate_hz: f32::from(self.rate_hz),
            full_scale_counts: i16::MAX as u16,
            bits: 20,
            shift: self.shift,
        }
    }

    fn raw(&self, &[xh, xm, yh, ym, zh, zm, xl, yl, zl]: &[u8; 9]) -> Raw {
        let axis = |high: u8, middle: u8, low: u8| {
            ((i32::from(high) << 12) | (i32::from(middle) << 4) | i32::from(low >> 4)) - ZERO
        };
        let counts = [axis(xh, xm, xl), axis(yh, ym, yl), axis(zh, zm, zl)];
        Raw { counts, clipped: counts.map(|count| count.unsigned_abs() > FULL_SCALE) }
    }

    fn refresh_every(&self) -> u16 {
        self.refresh_every
    }
}
