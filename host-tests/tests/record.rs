//! The stored record and its two slots, in a memory that can be torn, flipped and broken.

use ironout::calibration::Calibration;
use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, Nonlinearity, Offset,
    Periodic, Power, Step,
};
use ironout::extended::{Effects, FittedEffect};
use ironout::fit::{Method, Model};
use ironout::record::{
    DoesNotFit, MAX_RECORD_BYTES, RECORD_BYTES, Record, RecordError, VERSION, VERSION_WITH_EFFECTS, is_newer,
};
use ironout::sensor::AxisMap;
use ironout::store::{
    BadPlace, Done, Slot, SlotState, Slots, StorageSlots, Store, StoreError, StoreJob, run,
};
use proptest::collection::vec;
use proptest::prelude::*;

fn record(offset_x_ut: f64) -> Record {
    Record {
        sequence: 0,
        calibration: Calibration {
            offset_ut: [offset_x_ut, -1.0 / 3.0, 1e-17],
            matrix: [[1.01, 0.02, -0.03], [0.0, 0.97, 0.1], [0.0, 0.0, 1.1]],
            field_ut: 48.123_456_789,
        },
        effects: Effects::none(),
        method: Method::Adjusted,
        model: Model::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.26,
        axes: None,
    }
}

fn bytes(record: &Record) -> Vec<u8> {
    record.encode().expect("it fits").as_bytes().to_vec()
}

fn fitted(effect: BuiltIn<f64>) -> FittedEffect<f64> {
    let k = Effect::<f64>::coefficients(&effect);
    FittedEffect {
        effect,
        coefficients: std::array::from_fn(|i| if i < k { 0.1 / (i + 1) as f64 } else { 0.0 }),
        // In single precision, as a record keeps them.
        std_errors: std::array::from_fn(|i| if i < k { f64::from(0.01_f32 / (i + 1) as f32) } else { 0.0 }),
    }
}

fn all_effects() -> [BuiltIn<f64>; 13] {
    let column = ColumnName::new("battery_current_a").expect("a name");
    let offset = |power, delay_s| BuiltIn::Offset(Offset { column, reference: 1.0 / 3.0, power, delay_s });
    [
        offset(Power::Linear, None),
        offset(Power::Squared, None),
        offset(Power::Linear, Some(0.1)),
        offset(Power::Squared, Some(0.1)),
        BuiltIn::Gain(Gain { column, reference: -0.7 }),
        BuiltIn::Field(AmbientField { column, reference: 1e-7 }),
        BuiltIn::Drift(Drift { reference_s: 61.7 }),
        BuiltIn::Step(Step { at_s: 12.34 }),
        BuiltIn::Lag(Lag),
        BuiltIn::Eddy(Eddy),
        BuiltIn::Nonlinearity(Nonlinearity),
        BuiltIn::CrossAxis(CrossAxis),
        BuiltIn::Periodic(Periodic { frequency_hz: 16.67, reference_s: 0.1 }),
    ]
}

fn with(effects: &[BuiltIn<f64>]) -> Record {
    let mut record = record(93.25);
    for effect in effects {
        record.effects.push(fitted(*effect)).expect("four at most");
    }
    record
}

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

#[test]
fn a_record_reads_back_to_the_same_bits() {
    let written = Record { sequence: 7, ..record(93.25) };
    let read = Record::decode(&bytes(&written)).unwrap();
    assert_eq!(read, written);
    assert_eq!(read.calibration.offset_ut[1].to_bits(), (-1.0_f64 / 3.0).to_bits());
    for method in [Method::Adjusted, Method::Trace, Method::Constant] {
        for model in [Model::Ellipsoid, Model::AxisAligned, Model::Sphere] {
            let written = Record { method, model, ..written };
            assert_eq!(Record::decode(&bytes(&written)), Ok(written));
        }
    }
}

#[test]
fn effects_read_back_to_the_same_bits() {
    for effect in all_effects() {
        let written = with(&[effect]);
        assert_eq!(Record::decode(&bytes(&written)), Ok(written), "{effect:?}");
        assert_eq!(bytes(&written)[4], VERSION_WITH_EFFECTS);
    }
    let usual = &all_effects()[..4];
    assert_eq!(Record::decode(&bytes(&with(usual))), Ok(with(usual)), "four of the usual kind fit");
}

#[test]
fn a_record_without_effects_is_one_that_older_firmware_reads() {
    let plain = bytes(&record(93.25));
    assert_eq!((plain.len(), plain[4], plain[7]), (RECORD_BYTES, VERSION, 0));
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
fn how_the_sensor_was_mounted_is_kept_and_a_mounting_that_is_none_is_unsound() {
    for code in 0..=48 {
        let written = Record { axes: AxisMap::of_code(code), ..record(1.0) };
        assert_eq!(bytes(&written)[14], code);
        assert_eq!(Record::decode(&bytes(&written)), Ok(written));
    }
    let mut odd = bytes(&record(1.0));
    odd[14] = 49;
    assert_eq!(Record::decode(&with_crc(odd)), Err(RecordError::Unsound { sequence: 0 }));
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

#[test]
fn a_record_with_effects_cut_or_flipped_anywhere_is_torn() {
    let good = bytes(&with(&all_effects()[2..5]));
    for bit in 0..good.len() * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Record::decode(&bad), Err(RecordError::Torn), "bit {bit}");
    }
    for length in 1..good.len() {
        assert_eq!(Record::decode(&good[..length]), Err(RecordError::Torn), "{length} bytes");
    }
    let sound = with(&all_effects()[..1]);
    let mut nan = sound;
    nan.effects = Effects::none();
    let mut broken = fitted(all_effects()[0]);
    broken.coefficients[1] = f64::NAN;
    nan.effects.push(broken).unwrap();
    assert_eq!(Record::decode(&bytes(&nan)), Err(RecordError::Unsound { sequence: 0 }));
}

#[test]
fn every_single_flipped_bit_is_noticed() {
    let good = bytes(&record(93.25));
    for bit in 0..RECORD_BYTES * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Record::decode(&bad), Err(RecordError::Torn), "bit {bit}");
    }
}

#[test]
fn a_record_cut_short_is_torn_and_nothing_is_empty() {
    let good = bytes(&record(93.25));
    for length in 1..RECORD_BYTES {
        assert_eq!(Record::decode(&good[..length]), Err(RecordError::Torn), "{length} bytes");
        let mut half = [0xff; MAX_RECORD_BYTES];
        half[..length].copy_from_slice(&good[..length]);
        assert_eq!(Record::decode(&half), Err(RecordError::Torn), "{length} bytes in erased memory");
    }
    for blank in [0x00, 0xff] {
        assert_eq!(Record::decode(&[blank; MAX_RECORD_BYTES]), Err(RecordError::Empty));
    }
}

fn with_crc(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let crc = bytes[..body].iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1)))
    });
    bytes[body..].copy_from_slice(&(!crc).to_le_bytes());
    bytes
}

#[test]
fn a_newer_layout_is_told_from_damage_and_unsound_numbers_are_refused() {
    let good = bytes(&Record { sequence: 9, ..record(1.0) });
    assert_eq!(with_crc(good.clone()), good, "the test's own checksum agrees with the record's");

    let mut longer = good.clone();
    longer.splice(144..144, [7; 88]);
    (longer[4], longer[7]) = (4, 1);
    longer[12..14].copy_from_slice(&236_u16.to_le_bytes());
    let newer = RecordError::Unsupported { version: 4, sequence: 9 };
    assert_eq!(Record::decode(&with_crc(longer)), Err(newer));

    for (at, value) in [(16, f64::NAN), (16, -48.0), (24, f64::INFINITY), (48, 0.0), (128, f64::NAN)] {
        let mut bad = good.clone();
        bad[at..at + 8].copy_from_slice(&value.to_le_bytes());
        assert_eq!(
            Record::decode(&with_crc(bad)),
            Err(RecordError::Unsound { sequence: 9 }),
            "{value} at {at}"
        );
    }
    let mut bad = good.clone();
    bad[5] = 99;
    assert_eq!(Record::decode(&with_crc(bad)), Err(RecordError::Unsound { sequence: 9 }));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_refused_by_name_or_read(
        bytes in prop_oneof![
            vec(any::<u8>(), 0..600),
            // A record with a few bytes changed and its checksum made right again.
            vec((0..200_usize, any::<u8>()), 0..6).prop_map(|changes| {
                let mut bytes = bytes(&with(&all_effects()[..2]));
                changes.into_iter().for_each(|(at, byte)| bytes[at] = byte);
                with_crc(bytes)
            }),
        ]
    ) {
        if let Ok(record) = Record::decode(&bytes) {
            // The reserved bytes are written as 0 whatever they were.
            let again = Record::decode(record.encode().expect("it fits").as_bytes());
            prop_assert_eq!(again, Ok(record));
            prop_assert!(record.calibration.is_sound());
        }
    }
}

/// What stands in the slots, and the current record.
fn inspect(store: &mut impl Store) -> (Slots, Option<Record>) {
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
fn sequence_numbers_are_compared_on_the_circle() {
    assert!(is_newer(2, 1) && !is_newer(1, 2) && !is_newer(1, 1));
    assert!(is_newer(0, u32::MAX) && !is_newer(u32::MAX, 0));
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
