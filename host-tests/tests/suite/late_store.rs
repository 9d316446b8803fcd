//! A memory that answers late, or not for a while: it is asked until it does, and what stands in it is put to work.

use crate::common::records::record;
use crate::common::{accepted_board, calibrate, last, value};
use ironout::device::{Action, Device, DeviceConfig, Pace, SensorAnswer, SensorTask, StoreAnswer};
use ironout::record::{MAX_RECORD_BYTES, Record};
use ironout::sensor::{Reading, Sensor};
use ironout::store::{Done, Slot, SlotState, Store, StoreError, StoreJob, run};
use ironout_rig::bus::Hit;

#[test]
fn an_eeprom_that_is_busy_after_power_up_is_asked_until_it_answers() {
    let mut board = accepted_board(31);
    let good = *board.device.record().expect("it was accepted");
    for busy_ms in [0, 20, 60, 100, 200, 1500] {
        let clock = board.clock.clone();
        let ready_ms = clock.ms() + busy_ms;
        board.store_faults.set(move |_, _| if clock.ms() < ready_ms { Hit::Nack } else { Hit::Pass });
        board.restart();
        // Nobody says a word on the console.
        let begun_ms = board.clock.ms();
        while board.device.record().is_none() && board.clock.ms() < begun_ms + 10_000 {
            board.run_ms(10);
        }
        let took_ms = board.clock.ms() - begun_ms;
        assert_eq!(board.device.record(), Some(&good), "busy for {busy_ms} ms");
        assert!(took_ms <= 2 * busy_ms + 100, "busy for {busy_ms} ms: after {took_ms} ms");
        board.run_ms(2000);
        assert_eq!(board.device.samples_lost(), 0, "busy for {busy_ms} ms");
        assert!(!board.command("status").concat().contains("+ store"), "busy for {busy_ms} ms");
    }
}

#[test]
fn a_store_whose_bus_is_freed_after_ten_minutes_is_reported_until_then_and_used_within_a_second() {
    let mut board = accepted_board(32);
    let good = board.command("cal show");
    board.store_faults.hold_bus();
    board.restart();
    board.run_ms(600_000);
    let status = board.command("status");
    let said = "+ store does not answer (slots=unreadable,unreadable): check its power and wiring; the firmware retries";
    assert!(status.iter().any(|line| line == said), "{status:?}");
    assert_eq!(value(&status[status.len() - 1], "calibrated"), "0");
    assert_eq!(board.device.samples_lost(), 0);
    board.store_faults.clear();
    board.run_ms(1100);
    assert!(board.device.calibration().is_some(), "nobody has asked");
    assert_eq!(board.command("cal show"), good);
    assert!(!board.command("status").concat().contains("+ store"));
}

#[test]
fn a_store_that_fails_in_operation_is_reported_and_asked_again_and_the_calibration_in_use_stays() {
    let mut board = accepted_board(33);
    let good = board.command("cal show");
    assert!(calibrate(&mut board, 55).starts_with("ok verdict=accepted"));
    board.store_faults.hold_bus();
    assert!(last(&mut board, "cal accept").starts_with("err store slot 0 cannot be read"));
    for _ in 0..3 {
        board.run_ms(5000);
        let status = board.command("status");
        assert!(status.iter().any(|line| line.starts_with("+ store does not answer ")), "{status:?}");
        assert_eq!(value(&status[status.len() - 1], "calibrated"), "1");
    }
    assert_eq!(board.command("cal show"), good);
    board.store_faults.clear();
    board.run_ms(1100);
    assert!(!board.command("status").concat().contains("+ store"));
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1 slot=1 sequence=2"));
    // A look of `version` alone shows it, too.
    board.store_faults.hold_bus();
    assert_eq!(board.command("version")[0], "+ slots=unreadable,unreadable");
    assert!(board.command("status").concat().contains("+ store does not answer"));
}

/// Every question to the store takes as long as a bus that is held does, and none is answered.
#[test]
fn a_store_that_never_answers_costs_no_sample() {
    for (question_ms, pace) in
        [(1, Pace::Every(20)), (3, Pace::Every(20)), (8, Pace::Every(20)), (3, Pace::EachConversion)]
    {
        let sensor = Sensor::uniform("a chip", 0.1, 50.0);
        let mut device = Device::new(DeviceConfig { board: "bench", sensor, pace });
        let mut out = heapless::String::<4096>::new();
        let (mut now_ms, mut samples, mut questions) = (0, 0, 0);
        while now_ms < 120_000 {
            match device.poll(now_ms, &mut out) {
                Action::Sensor(SensorTask::Start) => device.complete_sensor(SensorAnswer::Started, now_ms),
                Action::Sensor(SensorTask::Sample) => {
                    samples += 1;
                    let reading = Reading { counts: [300, samples as i16, 400], overflow: [false; 3] };
                    device.complete_sensor(SensorAnswer::Reading(reading), now_ms);
                }
                Action::Sensor(SensorTask::Temperature) => {
                    device.complete_sensor(SensorAnswer::Temperature(None), now_ms);
                }
                Action::Store(_) => {
                    questions += 1;
                    now_ms += question_ms;
                    device.complete_store(&StoreAnswer::Failed, now_ms);
                }
                Action::Again => {}
                Action::Sleep => now_ms = device.next_deadline_ms().max(now_ms + 1),
            }
        }
        assert_eq!(device.samples_lost(), 0, "{question_ms} ms, {pace:?}");
        assert!(samples >= 5900, "{question_ms} ms, {pace:?}: {samples}");
        // 32 each time, once a second or less often where they take long.
        assert!((2000..5000).contains(&questions), "{question_ms} ms, {pace:?}: {questions}");
    }
}

/// Two slots in memory. The reads of one fail as long as the other half of the test says so.
struct Waking {
    bytes: [[u8; MAX_RECORD_BYTES]; 2],
    /// A slot, and how many reads of it fail from now on.
    fails: (Slot, u32),
    writes: u32,
}

impl Store for Waking {
    fn read_slot(&mut self, slot: Slot, at: usize, bytes: &mut [u8]) -> Result<(), StoreError> {
        if slot == self.fails.0 && self.fails.1 > 0 {
            self.fails.1 -= 1;
            return Err(StoreError::Read(slot));
        }
        bytes.copy_from_slice(&self.bytes[slot.index()][at..at + bytes.len()]);
        Ok(())
    }
    fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
        self.writes += 1;
        self.bytes[slot.index()][at..at + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

#[test]
fn a_slot_that_answers_again_between_two_looks_is_not_taken_for_a_damaged_one() {
    let mut good = Waking { bytes: [[0xff; MAX_RECORD_BYTES]; 2], fails: (Slot::A, 0), writes: 0 };
    for number in 1..=2 {
        let saved = run(StoreJob::save(None, record(f64::from(number))), &mut good, |_| {});
        assert!(matches!(saved, Ok(Done::Saved(..))));
    }
    // Sequence 2 is in B, 1 in A.
    for (slot, states) in [
        (Slot::A, [SlotState::Damaged, SlotState::Current(2)]),
        (Slot::B, [SlotState::Current(1), SlotState::Damaged]),
    ] {
        // 16 tries a look; the third look decides.
        for failing in [0, 1, 16, 17, 32, 40, 47] {
            let mut memory = Waking { fails: (slot, failing), ..good };
            let found = run(StoreJob::inspect(), &mut memory, |_| {});
            let Ok(Done::Inspected(slots, Some(Record { sequence: 2, .. }))) = found else {
                panic!("{slot}, {failing} reads failed: {found:?}")
            };
            assert_eq!(slots.states, [SlotState::Stale(1), SlotState::Current(2)], "{slot}, {failing}");
        }
        let mut memory = Waking { fails: (slot, u32::MAX), ..good };
        let Ok(Done::Inspected(slots, Some(_))) = run(StoreJob::inspect(), &mut memory, |_| {}) else {
            panic!("one slot is sound")
        };
        assert_eq!(slots.states, states);
    }
    // Where the other one does not answer either, nothing is written.
    struct Silent(Waking);
    impl Store for Silent {
        fn read_slot(&mut self, slot: Slot, _: usize, _: &mut [u8]) -> Result<(), StoreError> {
            Err(StoreError::Read(slot))
        }
        fn write_slot(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), StoreError> {
            self.0.write_slot(slot, at, bytes)
        }
    }
    let mut silent = Silent(Waking { writes: 0, ..good });
    assert_eq!(run(StoreJob::save(None, record(3.0)), &mut silent, |_| {}), Err(StoreError::Read(Slot::A)));
    assert_eq!(silent.0.writes, 0);
}
