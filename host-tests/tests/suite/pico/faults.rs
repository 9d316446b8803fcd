//! Faults of the firmware itself leave a trace and restart it, its calibration in use as before.

use crate::pico::support::{ask, board, figure, firmware, ok, record, store};
use ironout_rig::pico::{self, Pico};

/// An address where nothing is: the end of the peripherals.
const NOWHERE: u32 = 0x6000_0000;
/// RAM that nothing uses, for an endless loop.
const LOOP: u32 = 0x2003_8000;

/// Lets the board restart, and returns what it says of the fault.
fn last_fault(board: &mut Pico, ms: u64) -> String {
    board.run_ms(ms).unwrap();
    assert!(board.take_streamed().is_empty(), "a banner");
    let version = ok(board, "version");
    assert_eq!(ok(board, "status").value("calibrated"), Some("1"), "{version}");
    let fault = version.info.iter().find_map(|line| line.strip_prefix("last_fault="));
    fault.unwrap_or_else(|| panic!("no trace of the fault: {version}")).to_owned()
}

fn calibrated() -> Pico {
    let (mut board, _chip) = board(10.0);
    store(&mut board, 0, &record(1, 12.5));
    // Beyond the time within which a fault counts as one of the start.
    board.run_ms(1_500).unwrap();
    assert_eq!(figure(&ok(&mut board, "status"), "faults"), 0.0);
    board
}

#[test]
fn panic_hard_fault_and_watchdog_leave_their_traces_and_the_board_goes_on() {
    if !pico::available("faults") {
        return;
    }
    let mut board = calibrated();
    board.jump(Some(NOWHERE), None).unwrap();
    let fault = last_fault(&mut board, 1_500);
    assert!(fault.starts_with("hard fault pc=0x60000000"), "{fault}");

    let unexpected = firmware().symbol("DefaultHandler").unwrap() as u32 & !1;
    board.jump(Some(unexpected), None).unwrap();
    let fault = last_fault(&mut board, 1_500);
    assert!(fault.starts_with("panic at src/bin/firmware/fault.rs:"), "{fault}");
    assert!(fault.contains("unexpected interrupt"), "{fault}");

    // The loop stands still while interrupts come: the sampler alone does not feed the watchdog.
    board.set_memory(LOOP.into(), &0xE7FE_u16.to_le_bytes()).unwrap();
    board.jump(Some(LOOP), None).unwrap();
    let fault = last_fault(&mut board, 3_500);
    assert!(fault.starts_with("watchdog"), "{fault}");

    // Interrupts stand still while the loop turns: it does not feed it either.
    let sampler_interrupt = 1 << 1;
    board.set_memory(0xE000_E180, &u32::to_le_bytes(sampler_interrupt)).unwrap();
    let fault = last_fault(&mut board, 3_500);
    assert!(fault.starts_with("watchdog"), "{fault}");

    assert_eq!(figure(&ok(&mut board, "status"), "faults"), 4.0);
    let state = board.state().unwrap();
    assert_eq!(state.resets.len(), 4, "{state:?}");

    // A power cycle, and the board starts afresh.
    board.power_cycle().unwrap();
    board.run_ms(200).unwrap();
    assert_eq!(figure(&ok(&mut board, "status"), "faults"), 0.0);
}

#[test]
fn a_firmware_that_fails_at_every_start_ends_in_one_that_only_answers() {
    if !pico::available("faults at the start") {
        return;
    }
    let mut board = calibrated();
    for _ in 0..5 {
        board.jump(Some(NOWHERE), None).unwrap();
        board.run_ms(100).unwrap();
    }
    let status = ok(&mut board, "status");
    assert!(status.info[0].contains("is not used after repeated faults"), "{status}");
    assert_eq!((status.value("calibrated"), status.value("faults")), (Some("0"), Some("5")));
    assert_eq!(ask(&mut board, "cal start").code(), Some("sensor"));
    // Where even that fails, there is no restart any more, and the console says why; nor does the watchdog make one.
    for _ in 0..3 {
        board.jump(Some(NOWHERE), None).unwrap();
        board.run_ms(100).unwrap();
    }
    for _ in 0..2 {
        assert_eq!(ask(&mut board, "status").code(), Some("busy"));
        board.run_ms(2_600).unwrap();
    }
    board.power_cycle().unwrap();
    board.run_ms(200).unwrap();
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
}
