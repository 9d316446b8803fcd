//! MEMSIC MMC5983MA: 18 bits, ±8 G, 1 to 200 Hz. Its SET and RESET turn the sensing direction around, which separates its own
//! offset from the field.
//!
//! From the datasheet (revision A): outputs and registers tables "Register map" and "Register details", SET and RESET section
//! "Using SET and RESET to remove bridge offset".
//!
//! | what | where |
//! |---|---|
//! | address | 0x30 |
//! | identity | 0x2f = 0x30 |
//! | output | 0x00 to 0x06: bits 17–2 of x, y, z, high byte first, then two bits of each; no field is 131 072; 16 384 counts per gauss |
//! | status | 0x08: bit 0 field measured, bit 1 temperature measured; written 1 clears |
//! | control | 0x09 to 0x0c; they cannot be read back |
//! | temperature | 0x07, 0.8 °C a count from −75 °C, measured when told (0x09 bit 1) |
//! | self-test | a coil (0x0c) without limits in the datasheet; not offered here |
//!
//! The driver takes the chip's offset out ([`set_reset`](super::set_reset)). Counts are carried with [`Config::shift`] low bits left
//! out.

use super::description::{Identity, Write};
use super::set_reset::{Raw, SetReset};
use ironout_sensor::{AxisMap, Sensor};

/// The only address.
pub const ADDRESS: u8 = 0x30;
/// The first of the seven output bytes.
pub const OUT_X_0: u8 = 0x00;
/// Temperature.
pub const T_OUT: u8 = 0x07;
/// Field measured (bit 0), temperature measured (1).
pub const STATUS: u8 = 0x08;
/// Starts measurements, SET and RESET.
pub const CONTROL_0: u8 = 0x09;
/// Bandwidth (bits 1–0), reset (7).
pub const CONTROL_1: u8 = 0x0a;
/// Continuous measurements: rate (bits 2–0), on (3).
pub const CONTROL_2: u8 = 0x0b;
/// Test coil, SPI.
pub const CONTROL_3: u8 = 0x0c;
/// Who it is.
pub const PRODUCT_ID: u8 = 0x2f;
/// What [`PRODUCT_ID`] reads.
pub const IDENTITY: u8 = 0x30;
/// [`STATUS`]: the field is measured.
pub const MEAS_M_DONE: u8 = 1 << 0;
/// [`STATUS`]: the temperature is measured.
pub const MEAS_T_DONE: u8 = 1 << 1;
/// [`CONTROL_2`]: continuous measurements.
pub const CMM_EN: u8 = 1 << 3;
/// What an output reads without a field.
pub const ZERO: i32 = 1 << 17;
/// The largest output.
pub const MOST: i32 = (1 << 18) - 1;
/// Counts per gauss.
pub const COUNTS_PER_GAUSS: f32 = 16_384.0;

/// Measurements a second, with the bandwidth that belongs to each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz10,
    Hz20,
    Hz50,
    /// 0.04 µT of noise.
    #[default]
    Hz100,
    /// 0.06 µT of noise.
    Hz200,
}

impl DataRate {
    /// The byte for [`CONTROL_1`].
    pub const fn bandwidth(self) -> u8 {
        match self {
            DataRate::Hz200 => 1,
            _ => 0,
        }
    }

    /// The byte for [`CONTROL_2`].
    pub const fn continuous(self) -> u8 {
        CMM_EN | (self as u8 + 2)
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz10 => 10.0,
            DataRate::Hz20 => 20.0,
            DataRate::Hz50 => 50.0,
            DataRate::Hz100 => 100.0,
            DataRate::Hz200 => 200.0,
        }
    }
}

/// The whole configuration. The default: 100 Hz, ±800 µT, the offset anew every 1000 measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measurements a second.
    pub rate: DataRate,
    /// Low bits of the chip's counts that are left out: 2 carries the whole range (24 nT a count), 1 half of it, 0 a quarter.
    pub shift: u8,
    /// Measurements after which the chip's offset and temperature are measured anew, which takes the time of some four; 0 for only
    /// at each configuration.
    pub refresh_every: u16,
}

impl Default for Config {
    fn default() -> Self {
        Self { rate: DataRate::default(), shift: 2, refresh_every: 1000 }
    }
}

impl SetReset for Config {
    const IDENTITY: Identity = Identity { register: PRODUCT_ID, bytes: &[IDENTITY] };
    const ADDRESS: u8 = ADDRESS;
    const STATUS: u8 = STATUS;
    const FIELD_DONE: u8 = MEAS_M_DONE;
    const TEMPERATURE_DONE: u8 = MEAS_T_DONE;
    const CONTROL: u8 = CONTROL_0;
    // 500 ns, which the next transaction takes anyway.
    const PULSE_MS: u32 = 0;
    const OUTPUT: u8 = OUT_X_0;
    const TEMPERATURE: u8 = T_OUT;
    const STOP: Write = Write::unread(CONTROL_2, 0);
    const COUNTS_PER_GAUSS: f32 = COUNTS_PER_GAUSS;
    type Output = [u8; 7];
    type Writes = [Write; 2];
    type Start = [Write; 1];

    fn check(&self) -> Result<(), &'static str> {
        if self.shift > 8 { Err("MMC5983MA: more than 8 bits left out of 18: at most 8") } else { Ok(()) }
    }

    fn writes(&self) -> [Write; 2] {
        [Write::unread(CONTROL_1, self.rate.bandwidth()), Write::unread(CONTROL_3, 0)]
    }

    fn start(&self) -> [Write; 1] {
        [Write::unread(CONTROL_2, self.rate.continuous())]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "MMC5983MA",
            ut_per_count: [100.0 * f32::from(1_u16 << self.shift.min(8)) / COUNTS_PER_GAUSS; 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: i16::MAX as u16,
            bits: 18,
            shift: self.shift,
        }
    }

    fn raw(&self, &[xh, xm, yh, ym, zh, zm, low]: &[u8; 7]) -> Raw {
        let axis = |high: u8, middle: u8, shift: u8| {
            (i32::from(high) << 10) | (i32::from(middle) << 2) | i32::from((low >> shift) & 3)
        };
        let unsigned = [axis(xh, xm, 6), axis(yh, ym, 4), axis(zh, zm, 2)];
        Raw {
            counts: unsigned.map(|count| count - ZERO),
            clipped: unsigned.map(|count| count == 0 || count == MOST),
        }
    }

    fn refresh_every(&self) -> u16 {
        self.refresh_every
    }
}
