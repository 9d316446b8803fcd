//! The two slots on flash: each an erase unit of its own, so that erasing one never touches the other.

use embedded_storage::nor_flash::NorFlash;

use super::job::CHUNK_BYTES;
use super::memory::{BadPlace, Store};
use super::slot::{Slot, StoreError};
use crate::record::MAX_RECORD_BYTES;

/// The two slots in NOR flash, on neighbouring erase units from `base` on.
///
/// A slot is erased when its first bytes are written, and again where writing fails half-way: no cell is programmed twice. Power that
/// fails while it is erased or written leaves the other slot as it was, and a torn record that its checksum tells, or with error
/// correction (STM32 G4, H7, L4, U5) one that cannot be read, which counts as empty. The slots take turns, so that a cell wears half as fast as calibrations are
/// accepted: at 100 000 erases a unit, 200 000 of them.
#[derive(Debug)]
pub struct FlashSlots<F> {
    flash: F,
    base: u32,
    /// Slots in which a write has failed since they were erased.
    half_written: [bool; 2],
}

impl<F: NorFlash> FlashSlots<F> {
    /// Bytes from one slot to the next: whole erase units.
    const STRIDE: u32 = MAX_RECORD_BYTES.next_multiple_of(F::ERASE_SIZE) as u32;

    /// The slots begin at byte `base` of the flash, where an erase unit does.
    ///
    /// # Errors
    /// [`BadPlace`].
    pub fn new(flash: F, base: u32) -> Result<Self, BadPlace> {
        const { assert!(CHUNK_BYTES.is_multiple_of(F::WRITE_SIZE), "WRITE_SIZE of 1, 2, 4, 8, 16 or 32") };
        const { assert!(CHUNK_BYTES.is_multiple_of(F::READ_SIZE), "READ_SIZE of 1, 2, 4, 8, 16 or 32") };
        if !base.is_multiple_of(F::ERASE_SIZE as u32) {
            return Err(BadPlace::SharedPage { base, page_bytes: F::ERASE_SIZE as u32 });
        }
        let (end, capacity) = (u64::from(base) + 2 * u64::from(Self::STRIDE), flash.capacity());
        if end > u64::from(u32::MAX) || end > capacity as u64 {
            return Err(BadPlace::BeyondEnd { end, capacity });
        }
        Ok(Self { flash, base, half_written: [false; 2] })
    }

    /// Gives the flash back.
    pub fn destroy(self) -> F {
        self.flash
    }

    const fn begin(&self, slot: Slot) -> u32 {
        self.base + slot.index() as u32 * Self::STRIDE
    }

    /// Where bytes of a slot lie; `None` beyond its end.
    fn offset(&self, slot: Slot, at: usize, bytes: usize) -> Option<u32> {
        let fits = at.checked_add(bytes).is_some_and(|end| end <= MAX_RECORD_BYTES);
        fits.then(|| self.begin(slot) + at as u32)
    }
}

impl<F: NorFlash> Store for FlashSlots<F> {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        let offset = self.offset(slot, at, bytes.len()).ok_or(StoreError::Read(slot))?;
        if F::READ_SIZE == 1 {
            return self.flash.read(offset, bytes).map_err(|_| StoreError::Read(slot));
        }
        // What the flash reads at once begins before these bytes and ends behind them, within the slot.
        let mut skipped = at % F::READ_SIZE;
        let (mut from, mut left) = (offset - skipped as u32, bytes);
        while !left.is_empty() {
            let mut chunk = [0; CHUNK_BYTES];
            let length = (skipped + left.len()).next_multiple_of(F::READ_SIZE).min(CHUNK_BYTES);
            let read = chunk.get_mut(..length).ok_or(StoreError::Read(slot))?;
            self.flash.read(from, read).map_err(|_| StoreError::Read(slot))?;
            let wanted = read.get(skipped..).unwrap_or_default();
            let (now, later) = left.split_at_mut(wanted.len().min(left.len()));
            now.iter_mut().zip(wanted).for_each(|(to, from)| *to = *from);
            (from, left, skipped) = (from + length as u32, later, 0);
        }
        Ok(())
    }

    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        // The end of a record is filled up to what the flash writes at once: with ones, which are no change.
        let mut chunk = [0xFF; CHUNK_BYTES];
        let length = bytes.len().next_multiple_of(F::WRITE_SIZE);
        let (Some(place), Some(offset)) = (chunk.get_mut(..bytes.len()), self.offset(slot, at, length))
        else {
            return Err(StoreError::Write(slot));
        };
        place.copy_from_slice(bytes);
        let begin = self.begin(slot);
        let [a, b] = &mut self.half_written;
        let half_written = match slot {
            Slot::A => a,
            Slot::B => b,
        };
        if at == 0 {
            *half_written = self.flash.erase(begin, begin + Self::STRIDE).is_err();
        }
        if !*half_written {
            let padded = chunk.get(..length).unwrap_or_default();
            *half_written = self.flash.write(offset, padded).is_err();
        }
        if *half_written { Err(StoreError::HalfWritten(slot)) } else { Ok(()) }
    }
}
