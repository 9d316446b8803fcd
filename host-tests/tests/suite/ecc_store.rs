//! The store on flash with error correction, whose words cannot be read after a power cut until they are erased.

use crate::common::records::{all_effects, record, with};
use ironout::record::Record;
use ironout::store::{BothSlots, Done, FlashSlots, Slot, SlotState, StoreError, StoreJob, run};
use ironout_rig::chips::{EccFlash, SECTOR_BYTES, TornErase};
use std::collections::BTreeMap;

/// The slots lie in sectors 1 and 2 of four.
const BASE: u32 = SECTOR_BYTES as u32;

fn job<const WORD: usize>(flash: &mut EccFlash<WORD>, job: StoreJob) -> Result<Done, StoreError> {
    let mut slots = FlashSlots::new(flash.clone(), BASE).expect("two sectors");
    let done = run(job, &mut slots, |_| {});
    *flash = slots.destroy();
    done
}

fn inspect<const WORD: usize>(flash: &mut EccFlash<WORD>) -> (BothSlots, Option<Record>) {
    match job(flash, StoreJob::inspect()) {
        Ok(Done::Inspected(slots, record)) => (slots, record),
        other => panic!("{other:?}"),
    }
}

/// Saves as a board does after a start: with the slot in use, as far as there is one.
fn save<const WORD: usize>(flash: &mut EccFlash<WORD>, new: Record) -> Result<Done, StoreError> {
    let in_use = inspect(flash).0.current().map(|(slot, _)| slot);
    job(flash, StoreJob::save(in_use, new))
}

/// A flash with so many records saved before.
fn flash_with<const WORD: usize>(records: u32, torn_erase: TornErase) -> EccFlash<WORD> {
    let mut flash = EccFlash::new(4);
    flash.torn_erase = torn_erase;
    for number in 0..records {
        save(&mut flash, record(f64::from(number))).expect("nothing fails");
    }
    flash.power_cycle();
    flash
}

/// What stood in the slots after the cuts of a save, and how often.
#[derive(Default)]
struct Row {
    cuts: u32,
    old: u32,
    new: u32,
    next_works: u32,
    states: BTreeMap<String, u32>,
}

/// Cuts the power at every operation of a save into a slot, and at every operation of the save after that.
fn cut_everywhere<const WORD: usize>(before: u32, torn_erase: TornErase, new: &Record) -> (Slot, Row) {
    let mut row = Row::default();
    let whole = flash_with::<WORD>(before, torn_erase);
    let old = inspect(&mut whole.clone()).1;
    let mut uncut = whole.clone();
    let Ok(Done::Saved(slot, _)) = save(&mut uncut, *new) else { panic!("nothing fails") };
    for cut in 0..uncut.operations {
        let place = format!("{before} before, {torn_erase:?}, words of {WORD}, cut at {cut}");
        let mut flash = whole.clone();
        flash.lose_power_after(cut);
        assert!(save(&mut flash, *new).is_err(), "{place}");
        flash.power_cycle();
        let (slots, after) = inspect(&mut flash);
        let same = |a: Option<&Record>, b: &Record| {
            a.is_some_and(|a| Record { sequence: 0, ..*a } == Record { sequence: 0, ..*b })
        };
        row.cuts += 1;
        row.old += u32::from(after == old);
        row.new += u32::from(after != old && same(after.as_ref(), new));
        *row.states.entry(slots.states[slot.index()].to_string()).or_default() += 1;
        assert!(after == old || same(after.as_ref(), new), "{place}: {after:?}");
        // The other slot was not touched.
        assert_eq!(after.is_none(), before == 0, "{place}: {slots:?}");

        // The next save works, and is cut short in its turn.
        let mut next = flash.clone();
        let third = record(30.0);
        let saved = save(&mut next, third);
        assert!(matches!(saved, Ok(Done::Saved(..))), "{place}: the next save: {saved:?}");
        assert!(same(inspect(&mut next).1.as_ref(), &third), "{place}: the next save");
        row.next_works += 1;
        for second_cut in 0..next.operations {
            let mut flash = flash.clone();
            flash.lose_power_after(second_cut);
            assert!(save(&mut flash, third).is_err(), "{place}, then at {second_cut}");
            flash.power_cycle();
            let (slots, last) = inspect(&mut flash);
            assert!(last == after || same(last.as_ref(), &third), "{place}, then at {second_cut}: {slots:?}");
            assert!(save(&mut flash, record(40.0)).is_ok(), "{place}, then at {second_cut}: {slots:?}");
        }
    }
    (slot, row)
}

#[test]
fn a_power_cut_at_any_operation_leaves_the_old_record_or_the_new_one_and_the_next_save_works() {
    println!(
        "before | slot written | erase cut | cuts | old record | new record | next save works | slot after the cut"
    );
    for (before, expected) in [(0, Slot::A), (1, Slot::B), (2, Slot::A)] {
        for torn_erase in [TornErase::Unreadable, TornErase::Half, TornErase::Old] {
            let (slot, row) = cut_everywhere::<8>(before, torn_erase, &record(9.0));
            assert_eq!(slot, expected);
            let Row { cuts, old, new, next_works, states } = row;
            println!(
                "{before} | {slot} | {torn_erase:?} | {cuts} | {old} | {new} | {next_works} | {states:?}"
            );
            assert_eq!((cuts, old + new, next_works), (20, cuts, cuts), "an erase and nineteen words");
            assert!(states.get("damaged").is_some_and(|count| *count >= cuts - 1), "{states:?}");
        }
    }
    // Other words, and a record that fills its slot.
    let widest = with(&all_effects()[..4]);
    cut_everywhere::<4>(1, TornErase::Unreadable, &record(9.0));
    cut_everywhere::<16>(2, TornErase::Unreadable, &widest);
    cut_everywhere::<32>(1, TornErase::Half, &widest);
}

#[test]
fn a_power_cut_while_both_slots_are_erased_leaves_the_record_or_none_and_the_next_save_works() {
    for before in [1, 2] {
        let whole = flash_with::<8>(before, TornErase::Unreadable);
        let old = inspect(&mut whole.clone()).1;
        let mut uncut = whole.clone();
        job(&mut uncut, StoreJob::erase()).expect("nothing fails");
        for cut in 0..uncut.operations {
            let mut flash = whole.clone();
            flash.lose_power_after(cut);
            assert!(job(&mut flash, StoreJob::erase()).is_err());
            flash.power_cycle();
            let (slots, after) = inspect(&mut flash);
            assert!(after.is_none() || after == old, "cut at {cut}: {slots:?}");
            assert!(save(&mut flash, record(9.0)).is_ok(), "cut at {cut}: {slots:?}");
        }
    }
}

#[test]
fn a_chunk_that_fails_is_not_written_again_without_an_erase() {
    use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

    /// One write fails after its first word, as a disturbance does that is not there the next time.
    struct Disturbed {
        flash: EccFlash<8>,
        write: usize,
    }
    impl embedded_storage::nor_flash::ErrorType for Disturbed {
        type Error = <EccFlash<8> as embedded_storage::nor_flash::ErrorType>::Error;
    }
    impl ReadNorFlash for Disturbed {
        const READ_SIZE: usize = 8;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
            self.flash.read(offset, bytes)
        }
        fn capacity(&self) -> usize {
            self.flash.capacity()
        }
    }
    impl NorFlash for Disturbed {
        const WRITE_SIZE: usize = 8;
        const ERASE_SIZE: usize = SECTOR_BYTES;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
            self.flash.erase(from, to)
        }
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
            self.write = self.write.wrapping_sub(1);
            if self.write == 0 {
                self.flash.write(offset, &bytes[..8])?;
                // The same word a second time is what the flash refuses.
                return self.flash.write(offset, &[0; 8]);
            }
            self.flash.write(offset, bytes)
        }
    }

    for write in 1..=5 {
        let mut slots =
            FlashSlots::new(Disturbed { flash: flash_with(1, TornErase::Unreadable), write }, BASE)
                .expect("two sectors");
        let saved = run(StoreJob::save(Some(Slot::A), record(9.0)), &mut slots, |_| {});
        assert!(matches!(saved, Ok(Done::Saved(Slot::B, _))), "write {write}: {saved:?}");
        let mut flash = slots.destroy().flash;
        // Once more from the erase on: so many words as came until then, and all of them.
        assert_eq!(inspect(&mut flash).0.states, [SlotState::Stale(1), SlotState::Current(2)]);
    }
}

#[test]
fn a_slot_that_is_worn_out_costs_no_calibration_and_only_while_nothing_is_stored_no_slot() {
    // Nothing is stored: the other slot takes it.
    let mut flash = flash_with::<8>(0, TornErase::Unreadable);
    flash.wear_out(1);
    assert!(matches!(save(&mut flash, record(1.0)), Ok(Done::Saved(Slot::B, _))));
    // The slot in use is the other one: it stays, and so does its record.
    let before = inspect(&mut flash);
    assert_eq!(save(&mut flash, record(2.0)), Err(StoreError::Write(Slot::A)));
    assert_eq!(inspect(&mut flash), before);
}

#[test]
fn what_a_flash_reads_at_once_may_be_longer_than_what_is_asked_for() {
    use ironout::store::Store;
    let mut slots = FlashSlots::new(flash_with::<8>(1, TornErase::Old), BASE).expect("two sectors");
    let mut whole = [0; 512];
    slots.read_slot(Slot::A, 0, &mut whole).expect("it reads");
    assert!(Record::decode(&whole).is_ok());
    for (at, length) in [(0, 1), (3, 2), (7, 9), (29, 70), (140, 8), (504, 8), (511, 1)] {
        let mut some = vec![0; length];
        slots.read_slot(Slot::A, at, &mut some).expect("it reads");
        assert_eq!(some, whole[at..at + length], "{length} from {at} on");
    }
    assert_eq!(slots.read_slot(Slot::A, 510, &mut [0; 3]), Err(StoreError::Read(Slot::A)));
}
