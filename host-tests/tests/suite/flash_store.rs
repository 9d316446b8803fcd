//! The two slots on flash that only clears bits, with power that fails at any byte or erase, and flash that writes words only.

use crate::common::records::{all_effects, record, with};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use ironout::record::Record;
use ironout::store::{BadPlace, Done, FlashSlots, Slot, StoreJob, run};

const SECTOR: usize = 4096;

/// Eight sectors; `WRITE` bytes are written at once.
struct Flash<const WRITE: usize> {
    bytes: Vec<u8>,
    /// Bytes and erases until the power is gone.
    left: usize,
    erases: [u32; 8],
}

impl<const WRITE: usize> Flash<WRITE> {
    fn new() -> Self {
        Self { bytes: vec![0xFF; 8 * SECTOR], left: usize::MAX, erases: [0; 8] }
    }
}

#[derive(Debug)]
struct Failed(NorFlashErrorKind);

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl<const WRITE: usize> ErrorType for Flash<WRITE> {
    type Error = Failed;
}

impl<const WRITE: usize> ReadNorFlash for Flash<WRITE> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        check_read(self, offset, bytes.len()).map_err(Failed)?;
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WRITE: usize> NorFlash for Flash<WRITE> {
    const WRITE_SIZE: usize = WRITE;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        check_erase(self, from, to).map_err(Failed)?;
        for sector in from as usize / SECTOR..to as usize / SECTOR {
            let cells = &mut self.bytes[sector * SECTOR..][..SECTOR];
            if self.left == 0 {
                return Err(Failed(NorFlashErrorKind::Other));
            }
            self.left -= 1;
            if self.left == 0 {
                // Half of the cells have arrived, and no byte of them whole.
                cells.iter_mut().enumerate().for_each(|(i, cell)| *cell |= 0x5A_u8.rotate_left(i as u32));
                return Err(Failed(NorFlashErrorKind::Other));
            }
            cells.fill(0xFF);
            self.erases[sector] += 1;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        check_write(self, offset, bytes.len()).map_err(Failed)?;
        for (cell, byte) in self.bytes[offset as usize..].iter_mut().zip(bytes) {
            if self.left == 0 {
                return Err(Failed(NorFlashErrorKind::Other));
            }
            self.left -= 1;
            *cell &= byte;
        }
        Ok(())
    }
}

fn current<const WRITE: usize>(slots: &mut FlashSlots<Flash<WRITE>>) -> Option<Record> {
    match run(StoreJob::inspect(), slots, |_| {}) {
        Ok(Done::Inspected(_, record)) => record,
        other => panic!("{other:?}"),
    }
}

fn every_cut<const WRITE: usize>(new: &Record) {
    let stored = |left| {
        let mut slots = FlashSlots::new(Flash::<WRITE>::new(), 2 * SECTOR as u32).unwrap();
        for sequence in 1..=3 {
            run(StoreJob::save(None, Record { sequence, ..record(1.0) }), &mut slots, |_| {}).unwrap();
        }
        let mut flash = slots.destroy();
        flash.left = left;
        let mut slots = FlashSlots::new(flash, 2 * SECTOR as u32).unwrap();
        let before = current(&mut slots).expect("the third");
        let saved = run(StoreJob::save(None, *new), &mut slots, |_| {});
        let mut flash = slots.destroy();
        let used = left - flash.left;
        flash.left = usize::MAX;
        let mut slots = FlashSlots::new(flash, 2 * SECTOR as u32).unwrap();
        let after = current(&mut slots).expect("a calibration, whatever happened");
        // Power may fail after the last byte that counts, too: then it is stored, and nobody was told.
        assert!(saved.is_err() || after != before, "cut after {left}");
        assert!(after == before || after == Record { sequence: 4, ..*new }, "cut after {left}: {after:?}");
        (used, slots.destroy())
    };
    let (all, flash) = stored(usize::MAX);
    // The neighbours were left alone, the slots took turns.
    assert_eq!(flash.erases, [0, 0, 2, 2, 0, 0, 0, 0]);
    for left in 0..all {
        stored(left);
    }
}

#[test]
fn power_cut_after_any_byte_or_in_an_erase_leaves_the_old_record_or_the_new_one() {
    for new in [record(7.0), with(&all_effects()[..4])] {
        every_cut::<1>(&new);
        every_cut::<4>(&new);
        every_cut::<8>(&new);
        every_cut::<32>(&new);
    }
}

#[test]
fn a_slot_takes_no_part_of_a_sector_and_ends_before_the_flash() {
    let place = |base| FlashSlots::new(Flash::<4>::new(), base).err();
    assert_eq!(place(6 * SECTOR as u32), None);
    assert_eq!(place(512), Some(BadPlace::SharedPage { base: 512, page_bytes: 4096 }));
    assert_eq!(place(7 * SECTOR as u32), Some(BadPlace::BeyondEnd { end: 9 * 4096, capacity: 8 * 4096 }));
}

#[test]
fn a_slot_is_not_read_or_written_beyond_its_end() {
    use ironout::store::{Store, StoreError};
    let mut slots = FlashSlots::new(Flash::<4>::new(), 0).unwrap();
    assert_eq!(slots.read_slot(Slot::A, 500, &mut [0; 32]), Err(StoreError::Read(Slot::A)));
    assert_eq!(slots.write_slot(Slot::B, 512, &[0; 32]), Err(StoreError::Write(Slot::B)));
    assert_eq!(slots.write_slot(Slot::B, 0, &[0; 33]), Err(StoreError::Write(Slot::B)));
}
