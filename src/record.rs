//! The stored calibration: a record with a version and a CRC.
//!
//! All numbers are little-endian, all floats f64 unless said otherwise, so that what is read back has the bits that were
//! written.
//!
//! | bytes | what |
//! |---|---|
//! | 0–3 | `IRON` |
//! | 4 | version of the layout: 1 without effects, 2 with them |
//! | 5 | method of the fit, 6: its model, 7: number of effects (0 in version 1) |
//! | 8–11 | sequence number: of two sound records the newer counts |
//! | 12–13 | length of the record with its CRC, 14–15: reserved, 0 |
//! | 16–23 | `field_ut`, 24–47: `offset_ut`, 48–119: `matrix`, rows first |
//! | 120–127 | samples (u64), 128–135: `noise_ut`, 136–143: `rms_ut` |
//! | 144–… | the effects, from version 2 on |
//! | last 4 | CRC-32 (ISO-HDLC) of everything before |
//!
//! An effect is: its kind (one byte), bytes of its column's name (one byte), that name, its reference where it has one, then
//! its delay, time or frequency where it has one, its coefficients, and their standard errors in single precision.
//!
//! The first 16 bytes and the place of the CRC belong to every version. So firmware that meets a newer record can tell it
//! from a damaged one, and a longer record is checked by its own length. A record without effects is written in version 1,
//! so that firmware that knows no effects reads it.

mod effect;

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use crate::calibration::Calibration;
use crate::extended::{Effects, ExtendedCalibration};
use crate::fit::{Method, Order as Model};

/// The version of the layout of a record without effects …
pub const VERSION: u8 = 1;
/// … and of one with them.
pub const VERSION_WITH_EFFECTS: u8 = 2;
/// Bytes of a record without effects.
pub const RECORD_BYTES: usize = 148;
/// The longest record: any four different effects fit.
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
    /// The effects that belong to it.
    pub effects: Effects<f64>,
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

/// The bytes of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoded {
    bytes: [u8; MAX_RECORD_BYTES],
    length: usize,
}

impl Encoded {
    /// The bytes.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

/// The effects take more room than [`MAX_RECORD_BYTES`] leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DoesNotFit;

impl fmt::Display for DoesNotFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the effects do not fit into a record of {MAX_RECORD_BYTES} bytes: leave one out")
    }
}

impl core::error::Error for DoesNotFit {}

impl Record {
    /// Offset, matrix, field and effects.
    pub fn extended(&self) -> ExtendedCalibration<f64> {
        ExtendedCalibration { base: self.calibration, effects: self.effects }
    }

    /// The record's bytes.
    ///
    /// # Errors
    /// [`DoesNotFit`]; never without effects.
    pub fn encode(&self) -> Result<Encoded, DoesNotFit> {
        let mut writer = Writer { bytes: [0; MAX_RECORD_BYTES], at: 0 };
        let effects = self.effects.len() as u8;
        let version = if effects == 0 { VERSION } else { VERSION_WITH_EFFECTS };
        writer.put(&MAGIC);
        writer.put(&[version, method_code(self.method), model_code(self.model), effects]);
        writer.put(&self.sequence.to_le_bytes());
        let length_at = writer.at;
        writer.put(&[0; 4]);
        let calibration = &self.calibration;
        writer.float(calibration.field_ut);
        for value in calibration.offset_ut.iter().chain(calibration.matrix.iter().flatten()) {
            writer.float(*value);
        }
        writer.put(&self.samples.to_le_bytes());
        writer.float(self.noise_ut);
        writer.float(self.rms_ut);
        for fitted in self.effects.iter() {
            effect::write(&mut writer, fitted);
        }
        let end = writer.at;
        let length = end + CRC_BYTES;
        if length > MAX_RECORD_BYTES {
            return Err(DoesNotFit);
        }
        writer.at = length_at;
        writer.put(&(length as u16).to_le_bytes());
        writer.at = end;
        let crc = CRC.checksum(writer.bytes.get(..end).unwrap_or_default());
        writer.put(&crc.to_le_bytes());
        Ok(Encoded { bytes: writer.bytes, length })
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
        let [version, method, model, count] = reader.take()?;
        let sequence = u32::from_le_bytes(reader.take()?);
        let length = usize::from(u16::from_le_bytes(reader.take()?));
        let _reserved: [u8; 2] = reader.take()?;
        check_crc(bytes, length)?;
        let known = match version {
            VERSION => length == RECORD_BYTES && count == 0,
            VERSION_WITH_EFFECTS => length > RECORD_BYTES && count > 0,
            _ => false,
        };
        if !known {
            return Err(RecordError::Unsupported { version, sequence });
        }
        // From here on the bytes are those that were written: what does not fit was written wrongly.
        let unsound = RecordError::Unsound { sequence };
        reader.bytes = bytes.get(..length - CRC_BYTES).ok_or(RecordError::Torn)?;
        let field_ut = reader.float()?;
        let offset_ut = [reader.float()?, reader.float()?, reader.float()?];
        let mut matrix = [[0.0; 3]; 3];
        for value in matrix.iter_mut().flatten() {
            *value = reader.float()?;
        }
        let samples = u64::from_le_bytes(reader.take()?);
        let (noise_ut, rms_ut) = (reader.float()?, reader.float()?);
        let mut effects = Effects::none();
        for _ in 0..count {
            let fitted = effect::read(&mut reader).ok_or(unsound)?;
            effects.push(fitted).map_err(|_| unsound)?;
        }
        let calibration = Calibration { offset_ut, matrix, field_ut };
        let (Some(method), Some(model)) = (method_of(method), model_of(model)) else {
            return Err(unsound);
        };
        let record = Self { sequence, calibration, effects, method, model, samples, noise_ut, rms_ut };
        let numbers = noise_ut.is_finite() && rms_ut.is_finite() && record.extended().is_sound();
        if numbers && reader.at == reader.bytes.len() { Ok(record) } else { Err(unsound) }
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

struct Writer {
    bytes: [u8; MAX_RECORD_BYTES],
    at: usize,
}

impl Writer {
    /// Writes what fits and counts all of it.
    fn put(&mut self, value: &[u8]) {
        let end = self.at + value.len();
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.copy_from_slice(value);
        }
        self.at = end;
    }

    fn float(&mut self, value: f64) {
        self.put(&value.to_le_bytes());
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn slice(&mut self, length: usize) -> Result<&'a [u8], RecordError> {
        let slice = self.bytes.get(self.at..self.at + length).ok_or(RecordError::Torn)?;
        self.at += length;
        Ok(slice)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], RecordError> {
        self.slice(N)?.try_into().map_err(|_| RecordError::Torn)
    }

    fn float(&mut self) -> Result<f64, RecordError> {
        self.take().map(f64::from_le_bytes)
    }
}
