//! The stored calibration: a record of fixed size with a version and a CRC.
//!
//! All numbers are little-endian, all floats f64, so that what is read back has the bits that were written.
//!
//! | bytes | what |
//! |---|---|
//! | 0–3 | `IRON` |
//! | 4 | version of the layout ([`VERSION`]) |
//! | 5 | method of the fit, 6: its model, 7: number of effect terms (0 in version 1) |
//! | 8–11 | sequence number: of two sound records the newer counts |
//! | 12–13 | length of the record with its CRC, 14–15: reserved, 0 |
//! | 16–23 | `field_ut`, 24–47: `offset_ut`, 48–119: `matrix`, rows first |
//! | 120–127 | samples (u64), 128–135: `noise_ut`, 136–143: `rms_ut` |
//! | 144–… | effect terms, from version 2 on |
//! | last 4 | CRC-32 (ISO-HDLC) of everything before |
//!
//! The first 16 bytes and the place of the CRC belong to every version. So firmware that meets a newer record
//! can tell it from a damaged one, and a longer record is checked by its own length.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use crate::calibration::Calibration;
use crate::fit::{Method, Model};

/// The version of the layout that [`Record::encode`] writes.
pub const VERSION: u8 = 1;
/// Bytes of a record of this version.
pub const RECORD_BYTES: usize = 148;
/// The longest record that any version may have: 4 effect terms fit.
pub const MAX_RECORD_BYTES: usize = 512;

const MAGIC: [u8; 4] = *b"IRON";
const HEADER_BYTES: usize = 16;
const CRC_BYTES: usize = 4;
/// Without a table: a record is checked a few times in a session, a table costs 1 KB of flash.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// A calibration with where it comes from, as it is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Number of the record; each one written is one above the newest found (wrapping).
    pub sequence: u32,
    /// The calibration: offset, matrix, field.
    pub calibration: Calibration<f64>,
    /// The method of the fit.
    pub method: Method,
    /// The model the data carried.
    pub model: Model,
    /// Number of samples behind the fit.
    pub samples: u64,
    /// Estimated sensor noise, µT per axis.
    pub noise_ut: f64,
    /// Residual rms of the corrected magnitude, µT.
    pub rms_ut: f64,
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

/// Whether sequence number `a` is newer than `b`, on the circle of 32-bit numbers.
pub const fn is_newer(a: u32, b: u32) -> bool {
    a != b && a.wrapping_sub(b) < 1 << 31
}

impl Record {
    /// The record's bytes.
    pub fn encode(&self) -> [u8; RECORD_BYTES] {
        let mut bytes = [0; RECORD_BYTES];
        let mut writer = Writer { bytes: &mut bytes, at: 0 };
        writer.put(&MAGIC);
        writer.put(&[VERSION, method_code(self.method), model_code(self.model), 0]);
        writer.put(&self.sequence.to_le_bytes());
        writer.put(&(RECORD_BYTES as u16).to_le_bytes());
        writer.put(&[0, 0]);
        let calibration = &self.calibration;
        writer.put(&calibration.field_ut.to_le_bytes());
        for value in calibration.offset_ut.iter().chain(calibration.matrix.iter().flatten()) {
            writer.put(&value.to_le_bytes());
        }
        writer.put(&self.samples.to_le_bytes());
        writer.put(&self.noise_ut.to_le_bytes());
        writer.put(&self.rms_ut.to_le_bytes());
        let end = writer.at;
        let crc = CRC.checksum(bytes.get(..end).unwrap_or_default());
        Writer { bytes: &mut bytes, at: end }.put(&crc.to_le_bytes());
        bytes
    }

    /// Reads a record from the beginning of `bytes`; what follows it is not looked at.
    ///
    /// # Errors
    /// Each variant of [`RecordError`] names what is there instead.
    pub fn decode(bytes: &[u8]) -> Result<Self, RecordError> {
        let inspected = bytes.get(..RECORD_BYTES).unwrap_or(bytes);
        if inspected.iter().all(|&b| b == 0xff) || inspected.iter().all(|&b| b == 0) {
            return Err(RecordError::Empty);
        }
        let mut reader = Reader { bytes, at: 0 };
        if reader.take::<4>()? != MAGIC {
            return Err(RecordError::Torn);
        }
        let [version, method, model, terms] = reader.take()?;
        let sequence = u32::from_le_bytes(reader.take()?);
        let length = usize::from(u16::from_le_bytes(reader.take()?));
        let _reserved: [u8; 2] = reader.take()?;
        check_crc(bytes, length)?;
        if version != VERSION || length != RECORD_BYTES || terms != 0 {
            return Err(RecordError::Unsupported { version, sequence });
        }
        let field_ut = reader.float()?;
        let offset_ut = [reader.float()?, reader.float()?, reader.float()?];
        let mut matrix = [[0.0; 3]; 3];
        for value in matrix.iter_mut().flatten() {
            *value = reader.float()?;
        }
        let samples = u64::from_le_bytes(reader.take()?);
        let (noise_ut, rms_ut) = (reader.float()?, reader.float()?);
        let calibration = Calibration { offset_ut, matrix, field_ut };
        let (Some(method), Some(model)) = (method_of(method), model_of(model)) else {
            return Err(RecordError::Unsound { sequence });
        };
        if !calibration.is_sound() || !noise_ut.is_finite() || !rms_ut.is_finite() {
            return Err(RecordError::Unsound { sequence });
        }
        Ok(Self { sequence, calibration, method, model, samples, noise_ut, rms_ut })
    }
}

fn check_crc(bytes: &[u8], length: usize) -> Result<(), RecordError> {
    if !(HEADER_BYTES + CRC_BYTES..=MAX_RECORD_BYTES).contains(&length) {
        return Err(RecordError::Torn);
    }
    let covered = bytes.get(..length - CRC_BYTES).ok_or(RecordError::Torn)?;
    let stored = Reader { bytes, at: length - CRC_BYTES }.take()?;
    if CRC.checksum(covered) == u32::from_le_bytes(stored) { Ok(()) } else { Err(RecordError::Torn) }
}

const fn method_code(method: Method) -> u8 {
    match method {
        Method::Adjusted => 1,
        Method::Trace => 2,
        Method::Constant => 3,
    }
}

const fn method_of(code: u8) -> Option<Method> {
    match code {
        1 => Some(Method::Adjusted),
        2 => Some(Method::Trace),
        3 => Some(Method::Constant),
        _ => None,
    }
}

const fn model_code(model: Model) -> u8 {
    match model {
        Model::Ellipsoid => 1,
        Model::AxisAligned => 2,
        Model::Sphere => 3,
    }
}

const fn model_of(code: u8) -> Option<Model> {
    match code {
        1 => Some(Model::Ellipsoid),
        2 => Some(Model::AxisAligned),
        3 => Some(Model::Sphere),
        _ => None,
    }
}

struct Writer<'a> {
    bytes: &'a mut [u8; RECORD_BYTES],
    at: usize,
}

impl Writer<'_> {
    fn put(&mut self, value: &[u8]) {
        let end = self.at + value.len();
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.copy_from_slice(value);
        }
        self.at = end;
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], RecordError> {
        let slice = self.bytes.get(self.at..self.at + N).ok_or(RecordError::Torn)?;
        self.at += N;
        slice.try_into().map_err(|_| RecordError::Torn)
    }

    fn float(&mut self) -> Result<f64, RecordError> {
        self.take().map(f64::from_le_bytes)
    }
}
