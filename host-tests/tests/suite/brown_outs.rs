//! What years bring: a dip of the supply in the middle of a transfer, a chip that comes back as another one, a terminal that nobody
//! reads for minutes.

use crate::common::{accepted_board, calibrate, last, value, world_board};
use ironout::device::{Action, Device, DeviceConfig, Output, Pace, SensorAnswer, SensorTask, StoreAnswer};
use ironout::sensor::{Reading, Sensor};
use ironout_rig::bus::Hit;
use ironout_simulation::Motion;
use std::cell::Cell;
use std::fmt;
use std::rc::Rc;

/// The firmware's queue in front of a port.
#[path = "../../../src/bin/firmware/board/outgoing.rs"]
mod outgoing;

#[test]
fn a_brown_out_at_any_byte_of_a_sample_costs_seconds_and_no_calibration() {
    let mut board = accepted_board(41);
    let good = board.command("cal show");
    // The question for data ready has four bytes on the wire, the reading nine.
    for (transaction, bytes) in [(0, 4), (1, 9)] {
        for byte in 0..bytes {
            let place = format!("transaction {transaction}, byte {byte}");
            let at = board.sensor_faults.transactions() + transaction;
            let (mag, dipped) = (board.mag.clone(), Rc::new(Cell::new(false)));
            let seen = dipped.clone();
            board.sensor_faults.set(move |t, b| {
                if (t, b) != (at, byte) {
                    return Hit::Pass;
                }
                // The chip forgets its configuration, and the rest of the transfer.
                mag.borrow_mut().power_cycle();
                seen.set(true);
                Hit::Nack
            });
            board.run_ms(2500);
            assert!(dipped.get(), "{place}");
            assert_eq!(board.device.sensor_fault(), None, "{place}: it was configured again");
            board.command("stream cal");
            board.run_ms(1000);
            let lines = board.received().iter().filter(|line| line.starts_with("C,")).count();
            assert!((48..=52).contains(&lines), "{place}: {lines} samples in a second");
            assert_eq!(last(&mut board, "stream off"), "ok stream=off");
            assert_eq!(board.command("cal show"), good, "{place}");
        }
    }
}

#[test]
fn a_brown_out_at_any_moment_of_storing_leaves_the_old_calibration_or_the_new_one_and_the_next_is_stored() {
    let mut board = accepted_board(42);
    let old = board.command("cal show");
    assert!(calibrate(&mut board, 55).starts_with("ok verdict=accepted"));
    let (memory, device) = (board.eeprom.borrow().memory.clone(), board.device.clone());
    let begun = board.store_faults.transactions();
    last(&mut board, "cal accept");
    let (new, transactions) = (board.command("cal show"), board.store_faults.transactions() - begun);
    for transaction in (0..40).chain((40..transactions).step_by(61)) {
        for byte in [0, 2, 7, 20] {
            let place = format!("transaction {transaction}, byte {byte}");
            board.eeprom.borrow_mut().memory.clone_from(&memory);
            board.device = device.clone();
            let at = board.store_faults.transactions() + transaction;
            let (eeprom, mag) = (board.eeprom.clone(), board.mag.clone());
            board.store_faults.set(move |t, b| {
                if (t, b) != (at, byte) {
                    return Hit::Pass;
                }
                eeprom.borrow_mut().power_cycle();
                mag.borrow_mut().power_cycle();
                Hit::Nack
            });
            // The processor lives on: it writes again what the memory has lost.
            let answer = last(&mut board, "cal accept");
            assert!(answer.starts_with("ok calibrated=1 slot=1 sequence=2"), "{place}: {answer}");
            board.store_faults.clear();
            board.restart();
            board.run_ms(2000);
            let shown = board.command("cal show");
            assert!(shown == new && shown != old, "{place}: {shown:?}");
        }
    }
}

#[test]
fn a_chip_that_comes_back_as_another_one_is_named_until_it_is_itself_again() {
    let mut board = world_board(Motion::Sphere, 43);
    board.run_ms(500);
    assert_eq!(last(&mut board, "cal start"), "ok state=collecting");
    board.run_ms(20_000);
    let n = |status: &str| value(status, "n").parse::<u64>().unwrap();
    let before = n(&last(&mut board, "status"));
    // A dip of the supply; the identity reads wrong as long as the voltage does.
    board.mag.borrow_mut().power_cycle();
    board.mag.borrow_mut().set_identity([0, 0, 0]);
    board.run_ms(60_000);
    let status = board.command("status");
    assert!(
        status[0].starts_with("+ sensor LSM303DLHC is another chip: identity [00, 00, 00]"),
        "{status:?}"
    );
    assert!(n(&status[status.len() - 1]) <= before + 2, "{status:?}");
    board.mag.borrow_mut().power_cycle();
    board.run_ms(3500);
    assert_eq!(board.device.sensor_fault(), None);
    // What was collected goes on, and is right.
    board.run_ms(40_000);
    let verdict = last(&mut board, "cal stop");
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    let offset = board.device.session().solution().unwrap().calibration.offset_ut;
    for (axis, offset) in offset.into_iter().enumerate() {
        assert!((offset - crate::common::HARD_IRON_UT[axis]).abs() < 0.1, "axis {axis}: {offset}");
    }
}

/// A terminal that has no room until it is read.
struct Unread {
    is_read: bool,
    text: String,
}

impl fmt::Write for Unread {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        assert!(self.is_read, "there is no room");
        self.text.push_str(text);
        Ok(())
    }
}

impl Output for Unread {
    fn takes(&self, _bytes: usize) -> bool {
        self.is_read
    }
}

#[test]
fn a_console_that_nobody_reads_for_ten_minutes_costs_no_sample_and_then_has_each_answer_once() {
    let sensor = Sensor::uniform("a chip", 0.1, 75.0);
    let mut device = Device::new(DeviceConfig { board: "bench", sensor, pace: Pace::Every(20) });
    let mut out = Unread { is_read: true, text: String::new() };
    let mut typed = b"stream raw\nversion\nstatus\nhelp\n".iter().copied().peekable();
    let (mut now_ms, mut samples, mut turns) = (0, 0_u32, 0_u32);
    while now_ms < 700_000 {
        // The first line is answered, then nothing is read for ten minutes.
        out.is_read = !(5_000..605_000).contains(&now_ms);
        if now_ms < 1_000 || now_ms >= 10_000 {
            while (now_ms >= 10_000 || typed.len() > 20)
                && typed.peek().is_some_and(|&byte| device.take_byte(byte))
            {
                typed.next();
            }
        }
        turns += 1;
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
            Action::Store(_) => device.complete_store(&StoreAnswer::Failed, now_ms),
            Action::Again => {}
            Action::Sleep => now_ms = device.next_deadline_ms().max(now_ms + 1),
        }
    }
    assert_eq!((device.samples_lost(), samples), (0, 35_000));
    assert!(turns < 400_000, "{turns} turns: it sleeps while nobody reads");
    let ends = out.text.lines().filter(|line| line.starts_with("ok"));
    let ends: Vec<&str> = ends.map(|line| line.split(['=', ' ']).nth(1).unwrap_or("help")).collect();
    assert_eq!(ends, ["stream", "ironout", "state", "help"], "each line once, in its order");
    // The stream goes on with what is measured now.
    let last = out.text.lines().rfind(|line| line.starts_with("R,")).unwrap();
    assert!(last.starts_with("R,6999"), "{last}");
}

#[test]
fn a_port_whose_other_end_stops_for_minutes_drops_whole_lines_and_goes_on_also_where_its_clock_wraps() {
    use heapless::spsc::Queue;
    use outgoing::Outgoing;
    // Microseconds, and the cycles of a counter of 25 MHz that wraps every 171 s.
    for per_ms in [1_000_u32, 25_000] {
        // As in the firmware it lives as long as the program.
        let (near, mut far) = Box::leak(Box::new(Queue::<u8, 256>::new())).split();
        let mut outgoing = Outgoing::new(near, 200 * per_ms);
        let (mut now, mut got, mut refused_ms) = (0_u32.wrapping_sub(60_000 * per_ms), String::new(), 0);
        for ms in 0..900_000_u32 {
            now = now.wrapping_add(per_ms);
            if ms % 20 == 0 {
                if outgoing.takes(16, now) {
                    outgoing.put(&format!("line {ms:08}\n"));
                } else {
                    refused_ms += 20;
                }
            }
            // Ten minutes are not read.
            if !(30_000..630_000).contains(&ms) {
                while let Some(byte) = far.dequeue() {
                    got.push(char::from(byte));
                }
            }
        }
        let lines: Vec<&str> = got.lines().collect();
        let whole =
            |line: &&str| line.len() == 13 && line.starts_with("line ") && line[5..].parse::<u32>().is_ok();
        let broken = lines.iter().filter(|line| !whole(line)).count();
        assert!(broken <= 1, "{per_ms}: {broken} lines are broken");
        assert!(lines.len() >= 14_999, "{per_ms}: {} lines", lines.len());
        assert_eq!(lines.last(), Some(&"line 00899980"), "{per_ms}");
        assert!(refused_ms <= 2000, "{per_ms}: commands waited for {refused_ms} ms");
    }
}
