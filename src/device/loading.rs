//! A calibration on its way in over the console: kept apart until it is whole and sound.

use core::fmt;

use heapless::Vec;

use super::level_worse::LevelWorse;
use crate::extended::{Live, LiveError};
use crate::record::{MAX_RECORD_BYTES, Record, RecordError, stated_length};
use crate::sensor::AxisMap;

/// Bytes of the checksum that a record ends in.
const CRC_BYTES: usize = 4;

/// Why a line of the transfer was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NotTaken {
    /// There is no transfer to which it could belong.
    NotBegun,
    /// No record has so many bytes.
    Length,
    /// Another byte comes next.
    Next { received: usize, of: usize },
    /// It goes beyond the end.
    TooMuch { of: usize },
}

impl fmt::Display for NotTaken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotTaken::NotBegun => f.write_str("no calibration is being loaded: cal load begin first"),
            NotTaken::Length => write!(f, "a record has at most {MAX_RECORD_BYTES} bytes, and 5 at least"),
            NotTaken::Next { received, of } => {
                write!(f, "byte {received} of {of} is expected next; cal load begin starts again")
            }
            NotTaken::TooMuch { of } => {
                write!(f, "the announced record has {of} bytes; cal load begin starts again")
            }
        }
    }
}

/// Why what came is no calibration for this board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NotLoaded {
    /// It is not what was announced, or not what was sent.
    Crc,
    /// No record, or none that this firmware reads.
    Record(RecordError),
    /// It was made with the sensor mounted otherwise.
    Mounting,
    /// It cannot run on this board.
    Live(LiveError),
}

impl fmt::Display for NotLoaded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotLoaded::Crc | NotLoaded::Record(RecordError::Torn | RecordError::Empty) => {
                f.write_str("crc the received record is damaged; nothing has changed: send it again")
            }
            NotLoaded::Record(RecordError::Unsupported { version, .. }) => {
                write!(f, "unsupported this firmware does not read records of version {version}: update it")
            }
            NotLoaded::Record(RecordError::Unsound { .. }) => {
                f.write_str("unsound its numbers are not a valid calibration; nothing has changed")
            }
            NotLoaded::Mounting => f.write_str("mounting it was made with another mounting of the sensor"),
            NotLoaded::Live(error) => write!(f, "not-live {error}"),
        }
    }
}

/// Whether it can be applied on a board. Apart, because it works on whole calibrations, of a kilobyte each.
#[inline(never)]
fn can_run(record: &Record) -> Result<(), LiveError> {
    Live::new(&record.extended().on_own_clock().0.cast::<f32>()).map(|_| ())
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Nothing,
    Receiving {
        of: usize,
        crc: u32,
    },
    /// Whole and sound; it waits to be accepted.
    Waiting,
}

/// The transfer, and what came of the last one.
#[derive(Debug, Clone)]
pub(super) struct Loading {
    phase: Phase,
    bytes: Vec<u8, MAX_RECORD_BYTES>,
    /// Why what waits would not be better than the calibration in use, as its level turns show.
    pub(super) worse: Option<LevelWorse>,
}

impl Loading {
    pub(super) const fn nothing() -> Self {
        Self { phase: Phase::Nothing, bytes: Vec::new(), worse: None }
    }

    /// Drops whatever came so far.
    pub(super) fn forget(&mut self) {
        (self.phase, self.worse) = (Phase::Nothing, None);
        self.bytes.clear();
    }

    /// A record of `of` bytes follows; what came before is dropped.
    pub(super) fn begin(&mut self, of: usize, crc: u32) -> Result<(), NotTaken> {
        if !(CRC_BYTES + 1..=MAX_RECORD_BYTES).contains(&of) {
            return Err(NotTaken::Length);
        }
        self.forget();
        self.phase = Phase::Receiving { of, crc };
        Ok(())
    }

    /// Takes the bytes from `offset` on; how many there are then, and how many there will be.
    pub(super) fn take(&mut self, offset: usize, bytes: &[u8]) -> Result<(usize, usize), NotTaken> {
        let Phase::Receiving { of, .. } = self.phase else { return Err(NotTaken::NotBegun) };
        let received = self.bytes.len();
        if offset != received {
            return Err(NotTaken::Next { received, of });
        }
        if received + bytes.len() > of || self.bytes.extend_from_slice(bytes).is_err() {
            return Err(NotTaken::TooMuch { of });
        }
        Ok((self.bytes.len(), of))
    }

    /// Whether all of it came. Nothing is dropped where it did not.
    pub(super) fn is_whole(&self) -> Result<(), NotTaken> {
        match self.phase {
            Phase::Receiving { of, .. } if self.bytes.len() < of => {
                Err(NotTaken::Next { received: self.bytes.len(), of })
            }
            Phase::Receiving { .. } => Ok(()),
            Phase::Nothing | Phase::Waiting => Err(NotTaken::NotBegun),
        }
    }

    /// Checks the whole of it. Where it is no calibration for a board with this mounting it is dropped.
    pub(super) fn end(&mut self, axes: AxisMap) -> Result<Record, NotLoaded> {
        let checked = self.checked(axes);
        match &checked {
            Ok(_) => self.phase = Phase::Waiting,
            Err(_) => self.forget(),
        }
        checked
    }

    fn checked(&self, axes: AxisMap) -> Result<Record, NotLoaded> {
        let announced = match self.phase {
            Phase::Receiving { crc, .. } => crc,
            Phase::Nothing | Phase::Waiting => return Err(NotLoaded::Crc),
        };
        if self.bytes.last_chunk().copied().map(u32::from_le_bytes) != Some(announced) {
            return Err(NotLoaded::Crc);
        }
        let record = Record::decode(&self.bytes).map_err(NotLoaded::Record)?;
        // A record at the beginning of what was announced is not all of it.
        if stated_length(&self.bytes) != Some(self.bytes.len()) {
            return Err(NotLoaded::Crc);
        }
        if record.axes.is_some_and(|recorded| recorded != axes) {
            return Err(NotLoaded::Mounting);
        }
        match can_run(&record) {
            Ok(()) => Ok(record),
            Err(why) => Err(NotLoaded::Live(why)),
        }
    }

    /// Takes a calibration that came otherwise, and checks it as one that came line by line.
    pub(super) fn take_record(&mut self, record: &Record, axes: AxisMap) -> Result<Record, NotLoaded> {
        self.forget();
        let Ok(encoded) = record.encode() else { return Err(NotLoaded::Crc) };
        let bytes = encoded.as_bytes();
        let crc = bytes.last_chunk().copied().map_or(0, u32::from_le_bytes);
        self.phase = Phase::Receiving { of: bytes.len(), crc };
        // A record fits.
        let _ = self.bytes.extend_from_slice(bytes);
        self.end(axes)
    }

    /// Whether a calibration waits to be accepted.
    pub(super) fn waits(&self) -> bool {
        self.phase == Phase::Waiting
    }

    /// The calibration that waits to be accepted.
    pub(super) fn record(&self) -> Option<Record> {
        // It was sound when it came, and nothing has touched it since.
        if self.waits() { Record::decode(&self.bytes).ok() } else { None }
    }
}
