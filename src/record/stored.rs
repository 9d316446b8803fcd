//! The way of a record into bytes and back.

use core::fmt;

use super::content::Record;
use super::covariance::Covariance;
#[cfg(feature = "effects")]
use super::effect;
use super::holds_for::HoldsFor;
use super::layout::{
    COVARIANCE_BYTES, CRC, CRC_BYTES, HOLDS_FOR_BYTES, LENGTH_AT, MAGIC, MAX_RECORD_BYTES, RECORD_BYTES,
    Reader, RecordError, VERSION, WITH_COVARIANCE, WITH_HOLDS_FOR, Writer, check_crc, without_covariance,
    without_holds_for,
};
#[cfg(feature = "effects")]
use super::layout::{
    EffectLayout, VERSION_SHORT_ERRORS, VERSION_WITH_EFFECTS, VERSION_WITH_RANGES,
    VERSION_WITH_RANGES_SHORT_ERRORS,
};
use super::predicted::PredictedError;
use crate::calibration::Calibration;
#[cfg(feature = "effects")]
use crate::extended::Effects;
use crate::fit::{Method, Order};
use crate::sensor::AxisMap;

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
        write!(f, "the effects do not fit into a record of {MAX_RECORD_BYTES} bytes: drop one")
    }
}

impl core::error::Error for DoesNotFit {}

impl Record {
    /// The record's bytes.
    ///
    /// # Errors
    /// [`DoesNotFit`]; never without effects.
    pub fn encode(&self) -> Result<Encoded, DoesNotFit> {
        #[cfg(not(feature = "effects"))]
        let (version, shorter) = (VERSION, VERSION);
        #[cfg(feature = "effects")]
        let has_ranges = self.effects.iter().any(|fitted| fitted.ranges.iter().any(Option::is_some));
        #[cfg(feature = "effects")]
        let (version, shorter) = match (self.effects.is_empty(), has_ranges) {
            (true, _) => (VERSION, VERSION),
            (false, false) => (VERSION_WITH_EFFECTS, VERSION_SHORT_ERRORS),
            (false, true) => (VERSION_WITH_RANGES, VERSION_WITH_RANGES_SHORT_ERRORS),
        };
        let with_covariance = match self.covariance {
            Some(covariance) => self.encode_as(version, Some(covariance)),
            None => Err(DoesNotFit),
        };
        with_covariance
            .or_else(|DoesNotFit| self.encode_as(version, None))
            .or_else(|DoesNotFit| self.encode_as(shorter, None))
    }

    fn encode_as(&self, version: u8, covariance: Option<Covariance>) -> Result<Encoded, DoesNotFit> {
        let mut writer = Writer { bytes: [0; MAX_RECORD_BYTES], at: 0 };
        let effects = self.count_effects();
        writer.put(&MAGIC);
        let with_covariance = if covariance.is_some() { WITH_COVARIANCE } else { 0 };
        let with_tilts = if self.holds_for.is_some() { WITH_HOLDS_FOR } else { 0 };
        let stated = version + with_covariance + with_tilts;
        writer.put(&[stated, method_code(self.method), model_code(self.model), effects]);
        writer.put(&self.sequence.to_le_bytes());
        writer.put(&[0, 0, self.axes.map_or(0, AxisMap::code), self.predicted_error.code()]);
        let calibration = &self.calibration;
        writer.float(calibration.field_ut);
        for value in calibration.offset_ut.iter().chain(calibration.matrix.iter().flatten()) {
            writer.float(*value);
        }
        writer.put(&self.samples.to_le_bytes());
        writer.float(self.noise_ut);
        writer.float(self.rms_ut);
        #[cfg(feature = "effects")]
        if let Some(layout) = EffectLayout::of(version) {
            self.effects.iter().for_each(|fitted| effect::write(&mut writer, fitted, layout));
        }
        if let Some(covariance) = covariance {
            covariance.write(&mut writer);
        }
        if let Some(holds_for) = &self.holds_for {
            holds_for.write(&mut writer);
        }
        let end = writer.at;
        let length = end + CRC_BYTES;
        if length > MAX_RECORD_BYTES {
            return Err(DoesNotFit);
        }
        writer.at = LENGTH_AT;
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
        let [axes, predicted_error] = reader.take()?;
        check_crc(bytes, length)?;
        let (version_without, has_holds_for) = without_holds_for(version);
        let (version_without, has_covariance) = without_covariance(version_without);
        #[cfg(feature = "effects")]
        let layout = EffectLayout::of(version_without);
        let plain = RECORD_BYTES
            + if has_covariance { COVARIANCE_BYTES } else { 0 }
            + if has_holds_for { HOLDS_FOR_BYTES } else { 0 };
        let without_effects = version_without == VERSION && length == plain && count == 0;
        // Without the feature a record with effects is one of a layout that is not known: its calibration alone would be wrong.
        #[cfg(not(feature = "effects"))]
        let known = without_effects;
        #[cfg(feature = "effects")]
        let known = if layout.is_some() { length > plain && count > 0 } else { without_effects };
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
        #[cfg(feature = "effects")]
        let mut effects = Effects::none();
        #[cfg(feature = "effects")]
        if let Some(layout) = layout {
            for _ in 0..count {
                let fitted = effect::read(&mut reader, layout).ok_or(unsound)?;
                effects.push(fitted).map_err(|_| unsound)?;
            }
        }
        let covariance = match has_covariance {
            true => Some(Covariance::read(&mut reader).ok_or(unsound)?),
            false => None,
        };
        let holds_for = match has_holds_for {
            true => Some(HoldsFor::read(&mut reader).ok_or(unsound)?),
            false => None,
        };
        let calibration = Calibration { offset_ut, matrix, field_ut };
        let (Some(method), Some(model)) = (method_of(method), model_of(model)) else {
            return Err(unsound);
        };
        let axes = match axes {
            0 => None,
            code => Some(AxisMap::of_code(code).ok_or(unsound)?),
        };
        let predicted_error = PredictedError::of_code(predicted_error);
        let record = Self {
            sequence,
            calibration,
            #[cfg(feature = "effects")]
            effects,
            method,
            model,
            samples,
            noise_ut,
            rms_ut,
            axes,
            predicted_error,
            covariance,
            holds_for,
        };
        let numbers = noise_ut.is_finite() && rms_ut.is_finite() && record.is_sound();
        if numbers && reader.at == reader.bytes.len() { Ok(record) } else { Err(unsound) }
    }
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

const fn model_code(model: Order) -> u8 {
    match model {
        Order::Ellipsoid => 1,
        Order::AxisAligned => 2,
        Order::Sphere => 3,
    }
}

const fn model_of(code: u8) -> Option<Order> {
    match code {
        1 => Some(Order::Ellipsoid),
        2 => Some(Order::AxisAligned),
        3 => Some(Order::Sphere),
        _ => None,
    }
}
