//! Faults of the firmware itself leave a trace and restart it, its calibration in use as before.
//!
//! A sound firmware has no way into them, so that a debugger has to push it.

use crate::support::{board_with, bytes, eeprom, firmware, log, ok, record};
use ironout_rig::qemu::{self, Debugger, Emulator, Options};
use std::time::Duration;

/// Lets `push` do its work with the machine stopped, and returns what the board says of it after its restart.
fn after(board: &mut Emulator, push: impl FnOnce(&mut Debugger)) -> String {
    let mut debugger = board.debugger().unwrap();
    push(&mut debugger);
    debugger.detach().unwrap();
    // What is sent while it restarts is lost.
    assert!(board.console.drain(Duration::from_millis(200)).unwrap().is_empty(), "a banner");
    let version = ok(board, "version");
    assert_eq!(ok(board, "status").value("calibrated"), Some("1"), "{version}");
    let fault = version.info.iter().find_map(|line| line.strip_prefix("last_fault="));
    fault.unwrap_or_else(|| panic!("no trace of the fault: {version}")).to_owned()
}

#[test]
fn a_fault_leaves_its_trace_and_the_board_goes_on() {
    if !qemu::available("faults") {
        return;
    }
    let image = eeprom([&bytes(&record(1, 12.5)), &[]]);
    let mut board = board_with(&image, &Options { debugger: true, ..Options::default() });
    assert_eq!(ok(&mut board, "status").value("faults"), Some("0"));

    let nowhere = 0x6000_0000;
    let fault = after(&mut board, |debugger| debugger.set_pc(nowhere).unwrap());
    assert!(fault.starts_with("hard fault pc=0x60000000"), "{fault}");

    let unexpected = firmware().symbol("DefaultHandler").unwrap() as u32 & !1;
    let fault = after(&mut board, |debugger| debugger.set_pc(unexpected).unwrap());
    assert!(fault.starts_with("panic at src/bin/firmware/fault.rs:"), "{fault}");
    assert!(fault.contains("unexpected interrupt"), "{fault}");

    let bottom = firmware().symbol("_stack_end").unwrap() as u32;
    let fault = after(&mut board, |debugger| debugger.set_sp(bottom + 8).unwrap());
    assert!(fault.starts_with("stack overflow"), "{fault}");

    assert_eq!(ok(&mut board, "status").value("faults"), Some("3"));
    let logged = log(&board).into_iter().filter(|line| line.starts_with("restart")).collect::<Vec<_>>();
    assert_eq!(logged.len(), 3, "{logged:?}");
    assert!(logged[2].contains("restart 3 after a fault: stack overflow"), "{logged:?}");

    // A power cut, and the board starts afresh.
    let mut board = crate::support::start(board.power_cut().unwrap());
    assert_eq!(ok(&mut board, "status").value("faults"), Some("0"));
}
