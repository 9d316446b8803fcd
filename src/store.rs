//! Where a calibration is kept: two slots, of which one always holds the last good record.
//!
//! A new record goes into the slot that is *not* in use, and is read back before it counts. Power may fail at
//! any byte of the write: the slot in use was not touched, and the other one is recognised as torn. Of two
//! sound records the one with the newer sequence number is current and the other stale.

use core::fmt;

use embedded_storage::Storage;

use crate::record::{DoesNotFit, MAX_RECORD_BYTES, RECORD_BYTES, Record, RecordError, is_newer};

/// How often a slot is read or written before the store is called failed: a bus may lose a byte now and then.
const ATTEMPTS: u32 = 3;

/// One of the two places for a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Slot {
    /// The first one.
    A,
    /// The second one.
    B,
}

impl Slot {
    /// Both, in order.
    pub const BOTH: [Slot; 2] = [Slot::A, Slot::B];

    /// 0 or 1.
    pub const fn index(self) -> usize {
        match self {
            Slot::A => 0,
            Slot::B => 1,
        }
    }

    /// The one that is not this one.
    pub const fn other(self) -> Self {
        match self {
            Slot::A => Slot::B,
            Slot::B => Slot::A,
        }
    }
}

impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.index())
    }
}

/// Why the store did not do its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError {
    /// A slot could not be read.
    Read(Slot),
    /// A slot could not be written.
    Write(Slot),
    /// A slot was written, and reads back as something else.
    NotConfirmed(Slot),
    /// The record's effects take more room than a slot has.
    DoesNotFit,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StoreError::Read(slot) => write!(f, "slot {slot} cannot be read"),
            StoreError::Write(slot) => write!(f, "slot {slot} cannot be written"),
            StoreError::NotConfirmed(slot) => write!(f, "slot {slot} does not read back as written"),
            StoreError::DoesNotFit => DoesNotFit.fmt(f),
        }
    }
}

impl core::error::Error for StoreError {}

/// Memory that survives a restart, seen as two slots of [`MAX_RECORD_BYTES`].
///
/// For byte-writable memory (EEPROM, FRAM) use [`StorageSlots`]. On flash each slot is a page of its own that
/// `write_slot` erases first.
pub trait Store {
    /// Reads the first `bytes.len()` bytes of a slot.
    ///
    /// # Errors
    /// [`StoreError::Read`] where the memory does not answer.
    fn read_slot(&mut self, slot: Slot, bytes: &mut [u8]) -> Result<(), StoreError>;

    /// Writes the first `bytes.len()` bytes of a slot. Must leave the other slot alone.
    ///
    /// # Errors
    /// [`StoreError::Write`] where the memory does not take them.
    fn write_slot(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), StoreError>;
}

impl<S: Store + ?Sized> Store for &mut S {
    fn read_slot(&mut self, slot: Slot, bytes: &mut [u8]) -> Result<(), StoreError> {
        (**self).read_slot(slot, bytes)
    }
    fn write_slot(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), StoreError> {
        (**self).write_slot(slot, bytes)
    }
}

/// The two slots in any byte-writable [`embedded_storage::Storage`], one after the other from `base` on
/// (1024 bytes in all).
#[derive(Debug)]
pub struct StorageSlots<S> {
    storage: S,
    base: u32,
}

impl<S: Storage> StorageSlots<S> {
    /// The slots begin at byte `base` of `storage`.
    pub const fn new(storage: S, base: u32) -> Self {
        Self { storage, base }
    }

    /// Gives the storage back.
    pub fn destroy(self) -> S {
        self.storage
    }

    fn offset(&self, slot: Slot) -> u32 {
        self.base.saturating_add((slot.index() * MAX_RECORD_BYTES) as u32)
    }
}

impl<S: Storage> Store for StorageSlots<S> {
    fn read_slot(&mut self, slot: Slot, bytes: &mut [u8]) -> Result<(), StoreError> {
        self.storage.read(self.offset(slot), bytes).map_err(|_| StoreError::Read(slot))
    }

    fn write_slot(&mut self, slot: Slot, bytes: &[u8]) -> Result<(), StoreError> {
        self.storage.write(self.offset(slot), bytes).map_err(|_| StoreError::Write(slot))
    }
}

/// What stands in a slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SlotState {
    /// The record that counts.
    Current(Record),
    /// A sound record, older than the current one.
    Stale(Record),
    /// No usable record, and why.
    Unusable(RecordError),
    /// The memory did not answer.
    Unreadable,
}

impl fmt::Display for SlotState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SlotState::Current(record) => write!(f, "current-{}", record.sequence),
            SlotState::Stale(record) => write!(f, "stale-{}", record.sequence),
            SlotState::Unusable(why) => write!(f, "{why}"),
            SlotState::Unreadable => f.write_str("unreadable"),
        }
    }
}

/// Both slots, as found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slots {
    /// Slot A and slot B.
    pub states: [SlotState; 2],
}

impl Slots {
    /// Reads both slots and decides which record is current.
    pub fn inspect(store: &mut impl Store) -> Self {
        let [a, b] = Slot::BOTH.map(|slot| read(store, slot));
        let states = match (a, b) {
            (SlotState::Current(first), SlotState::Current(second)) => {
                if is_newer(second.sequence, first.sequence) {
                    [SlotState::Stale(first), SlotState::Current(second)]
                } else {
                    [SlotState::Current(first), SlotState::Stale(second)]
                }
            }
            other => [other.0, other.1],
        };
        Self { states }
    }

    /// The record in use and where it stands.
    pub fn current(&self) -> Option<(Slot, &Record)> {
        Slot::BOTH.into_iter().zip(&self.states).find_map(|(slot, state)| match state {
            SlotState::Current(record) => Some((slot, record)),
            _ => None,
        })
    }

    /// The first slot that did not answer, if any.
    pub fn unreadable(&self) -> Option<Slot> {
        Slot::BOTH.into_iter().zip(&self.states).find_map(|(slot, state)| match state {
            SlotState::Unreadable => Some(slot),
            _ => None,
        })
    }

    /// Where to write: never over the record in use, and rather over nothing than over a torn record.
    fn target(&self, in_use: Option<Slot>) -> Slot {
        if let Some(slot) = in_use.or(self.current().map(|(slot, _)| slot)) {
            return slot.other();
        }
        let empty = |slot: &Slot| {
            matches!(self.states.get(slot.index()), Some(SlotState::Unusable(RecordError::Empty)))
        };
        Slot::BOTH.into_iter().find(empty).unwrap_or(Slot::A)
    }

    /// The newest sequence number in either slot, of unusable records too.
    fn newest_sequence(&self) -> Option<u32> {
        let sequence = |state: &SlotState| match state {
            SlotState::Current(record) | SlotState::Stale(record) => Some(record.sequence),
            SlotState::Unusable(
                RecordError::Unsupported { sequence, .. } | RecordError::Unsound { sequence },
            ) => Some(*sequence),
            _ => None,
        };
        self.states.iter().filter_map(sequence).reduce(|a, b| if is_newer(b, a) { b } else { a })
    }
}

/// Reads one slot; a sound record is called current until it is compared with the other one.
///
/// A slot that looks torn is read again: a bit flipped on the bus must not make the record in use look like
/// one that may be overwritten.
fn read(store: &mut impl Store, slot: Slot) -> SlotState {
    let mut bytes = [0; MAX_RECORD_BYTES];
    let mut state = SlotState::Unreadable;
    for _ in 0..ATTEMPTS {
        if store.read_slot(slot, &mut bytes).is_err() {
            continue;
        }
        match Record::decode(&bytes) {
            Ok(record) => return SlotState::Current(record),
            Err(RecordError::Torn) => state = SlotState::Unusable(RecordError::Torn),
            Err(why) => return SlotState::Unusable(why),
        }
    }
    state
}

/// Writes `record` with the next sequence number into the slot that is not in use, reads it back, and returns
/// it as stored. `in_use` is the slot of the record in use, where the caller knows it: it is not touched, even
/// if it cannot be read properly now. When this fails, the record that was current still is, except where the
/// memory took the bytes and only failed to read them back.
///
/// # Errors
/// [`StoreError`], after three attempts. A slot that cannot be read before is an error too: without knowing
/// what it holds, the slot in use might be the one overwritten.
pub fn save(
    store: &mut impl Store,
    in_use: Option<Slot>,
    mut record: Record,
) -> Result<(Slot, Record), StoreError> {
    let slots = Slots::inspect(store);
    if let Some(slot) = slots.unreadable() {
        return Err(StoreError::Read(slot));
    }
    let target = slots.target(in_use);
    record.sequence = slots.newest_sequence().map_or(1, |newest| newest.wrapping_add(1));
    let encoded = record.encode().map_err(|DoesNotFit| StoreError::DoesNotFit)?;
    write_confirmed(store, target, encoded.as_bytes())?;
    Ok((target, record))
}

/// Erases both slots, the one in use last: when power fails between them, the current record still counts.
///
/// # Errors
/// [`StoreError`]; the record in use is then still there.
pub fn erase(store: &mut impl Store) -> Result<(), StoreError> {
    let slots = Slots::inspect(store);
    let last = slots.current().map_or(Slot::B, |(slot, _)| slot);
    for slot in [last.other(), last] {
        write_confirmed(store, slot, &[0xff; RECORD_BYTES])?;
    }
    Ok(())
}

fn write_confirmed(store: &mut impl Store, slot: Slot, wanted: &[u8]) -> Result<(), StoreError> {
    let mut result = Err(StoreError::Write(slot));
    for _ in 0..ATTEMPTS {
        let mut found = [0; MAX_RECORD_BYTES];
        let Some(found) = found.get_mut(..wanted.len()) else { return Err(StoreError::DoesNotFit) };
        result = store
            .write_slot(slot, wanted)
            .and_then(|()| store.read_slot(slot, found))
            .and_then(|()| if found == wanted { Ok(()) } else { Err(StoreError::NotConfirmed(slot)) });
        if result.is_ok() {
            break;
        }
    }
    result
}
