//! The stored calibration under everything that happens to an EEPROM: the good one is never lost.

use crate::common::{accepted_board, calibrate, last, value, world_board};
use ironout::record::{COVARIANCE_BYTES, MAX_RECORD_BYTES, RECORD_BYTES};
use ironout_rig::board::SimBoard;
use ironout_rig::bus::Hit;
use ironout_rig::chips::TornPage;
use ironout_simulation::Motion;

/// Bytes of what a board stores of its own solution.
const STORED_BYTES: usize = RECORD_BYTES + COVARIANCE_BYTES;

/// A board with one calibration in use and another one solved, and what `cal show` says of the first.
fn board_with_a_second_solution(seed: u64) -> (SimBoard, Vec<String>) {
    let mut board = accepted_board(seed);
    let good = board.command("cal show");
    let verdict = calibrate(&mut board, 55);
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    (board, good)
}

#[test]
fn power_lost_at_any_byte_of_the_write_leaves_the_calibration_before_it() {
    let (mut board, good) = board_with_a_second_solution(21);
    let (memory, device) = (board.eeprom.borrow().memory.clone(), board.device.clone());
    for torn_page in [TornPage::Old, TornPage::Erased, TornPage::Garbage] {
        for cut in 0..STORED_BYTES {
            {
                let mut eeprom = board.eeprom.borrow_mut();
                eeprom.memory.clone_from(&memory);
                eeprom.torn_page = torn_page;
                eeprom.lose_power_after(cut);
            }
            board.device = device.clone();
            let answer = board.command("cal accept");
            assert!(
                answer.len() == 1 && answer[0].starts_with("err store "),
                "{torn_page:?} cut at {cut}: {answer:?}"
            );
            assert_eq!(board.command("cal show"), good, "{torn_page:?} cut at {cut}: before the restart");
            let status = last(&mut board, "status");
            assert_eq!((value(&status, "state"), value(&status, "calibrated")), ("solved", "1"));
            board.restart();
            assert_eq!(board.command("cal show"), good, "{torn_page:?} cut at {cut}: after the restart");
        }
    }
    // The next one goes where the torn record is, and all is well.
    board.device = device;
    assert_eq!(last(&mut board, "cal accept"), "ok calibrated=1 slot=1 sequence=2");
    let second = board.command("cal show");
    assert_ne!(second, good);
    board.restart();
    assert_eq!(board.command("cal show"), second);
    assert_eq!(board.command("version")[0], "+ slots=stale-1,current-2");
}

#[test]
fn every_flipped_bit_of_the_current_record_is_noticed_and_the_one_before_it_used() {
    let (mut board, first) = board_with_a_second_solution(22);
    last(&mut board, "cal accept");
    for bit in 0..8 * STORED_BYTES {
        let (at, mask) = (MAX_RECORD_BYTES + bit / 8, 1 << (bit % 8));
        board.eeprom.borrow_mut().memory[at] ^= mask;
        board.restart();
        assert_eq!(board.command("cal show"), first, "bit {bit}");
        board.eeprom.borrow_mut().memory[at] ^= mask;
    }
    board.eeprom.borrow_mut().memory[MAX_RECORD_BYTES + 30] ^= 1;
    board.restart();
    assert_eq!(board.command("version")[0], "+ slots=current-1,torn");
    board.eeprom.borrow_mut().memory[30] ^= 1;
    board.restart();
    assert_eq!(board.command("version")[0], "+ slots=torn,torn");
    assert!(last(&mut board, "cal show").starts_with("err state there is no calibration"));
    assert!(last(&mut board, "stream cal").starts_with("err state there is no calibration"));
}

#[test]
fn a_fault_at_any_byte_of_storing_is_overcome() {
    let (mut board, good) = board_with_a_second_solution(23);
    let (memory, device) = (board.eeprom.borrow().memory.clone(), board.device.clone());
    let begun = board.store_faults.transactions();
    last(&mut board, "cal accept");
    let second = board.command("cal show");
    assert_ne!(second, good);
    // Two slots read, five pages written with their polls, one slot read back; the polls are only tried now and then.
    let transactions = board.store_faults.transactions() - begun;
    let kinds: Vec<u64> = (0..4).chain((4..transactions).step_by(97)).chain([transactions - 1]).collect();
    for transaction in kinds {
        for byte in [0, 1, 2, 3, 4, 5, 20, 33, 34, 100] {
            for flip in [false, true] {
                board.eeprom.borrow_mut().memory.clone_from(&memory);
                board.device = device.clone();
                match flip {
                    true => board.store_faults.flip_at(transaction, byte, 0x10),
                    false => board.store_faults.nack_at(transaction, byte),
                }
                let answer = last(&mut board, "cal accept");
                let place = format!("transaction {transaction} byte {byte} flip {flip}: {answer}");
                assert!(answer.starts_with("ok calibrated=1 slot=1 sequence=2"), "{place}");
                board.store_faults.clear();
                board.restart();
                assert_eq!(board.command("cal show"), second, "{place}");
            }
        }
    }
}

#[test]
fn an_eeprom_that_fails_for_good_keeps_both_calibrations_for_another_try() {
    let (mut board, good) = board_with_a_second_solution(24);
    for fault in [Hit::Nack, Hit::Flip(1)] {
        board.store_faults.set(move |_, byte| if byte >= 4 { fault } else { Hit::Pass });
        let answer = board.command("cal accept");
        assert!(answer.len() == 1 && answer[0].starts_with("err store slot "), "{answer:?}");
        assert_eq!(board.command("cal show"), good);
    }
    board.store_faults.clear();
    board.bus.detach(0x50);
    let answer = last(&mut board, "cal accept");
    assert!(answer.starts_with("err store slot 0 cannot be read"), "{answer}");
    assert!(last(&mut board, "cal clear").starts_with("err store "));
    assert_eq!(board.command("cal show"), good);
    board.bus.attach(board.eeprom.clone());
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1 "));
}

#[test]
fn a_store_that_answers_late_is_read_with_the_next_line() {
    let mut board = accepted_board(25);
    let good = board.command("cal show");
    board.bus.detach(0x50);
    board.restart();
    board.run_ms(100);
    assert!(last(&mut board, "cal show").starts_with("err state there is no calibration"));
    assert_eq!(board.command("version")[0], "+ slots=unreadable,unreadable");
    board.bus.attach(board.eeprom.clone());
    assert_eq!(board.command("cal show"), good);
}

#[test]
fn cleared_is_cleared_for_good_and_ends_the_corrected_stream() {
    let mut board = accepted_board(26);
    assert_eq!(last(&mut board, "stream cal"), "ok stream=cal");
    assert_eq!(last(&mut board, "cal clear"), "ok calibrated=0");
    board.run_ms(500);
    assert_eq!(board.received(), [""; 0]);
    assert_eq!(board.command("version")[0], "+ slots=empty,empty");
    board.restart();
    assert_eq!(value(&last(&mut board, "status"), "calibrated"), "0");
}

#[test]
fn an_erased_eeprom_and_one_full_of_something_else_are_no_calibration() {
    let mut board = world_board(Motion::Sphere, 27);
    for (fill, slots) in
        [(0xff, "+ slots=empty,empty"), (0x00, "+ slots=empty,empty"), (0x5a, "+ slots=torn,torn")]
    {
        board.eeprom.borrow_mut().memory.fill(fill);
        board.restart();
        assert_eq!(board.command("version")[0], slots);
        assert_eq!(value(&last(&mut board, "status"), "calibrated"), "0");
    }
    board.run_ms(100);
    calibrate(&mut board, 55);
    assert!(last(&mut board, "cal accept").starts_with("ok "), "a memory full of something else can be used");
}
