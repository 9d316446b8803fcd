//! The two slots of the store, in a memory that can be torn, flipped and broken.

use crate::common::records::{all_effects, bytes, record, with, with_crc};
use ironout::effect::{BuiltIn, CrossAxis, Eddy};
use ironout::record::{DoesNotFit, MAX_RECORD_BYTES, RECORD_BYTES, Record, RecordError};
use ironout::store::{
    BadPlace, BothSlots, Done, Slot, SlotState, StorageSlots, Store, StoreError, StoreJob, run,
};

/// 1024 bytes, of which the next `writes_left` may still be written; then the power is gone.
struct Memory {
    bytes: [u8; 2 * MAX_RECORD_BYTES],
    writes_left: usize,
    reads_fail: bool,
}

impl Memory {
    fn new() -> Self {
        Self { bytes: [0xff; 2 * MAX_RECORD_BYTES], writes_left: usize::MAX, reads_fail: false }
    }
}

impl Store for Memory {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        if self.reads_fail {
            return Err(StoreError::Read(slot));
        }
        let at = slot.index() * MAX_RECORD_BYTES + at;
        bytes.copy_from_slice(&self.bytes[at..at + bytes.len()]);
        Ok(())
    }

    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        for (i, &byte) in bytes.iter().enumerate() {
            if self.writes_left == 0 {
                return Err(StoreError::Write(slot));
            }
            self.writes_left -= 1;
            self.bytes[slot.index() * MAX_RECORD_BYTES + at + i] = byte;
        }
        Ok(())
    }
}

/// What stands in the slots, and the current record.
fn inspect(store: &mut impl Store) -> (BothSlots, Option<Record>) {
    match run(StoreJob::inspect(), store, |_| {}) {
        Ok(Done::Inspected(slots, record)) => (slots, record),
        other => panic!("{other:?}"),
    }
}

fn save(store: &mut impl Store, in_use: Option<Slot>, record: Record) -> Result<(Slot, Record), StoreError> {
    match run(StoreJob::save(in_use, record), store, |_| {})? {
        Done::Saved(slot, record) => Ok((slot, record)),
        other => panic!("{other:?}"),
    }
}

fn erase(store: &mut impl Store) -> Result<(), StoreError> {
    run(StoreJob::erase(), store, |_| {}).map(|done| assert_eq!(done, Done::Erased))
}

#[test]
fn records_alternate_between_the_slots_and_the_newer_is_current() {
    let mut memory = Memory::new();
    assert_eq!(inspect(&mut memory).0.states, [SlotState::Unusable(RecordError::Empty); 2]);
    for n in 1..=5_u32 {
        let (slot, stored) = save(&mut memory, None, record(f64::from(n))).unwrap();
        assert_eq!(slot, if n % 2 == 1 { Slot::A } else { Slot::B });
        assert_eq!(stored.sequence, n);
        let (slots, current) = inspect(&mut memory);
        assert_eq!((slots.current(), current), (Some((slot, n)), Some(stored)));
        if n > 1 {
            assert_eq!(slots.states[slot.other().index()], SlotState::Stale(n - 1));
        }
    }
}

#[test]
fn power_lost_at_any_byte_of_a_write_leaves_the_record_before_it() {
    let mut memory = Memory::new();
    let (_, first) = save(&mut memory, None, record(1.0)).unwrap();
    let (_, second) = save(&mut memory, None, record(2.0)).unwrap();
    let before = memory.bytes;
    for cut in 0..RECORD_BYTES {
        memory = Memory { bytes: before, writes_left: cut, reads_fail: false };
        assert_eq!(save(&mut memory, None, record(3.0)), Err(StoreError::Write(Slot::A)), "cut at {cut}");
        memory.writes_left = usize::MAX;
        let (slots, current) = inspect(&mut memory);
        assert_eq!((slots.current(), current), (Some((Slot::B, 2)), Some(second)), "cut at {cut}");
        match slots.states[0] {
            // Up to the first byte that differs, the old record is whole.
            SlotState::Stale(old) => assert!(old == first.sequence && cut <= 8, "cut at {cut}"),
            SlotState::Unusable(RecordError::Torn) => assert!(cut > 8, "cut at {cut}"),
            state => panic!("cut at {cut}: {state:?}"),
        }
        let (slot, third) = save(&mut memory, None, record(3.0)).unwrap();
        assert_eq!((slot, third.sequence), (Slot::A, 3), "the next write repairs the torn slot");
    }
}

#[test]
fn power_lost_while_erasing_never_brings_an_older_record_back() {
    let mut memory = Memory::new();
    save(&mut memory, None, record(1.0)).unwrap();
    let (_, second) = save(&mut memory, None, record(2.0)).unwrap();
    let before = memory.bytes;
    for cut in 0..2 * RECORD_BYTES {
        memory = Memory { bytes: before, writes_left: cut, reads_fail: false };
        assert!(erase(&mut memory).is_err());
        let (_, current) = inspect(&mut memory);
        assert!(current.is_none() || current == Some(second), "cut at {cut}: {current:?}");
    }
    memory = Memory { bytes: before, writes_left: usize::MAX, reads_fail: false };
    erase(&mut memory).unwrap();
    assert_eq!(inspect(&mut memory).0.states, [SlotState::Unusable(RecordError::Empty); 2]);
}

#[test]
fn nothing_is_written_into_a_memory_that_cannot_be_read() {
    let mut memory = Memory::new();
    save(&mut memory, None, record(1.0)).unwrap();
    let before = memory.bytes;
    memory.reads_fail = true;
    assert_eq!(save(&mut memory, None, record(2.0)), Err(StoreError::Read(Slot::A)));
    assert_eq!(memory.bytes, before);
    assert_eq!(inspect(&mut memory).0.states, [SlotState::Unreadable; 2]);
}

/// Flips one bit of the first `flips` reads, as a disturbed bus does.
struct Flipping<'a> {
    memory: &'a mut Memory,
    flips: usize,
}

impl Store for Flipping<'_> {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        self.memory.read_slot(slot, at, bytes)?;
        if self.flips > 0 && (at..at + bytes.len()).contains(&40) {
            self.flips -= 1;
            bytes[40 - at] ^= 4;
        }
        Ok(())
    }
    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        self.memory.write_slot(slot, at, bytes)
    }
}

#[test]
fn a_bit_flipped_on_the_bus_does_not_make_the_record_in_use_look_torn() {
    let mut memory = Memory::new();
    let (_, stored) = save(&mut memory, None, record(1.0)).unwrap();
    let mut flipping = Flipping { memory: &mut memory, flips: 2 };
    assert_eq!(inspect(&mut flipping).1, Some(stored));
    flipping.flips = usize::MAX;
    // When every read is disturbed, the slot known to be in use is left alone all the same.
    let attempt = save(&mut flipping, Some(Slot::A), record(2.0));
    assert_eq!(attempt, Err(StoreError::NotConfirmed(Slot::B)));
    assert_eq!(Record::decode(&memory.bytes), Ok(stored));
}

#[test]
fn effects_that_take_more_room_than_a_slot_are_refused_and_the_record_in_use_stays() {
    let widest =
        with(&[BuiltIn::Eddy(Eddy), BuiltIn::CrossAxis(CrossAxis), all_effects()[10], all_effects()[12]]);
    assert_eq!(Record::decode(&bytes(&widest)), Ok(widest), "the four widest different effects fit");
    let wide = with(&[BuiltIn::Eddy(Eddy); 4]);
    assert_eq!(wide.encode(), Err(DoesNotFit));
    let mut memory = Memory::new();
    save(&mut memory, None, record(1.0)).unwrap();
    let before = memory.bytes;
    assert_eq!(save(&mut memory, None, wide), Err(StoreError::DoesNotFit));
    assert_eq!(memory.bytes, before);
}

#[test]
fn a_sound_record_of_newer_firmware_is_neither_overwritten_nor_undercut() {
    let mut newer = bytes(&Record { sequence: 41, ..record(1.0) });
    newer[4] = 9;
    let newer = with_crc(newer);
    let mut memory = Memory::new();
    memory.bytes[..newer.len()].copy_from_slice(&newer);
    memory.bytes[MAX_RECORD_BYTES..][..200].fill(0x5a);
    let newer_state = SlotState::Unusable(RecordError::Unsupported { version: 9, sequence: 41 });
    assert_eq!(inspect(&mut memory).0.states, [newer_state, SlotState::Unusable(RecordError::Torn)]);
    let (slot, stored) = save(&mut memory, None, record(2.0)).unwrap();
    assert_eq!((slot, stored.sequence), (Slot::B, 42), "over the torn one, and newer than both");
    assert_eq!(inspect(&mut memory).0.states, [newer_state, SlotState::Current(42)]);
}

#[test]
fn slots_that_would_share_a_page_or_reach_beyond_the_end_are_refused() {
    struct Rom(usize);
    impl embedded_storage::ReadStorage for Rom {
        type Error = ();
        fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), ()> {
            Ok(())
        }
        fn capacity(&self) -> usize {
            self.0
        }
    }
    impl embedded_storage::Storage for Rom {
        fn write(&mut self, _: u32, _: &[u8]) -> Result<(), ()> {
            Ok(())
        }
    }
    let new = |capacity, base, page_bytes| StorageSlots::new(Rom(capacity), base, page_bytes).map(drop);
    for (base, page_bytes) in [(0, 1), (0, 32), (64, 64), (512, 128), (3, 1)] {
        assert_eq!(new(4096, base, page_bytes), Ok(()), "{base} {page_bytes}");
    }
    for (base, page_bytes) in [(16, 32), (0, 48), (0, 1024), (0, 0)] {
        assert_eq!(new(4096, base, page_bytes), Err(BadPlace::SharedPage { base, page_bytes }));
    }
    assert_eq!(new(1024, 0, 32), Ok(()));
    assert_eq!(new(1024, 32, 32), Err(BadPlace::BeyondEnd { end: 1056, capacity: 1024 }));
    assert!(new(usize::MAX, u32::MAX - 31, 32).is_err());
}
