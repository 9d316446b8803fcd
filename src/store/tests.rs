//! A record's way into memory and back.

use super::job::{Done, StoreJob};
use super::memory::{Store, run};
use super::slot::{Slot, SlotState, StoreError};
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, ColumnName, Offset, Step};
use crate::extended::{Effects, FittedEffect};
use crate::fit::{Method, Order};
use crate::record::{MAX_RECORD_BYTES, Record, RecordError};
use crate::sensor::AxisMap;

/// Two slots of memory that never fails.
struct Ram([[u8; MAX_RECORD_BYTES]; 2]);

impl Store for Ram {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        bytes.copy_from_slice(&self.0[slot.index()][at..at + bytes.len()]);
        Ok(())
    }
    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        self.0[slot.index()][at..at + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

fn record() -> Record {
    let column = ColumnName::new("current_a").expect("a name");
    let fitted = |effect, first| {
        let mut fitted = FittedEffect::new(effect, [0.0; 9], [0.0; 9]);
        fitted.coefficients[..3].copy_from_slice(&[first, -1.0, 0.5]);
        fitted.std_errors[..3].copy_from_slice(&[0.25, 0.125, 0.5]);
        fitted
    };
    let offset = fitted(BuiltIn::Offset(Offset::linear(column, 1.5)), 2.0);
    let step = fitted(BuiltIn::Step(Step { at_s: 77.0 }), 3.0);
    Record {
        sequence: 0,
        calibration: Calibration { offset_ut: [30.0, -20.0, 10.0], ..Calibration::identity(50.0) },
        effects: Effects::of([Some(offset), Some(step), None, None]),
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.3,
        axes: Some(AxisMap::IDENTITY),
        predicted_error: crate::record::PredictedError::of_share(0.004),
        covariance: None,
        holds_for: None,
    }
}

#[test]
fn what_is_saved_with_its_effects_is_found_again_and_the_next_goes_into_the_other_slot() {
    let mut memory = Ram([[0xff; MAX_RECORD_BYTES]; 2]);
    let mut in_use = None;
    for (slot, sequence) in [(Slot::A, 1), (Slot::B, 2), (Slot::A, 3)] {
        let written = Record { sequence, ..record() };
        let saved = run(StoreJob::save(in_use, record()), &mut memory, |_| ());
        assert!(saved == Ok(Done::Saved(slot, written)), "{saved:?}");
        let found = run(StoreJob::inspect(), &mut memory, |_| ());
        let Ok(Done::Inspected(slots, Some(read))) = found else { panic!("{found:?}") };
        assert_eq!(read, written);
        assert_eq!(slots.current(), Some((slot, sequence)));
        in_use = Some(slot);
    }
}

#[test]
fn a_byte_that_memory_keeps_otherwise_is_noticed_before_the_record_counts() {
    /// Memory with one bit that sticks.
    struct Stuck(Ram);
    impl Store for Stuck {
        fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
            self.0.read_slot(slot, at, bytes)
        }
        fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
            self.0.write_slot(slot, at, bytes)?;
            self.0.0[slot.index()][150] = 0;
            Ok(())
        }
    }
    let mut memory = Stuck(Ram([[0xff; MAX_RECORD_BYTES]; 2]));
    let saved = run(StoreJob::save(None, record()), &mut memory, |_| ());
    assert!(saved == Err(StoreError::NotConfirmed(Slot::B)), "both slots were tried: {saved:?}");
    let found = run(StoreJob::inspect(), &mut memory, |_| ());
    let Ok(Done::Inspected(slots, None)) = found else { panic!("{found:?}") };
    assert!(matches!(slots.states, [SlotState::Unusable(_), SlotState::Unusable(_)]), "{slots:?}");
}

#[test]
fn a_record_is_numbered_above_one_of_newer_firmware_and_leaves_it_where_it_is() {
    let mut memory = Ram([[0xff; MAX_RECORD_BYTES]; 2]);
    let newer = Record { sequence: 41, ..record() }.encode().expect("it fits");
    let length = newer.as_bytes().len();
    let slot = &mut memory.0[0][..length];
    slot.copy_from_slice(newer.as_bytes());
    slot[4] = 9;
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&slot[..length - 4]);
    slot[length - 4..].copy_from_slice(&crc.to_le_bytes());
    let saved = run(StoreJob::save(None, record()), &mut memory, |_| ());
    let written = Record { sequence: 42, ..record() };
    assert!(saved == Ok(Done::Saved(Slot::B, written)), "{saved:?}");
    let found = run(StoreJob::inspect(), &mut memory, |_| ());
    let Ok(Done::Inspected(slots, Some(_))) = found else { panic!("{found:?}") };
    let unsupported = RecordError::Unsupported { version: 9, sequence: 41 };
    assert_eq!(slots.states, [SlotState::Unusable(unsupported), SlotState::Current(42)]);
}
