//! The bytes of a record: its layout, its checksum, and why bytes are none.

use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// The version of the layout of a record without effects …
pub const VERSION: u8 = 1;
/// … of one with them …
pub const VERSION_WITH_EFFECTS: u8 = 2;
/// … and of one with so many coefficients that their standard errors are kept in 16 bits, to fit.
pub const VERSION_SHORT_ERRORS: u8 = 3;
/// As [`VERSION_WITH_EFFECTS`], and it says over which range of its columns each effect was fitted …
pub const VERSION_WITH_RANGES: u8 = 4;
/// … and so as [`VERSION_SHORT_ERRORS`].
pub const VERSION_WITH_RANGES_SHORT_ERRORS: u8 = 5;
/// Added to one of the versions above: the same, and a covariance behind it.
pub const WITH_COVARIANCE: u8 = 5;
/// Added to one of the versions above, with a covariance or without: the same, and the tilts that it holds for behind it.
pub const WITH_HOLDS_FOR: u8 = 10;
/// Bytes of a covariance.
pub const COVARIANCE_BYTES: usize = 45 * 4;
/// Bytes of the tilts that a calibration holds for.
pub const HOLDS_FOR_BYTES: usize = 8 * 4;
/// Bytes of a record without effects.
pub const RECORD_BYTES: usize = 148;
/// The longest record: any four different effects of the catalogue fit, whatever their columns are called.
pub const MAX_RECORD_BYTES: usize = 512;

pub(super) const MAGIC: [u8; 4] = *b"IRON";
pub(super) const HEADER_BYTES: usize = 16;
pub(super) const LENGTH_AT: usize = 12;
pub(super) const CRC_BYTES: usize = 4;
/// Without a table: a record is checked a few times in a session, a table costs 1 KB of flash.
pub(super) const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// How a version with effects writes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EffectLayout {
    pub(super) short_errors: bool,
    pub(super) ranges: bool,
}

impl EffectLayout {
    /// `None` for a version without effects, or one that is not known.
    pub(super) const fn of(version: u8) -> Option<Self> {
        let (short_errors, ranges) = match version {
            VERSION_WITH_EFFECTS => (false, false),
            VERSION_SHORT_ERRORS => (true, false),
            VERSION_WITH_RANGES => (false, true),
            VERSION_WITH_RANGES_SHORT_ERRORS => (true, true),
            _ => return None,
        };
        Some(Self { short_errors, ranges })
    }
}

/// Why bytes are no record that can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RecordError {
    /// Nothing was ever written there, or it was erased: all bytes 0xff or all 0.
    Empty,
    /// Something is there, but not a whole record: a write that power cut short, or flipped bits.
    Torn,
    /// A sound record of a layout this program does not know.
    Unsupported {
        /// Version of its layout.
        version: u8,
        /// Its sequence number.
        sequence: u32,
    },
    /// The checksum is right and the numbers are no calibration (not finite, singular, unknown method).
    Unsound {
        /// Its sequence number.
        sequence: u32,
    },
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RecordError::Empty => f.write_str("empty"),
            RecordError::Torn => f.write_str("torn"),
            RecordError::Unsupported { version, .. } => write!(f, "unsupported-version-{version}"),
            RecordError::Unsound { .. } => f.write_str("unsound"),
        }
    }
}

impl core::error::Error for RecordError {}

/// How many bytes the record says it has, from its beginning in `bytes`; `None` where that is no beginning of a record, or too
/// little of one.
pub(crate) fn stated_length(bytes: &[u8]) -> Option<usize> {
    let mut reader = Reader { bytes, at: 0 };
    if reader.take::<4>().ok()? != MAGIC {
        return None;
    }
    reader.at = LENGTH_AT;
    let length = usize::from(u16::from_le_bytes(reader.take().ok()?));
    (HEADER_BYTES + CRC_BYTES..=MAX_RECORD_BYTES).contains(&length).then_some(length)
}

/// The version without tilts that a version is made of, and whether they are behind it.
pub(super) const fn without_holds_for(version: u8) -> (u8, bool) {
    if WITH_HOLDS_FOR < version && version <= 2 * WITH_HOLDS_FOR {
        (version - WITH_HOLDS_FOR, true)
    } else {
        (version, false)
    }
}

/// The version without a covariance that a version is made of, and whether one is behind it.
pub(super) const fn without_covariance(version: u8) -> (u8, bool) {
    if VERSION_WITH_RANGES_SHORT_ERRORS < version
        && version <= VERSION_WITH_RANGES_SHORT_ERRORS + WITH_COVARIANCE
    {
        (version - WITH_COVARIANCE, true)
    } else {
        (version, false)
    }
}

pub(super) fn check_crc(bytes: &[u8], length: usize) -> Result<(), RecordError> {
    if !(HEADER_BYTES + CRC_BYTES..=MAX_RECORD_BYTES).contains(&length) {
        return Err(RecordError::Torn);
    }
    let covered = bytes.get(..length - CRC_BYTES).ok_or(RecordError::Torn)?;
    let stored = Reader { bytes, at: length - CRC_BYTES }.take()?;
    if CRC.checksum(covered) == u32::from_le_bytes(stored) { Ok(()) } else { Err(RecordError::Torn) }
}

pub(super) struct Writer {
    pub(super) bytes: [u8; MAX_RECORD_BYTES],
    pub(super) at: usize,
}

impl Writer {
    /// Writes what fits and counts all of it.
    pub(super) fn put(&mut self, value: &[u8]) {
        let end = self.at + value.len();
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.copy_from_slice(value);
        }
        self.at = end;
    }

    pub(super) fn float(&mut self, value: f64) {
        self.put(&value.to_le_bytes());
    }
}

pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn slice(&mut self, length: usize) -> Result<&'a [u8], RecordError> {
        let slice = self.bytes.get(self.at..self.at + length).ok_or(RecordError::Torn)?;
        self.at += length;
        Ok(slice)
    }

    pub(super) fn take<const N: usize>(&mut self) -> Result<[u8; N], RecordError> {
        self.slice(N)?.try_into().map_err(|_| RecordError::Torn)
    }

    pub(super) fn float(&mut self) -> Result<f64, RecordError> {
        self.take().map(f64::from_le_bytes)
    }

    pub(super) fn single(&mut self) -> Result<f32, RecordError> {
        self.take().map(f32::from_le_bytes)
    }
}
