//! Memory that is waited for, and jobs done with it.

use core::fmt;

use embedded_storage::Storage;

use super::job::{Chunk, Done, StoreAnswer, StoreJob, StoreTask};
use super::slot::{Slot, StoreError};
use crate::record::MAX_RECORD_BYTES;

/// Memory that survives a restart, seen as two slots of [`MAX_RECORD_BYTES`].
///
/// For byte-writable memory (EEPROM, FRAM) use [`StorageSlots`]. On flash each slot is an erase unit of its own, erased by the
/// write at byte 0.
pub trait Store {
    /// Reads from byte `at` of a slot on.
    ///
    /// # Errors
    /// [`StoreError::Read`] where the memory does not answer, perhaps only because it is still writing, or where these bytes cannot be
    /// read: a flash with error correction has to say so with an error, and not with an interrupt or a fault.
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError>;

    /// Writes from byte `at` of a slot on, a multiple of [`CHUNK_BYTES`](super::CHUNK_BYTES) and ascending. Must leave the
    /// other slot alone.
    ///
    /// # Errors
    /// [`StoreError::Write`] where the memory does not take them, perhaps only because it is still writing;
    /// [`StoreError::HalfWritten`] where the same bytes cannot be written again without an erase.
    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError>;
}

impl<S: Store + ?Sized> Store for &mut S {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        (**self).read_slot(slot, at, bytes)
    }
    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        (**self).write_slot(slot, at, bytes)
    }
}

/// Does a task.
pub fn serve(store: &mut impl Store, task: &StoreTask) -> StoreAnswer {
    match task {
        StoreTask::Read { slot, at, length } => {
            let mut bytes = Chunk::new();
            let read = bytes.resize(*length, 0).is_ok() && store.read_slot(*slot, *at, &mut bytes).is_ok();
            if read { StoreAnswer::Read(bytes) } else { StoreAnswer::Failed }
        }
        StoreTask::Write { slot, at, bytes } => match store.write_slot(*slot, *at, bytes) {
            Ok(()) => StoreAnswer::Written,
            Err(StoreError::HalfWritten(_)) => StoreAnswer::HalfWritten,
            Err(_) => StoreAnswer::Failed,
        },
    }
}

/// Does a whole job; `wait_ms` lets that many milliseconds pass.
///
/// # Errors
/// [`StoreError`].
pub fn run(
    mut job: StoreJob,
    store: &mut impl Store,
    mut wait_ms: impl FnMut(u64),
) -> Result<Done, StoreError> {
    let mut now_ms = 0;
    loop {
        if let Some(outcome) = job.outcome() {
            return outcome;
        }
        match job.task(now_ms) {
            Some(task) => job.complete(&serve(store, &task), now_ms),
            None => {
                wait_ms(1);
                now_ms += 1;
            }
        }
    }
}

/// Why a storage has no two slots at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BadPlace {
    /// The slots would share a page: `base` and the length of a slot have to be multiples of `page_bytes`.
    SharedPage {
        /// The first byte.
        base: u32,
        /// Bytes of a page.
        page_bytes: u32,
    },
    /// They reach beyond the end.
    BeyondEnd {
        /// One past the last byte.
        end: u64,
        /// Bytes there are.
        capacity: usize,
    },
}

impl fmt::Display for BadPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BadPlace::SharedPage { base, page_bytes } => write!(
                f,
                "slots of {MAX_RECORD_BYTES} bytes from byte {base} on would share a page of {page_bytes} bytes"
            ),
            BadPlace::BeyondEnd { end, capacity } => {
                write!(f, "the slots end at byte {end} of a storage of {capacity}")
            }
        }
    }
}

impl core::error::Error for BadPlace {}

/// The two slots in any byte-writable [`embedded_storage::Storage`], one after the other from `base` on
/// (1024 bytes in all).
#[derive(Debug)]
pub struct StorageSlots<S> {
    storage: S,
    base: u32,
}

impl<S: Storage> StorageSlots<S> {
    /// The slots begin at byte `base` of `storage`, whose pages have `page_bytes` (1 where it has none). Power lost within a
    /// page may spoil all of it, so that no page may hold bytes of both slots or of anything else.
    ///
    /// # Errors
    /// [`BadPlace`].
    pub fn new(storage: S, base: u32, page_bytes: u32) -> Result<Self, BadPlace> {
        const SLOT_BYTES: u32 = MAX_RECORD_BYTES as u32;
        let apart = |bytes: u32| bytes.checked_rem(page_bytes) == Some(0);
        if !apart(base) || !apart(SLOT_BYTES) {
            return Err(BadPlace::SharedPage { base, page_bytes });
        }
        let (end, capacity) = (u64::from(base) + 2 * u64::from(SLOT_BYTES), storage.capacity());
        // Offsets are of 32 bits.
        if end > u64::from(u32::MAX) || end > capacity as u64 {
            return Err(BadPlace::BeyondEnd { end, capacity });
        }
        Ok(Self { storage, base })
    }

    /// Gives the storage back.
    pub fn destroy(self) -> S {
        self.storage
    }

    /// Where bytes of a slot lie; `None` beyond its end.
    fn offset(&self, slot: Slot, at: usize, bytes: usize) -> Option<u32> {
        let fits = at.checked_add(bytes).is_some_and(|end| end <= MAX_RECORD_BYTES);
        fits.then(|| self.base + (slot.index() * MAX_RECORD_BYTES + at) as u32)
    }
}

impl<S: Storage> Store for StorageSlots<S> {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        let offset = self.offset(slot, at, bytes.len()).ok_or(StoreError::Read(slot))?;
        self.storage.read(offset, bytes).map_err(|_| StoreError::Read(slot))
    }

    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        let offset = self.offset(slot, at, bytes.len()).ok_or(StoreError::Write(slot))?;
        self.storage.write(offset, bytes).map_err(|_| StoreError::Write(slot))
    }
}
