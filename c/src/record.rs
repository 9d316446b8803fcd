//! A calibration as bytes that survive a restart.

use crate::calibration::IronoutCalibration;
use crate::error::IronoutError;
use crate::pointer;
use crate::session::{Collecting, IronoutSession};
use crate::state;
use ironout::record::{self, Record, RecordError};

/// The longest record. A record of a session has 328 bytes.
pub const IRONOUT_RECORD_BYTES: usize = 512;

const _: () = assert!(IRONOUT_RECORD_BYTES == record::MAX_RECORD_BYTES);

/// The code of what stands where a record is expected.
pub(crate) fn error_of(error: RecordError) -> IronoutError {
    match error {
        RecordError::Empty => IronoutError::IRONOUT_RECORD_EMPTY,
        RecordError::Torn => IronoutError::IRONOUT_RECORD_TORN,
        RecordError::Unsupported { .. } => IronoutError::IRONOUT_RECORD_UNSUPPORTED,
        RecordError::Unsound { .. } => IronoutError::IRONOUT_RECORD_UNSOUND,
    }
}

/// Writes the accepted calibration of a session to `bytes` as a record with a checksum, which the program `ironout` and
/// every firmware with this library read, and its length to `length`. `room` is the size of `bytes`; IRONOUT_RECORD_BYTES
/// is always enough. Of two stored records the one with the higher `sequence` is the newer: give the old record's plus
/// one, and write it to another place than the old one, so that a power cut leaves one of them whole.
///
/// IRONOUT_WRONG_STATE: there is no accepted calibration. IRONOUT_TOO_LITTLE_ROOM: nothing was written.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_record_encode(
    session: *const IronoutSession,
    sequence: u32,
    bytes: *mut u8,
    room: usize,
    length: *mut usize,
) -> IronoutError {
    let encoded = state::get::<Collecting>(session).and_then(Collecting::solved).and_then(|report| {
        let record = Record { sequence, ..Record::of(report) };
        // Without effects a record always fits.
        let encoded = record.encode().map_err(|_| IronoutError::IRONOUT_TOO_LITTLE_ROOM)?;
        pointer::write_bytes(bytes, room, encoded.as_bytes())?;
        pointer::write(length, encoded.as_bytes().len())
    });
    IronoutError::of(encoded)
}

/// Reads the calibration of a record at the beginning of `bytes`; bytes after the record are ignored, so that `length` may
/// be that of a whole slot. On an error `calibration` is left as it was, but for one:
///
/// IRONOUT_RECORD_HAS_EFFECTS: `calibration` was written, but is right only while every column of the effects is at its
/// reference: correct with ironout_live_apply.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_record_decode(
    bytes: *const u8,
    length: usize,
    calibration: *mut IronoutCalibration,
) -> IronoutError {
    let decoded = pointer::bytes(bytes, length).and_then(|bytes| {
        let record = Record::decode(bytes).map_err(error_of)?;
        pointer::write(calibration, IronoutCalibration::of_record(&record))?;
        if record.effects.is_empty() { Ok(()) } else { Err(IronoutError::IRONOUT_RECORD_HAS_EFFECTS) }
    });
    IronoutError::of(decoded)
}
