//! Faults of the firmware itself leave a trace and restart it, its calibration in use as before.
//!
//! A sound firmware has no way into them, so that a debugger has to push it.

use crate::qemu::support::{ask, board_with, bytes, eeprom, firmware, log, ok, record};
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
    let Some(_turn) = qemu::turn("faults") else { return };
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
    let mut board = crate::qemu::support::start(board.power_cut().unwrap());
    assert_eq!(ok(&mut board, "status").value("faults"), Some("0"));
}

/// A trace of `at_start` faults in a row, each soon after the start, as the firmware keeps it (`fault.rs`).
fn trace(at_start: u32) -> Vec<u8> {
    const HARD_FAULT: u32 = 2;
    let words = [0x6661_756c, at_start, at_start, HARD_FAULT, 0, 0, 0, 0, 0];
    let mut bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).chain([0; 120]).collect();
    let check =
        bytes.iter().fold(0x811c_9dc5_u32, |hash, &byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    bytes.extend(check.to_le_bytes());
    bytes
}

#[test]
fn a_firmware_that_fails_at_every_start_ends_in_one_that_only_answers() {
    let Some(_turn) = qemu::turn("faults at the start") else { return };
    let image = eeprom([&bytes(&record(1, 12.5)), &[]]);
    let mut board = board_with(&image, &Options { debugger: true, ..Options::default() });
    assert_eq!(ok(&mut board, "status").value("faults"), Some("0"));
    let place = firmware().symbol("_fault_trace").unwrap() as u32;
    let fail_after = |board: &mut Emulator, at_start| {
        let mut debugger = board.debugger().unwrap();
        debugger.write(place, &trace(at_start)).unwrap();
        debugger.set_pc(0x6000_0000).unwrap();
        debugger.detach().unwrap();
        assert!(board.console.drain(Duration::from_millis(200)).unwrap().is_empty(), "a banner");
    };
    // One fewer: it starts as ever.
    fail_after(&mut board, 3);
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
    // The fifth in a row.
    fail_after(&mut board, 4);
    let status = ok(&mut board, "status");
    assert!(status.info[0].contains("is not used after repeated faults"), "{status}");
    assert_eq!((status.value("calibrated"), status.value("faults")), (Some("0"), Some("5")));
    assert_eq!(ask(&mut board, "cal start").code(), Some("sensor"));
    assert_eq!(ask(&mut board, "cal clear").code(), Some("store"));
    let version = ok(&mut board, "version");
    assert!(version.info.iter().any(|line| line.starts_with("last_fault=hard fault")), "{version}");
    // Where even that fails, there is no restart any more, and the console says why.
    fail_after(&mut board, 7);
    for command in ["status", "help"] {
        let reply = ask(&mut board, command);
        assert_eq!(reply.code(), Some("busy"), "{reply}");
    }
    let mut board = crate::qemu::support::start(board.power_cut().unwrap());
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
}
