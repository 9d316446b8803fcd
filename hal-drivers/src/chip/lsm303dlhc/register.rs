//! Register map of the magnetic half (LSM303DLHC datasheet, section 7.2).

/// The chip's only I²C address (7 bits).
pub const ADDRESS: u8 = 0x1e;
/// Configuration A: bit 7 enables the temperature sensor, bits 4–2 are the data rate.
pub const CRA: u8 = 0x00;
/// Configuration B: bits 7–5 are the range.
pub const CRB: u8 = 0x01;
/// Mode: 0 is continuous conversion, 1 a single one, 2 and 3 sleep.
pub const MR: u8 = 0x02;
/// The first of the six output bytes: x, z, y, high byte first.
pub const OUT_X_H: u8 = 0x03;
/// Status: bit 0 data ready, bit 1 outputs locked.
pub const SR: u8 = 0x09;
/// The first of the three identification bytes.
pub const IRA: u8 = 0x0a;
/// Temperature, high byte.
pub const TEMP_OUT_H: u8 = 0x31;
/// Temperature, low byte. The address pointer does not lead from the high byte here.
pub const TEMP_OUT_L: u8 = 0x32;

/// What the three identification registers hold: "H43".
pub const IDENTITY: [u8; 3] = *b"H43";
/// [`CRA`]: the temperature sensor is on.
pub const CRA_TEMP_EN: u8 = 1 << 7;
/// [`MR`]: continuous conversion.
pub const MR_CONTINUOUS: u8 = 0;
/// [`SR`]: a set of data waits to be read.
pub const SR_DRDY: u8 = 1 << 0;
/// What an output register reads when the field on its axis is out of range.
pub const OVERFLOW: i16 = -4096;
/// The values a valid output has: 12 bits.
pub const VALID: core::ops::RangeInclusive<i16> = -2048..=2047;
/// The largest magnitude of a valid output of either sign.
pub const FULL_SCALE: u16 = 2047;
