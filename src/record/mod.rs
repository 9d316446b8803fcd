//! The stored calibration: a record with a version and a CRC.
//!
//! All numbers are little-endian, all floats f64 unless said otherwise, so that what is read back has the bits that were
//! written.
//!
//! | bytes | what |
//! |---|---|
//! | 0–3 | `IRON` |
//! | 4 | version of the layout: 1 without effects, 2 with them, 3 with short standard errors; 4 as 2 and 5 as 3 with ranges; 6 to 10 as 1 to 5 with a covariance; 11 to 20 as 1 to 10 with tilts |
//! | 5 | method of the fit, 6: its model, 7: number of effects (0 in version 1) |
//! | 8–11 | sequence number: of two sound records the newer counts |
//! | 12–13 | length of the record with its CRC, 14: how the sensor was mounted (`AxisMap::code`; 0: not stated), 15: its predicted error ([`PredictedError`]; 0: not stated) |
//! | 16–23 | `field_ut`, 24–47: `offset_ut`, 48–119: `matrix`, rows first |
//! | 120–127 | samples (u64), 128–135: `noise_ut`, 136–143: `rms_ut` |
//! | 144–… | the effects, but for versions 1, 6, 11 and 16 |
//! | 180 bytes after them | versions 6 to 10 and 16 to 20: the covariance |
//! | 32 bytes before the CRC | from version 11 on: the tilts that the calibration holds for ([`HoldsFor`]) |
//! | last 4 | CRC-32 (ISO-HDLC) of everything before |
//!
//! An effect is: its kind (one byte, its highest bit set where the effect bends the field and not the reading), bytes of its column's name (one byte), that name, its reference where it has one, then
//! its delay, time or frequency where it has one, its coefficients, and their standard errors: in single precision, or in version
//! 3 the upper half of one (8 bits of mantissa: 0.4 %). Version 3 is written only where version 2 would be too long.
//!
//! Versions 4 and 5 are written only where an effect knows over which range of its columns it was fitted. After its standard
//! errors it then has the least and the greatest value of each of its columns, in single precision, rounded outward; both
//! NaN where the range is not known.
//!
//! Versions 6 to 10 are written where a calibration comes with the covariance of its offset and matrix ([`Covariance`]: 45 numbers in
//! single precision, the rows of the upper triangle) and there is room for it beside whole standard errors.
//!
//! Versions 11 to 20 are written only for a calibration that does not hold for all tilts. Older firmware does not know them and does not
//! apply them (`unsupported-version-11`): it would not warn.
//!
//! The first 16 bytes and the place of the CRC belong to every version. So firmware that meets a newer record can tell it
//! from a damaged one, and a longer record is checked by its own length. What is known of a calibration decides its version: one
//! without effects and without a covariance is written in version 1, which any firmware reads.

mod content;
mod covariance;
#[cfg(all(feature = "record", feature = "effects"))]
mod effect;
mod holds_for;
#[cfg(feature = "record")]
mod layout;
mod predicted;
#[cfg(feature = "record")]
mod stored;

pub use content::Record;
pub use covariance::Covariance;
pub use holds_for::{HoldsFor, TILTS_DEG};
#[cfg(feature = "record")]
pub(crate) use layout::stated_length;
#[cfg(feature = "record")]
pub use layout::{
    COVARIANCE_BYTES, HOLDS_FOR_BYTES, MAX_RECORD_BYTES, RECORD_BYTES, RecordError, VERSION,
    VERSION_SHORT_ERRORS, VERSION_WITH_EFFECTS, VERSION_WITH_RANGES, VERSION_WITH_RANGES_SHORT_ERRORS,
    WITH_COVARIANCE, WITH_HOLDS_FOR,
};
pub use predicted::PredictedError;
#[cfg(feature = "record")]
pub use stored::{DoesNotFit, Encoded, is_newer};
