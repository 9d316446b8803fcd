//! The stored calibration: which of two records counts, and what becomes of a torn one.

use crate::qemu::support::{ask, board_with, bytes, eeprom, ok, record, start};
use ironout_rig::qemu::{self, Emulator, Options, PoweredOff};

/// The offset in use, or `None` without a calibration.
fn offset_in_use(board: &mut Emulator) -> Option<String> {
    let calibrated = ok(board, "status").value("calibrated") == Some("1");
    calibrated.then(|| ok(board, "cal show").value("offset_ut").unwrap().to_owned())
}

/// The `slots` of `version`: what stands in each.
fn slots(board: &mut Emulator) -> String {
    ok(board, "version").value("slots").unwrap().to_owned()
}

#[test]
fn the_newer_of_two_records_counts_and_a_torn_one_does_not() {
    let Some(_turn) = qemu::turn("store") else { return };
    let (old, new) = (bytes(&record(6, 11.0)), bytes(&record(7, 22.0)));
    let mut board = board_with(&eeprom([&old, &new]), &Options::default());
    assert_eq!(offset_in_use(&mut board).as_deref(), Some("22.0,22.0,22.0"));
    assert_eq!(slots(&mut board), "stale-6,current-7");

    // A power cut within the write of the newer record: some of its pages are written, the rest holds what was there.
    for written in [32, 64, 96, 128, new.len() - 1] {
        let mut torn = bytes(&record(5, 33.0));
        torn[..written].copy_from_slice(&new[..written]);
        let off = board.power_cut().unwrap();
        off.set_eeprom(&eeprom([&old, &torn])).unwrap();
        board = start(off);
        assert_eq!(offset_in_use(&mut board).as_deref(), Some("11.0,11.0,11.0"), "{written} bytes written");
        assert_eq!(slots(&mut board), "current-6,torn", "{written} bytes written");
    }

    // Nothing sound at all: no calibration, and a console that says so.
    let off = board.power_cut().unwrap();
    off.set_eeprom(&[0x5A; 4096]).unwrap();
    board = start(off);
    assert_eq!(offset_in_use(&mut board), None);
    assert_eq!(ask(&mut board, "cal show").code(), Some("state"));
    assert_eq!(ask(&mut board, "stream cal").code(), Some("state"));

    // Cleared for good.
    let off = board.power_cut().unwrap();
    off.set_eeprom(&eeprom([&old, &new])).unwrap();
    board = start(off);
    ok(&mut board, "cal clear");
    assert_eq!(offset_in_use(&mut board), None);
    board = start(board.power_cut().unwrap());
    assert_eq!(offset_in_use(&mut board), None, "an older record came back");
}

#[test]
fn without_an_eeprom_the_board_works_and_says_that_it_cannot_store() {
    let Some(_turn) = qemu::turn("absent EEPROM") else { return };
    let options = Options { eeprom: false, ..Options::default() };
    let mut board = start(PoweredOff::new(crate::qemu::support::firmware(), &options).unwrap());
    assert_eq!(slots(&mut board), "unreadable,unreadable");
    assert_eq!(ask(&mut board, "cal clear").code(), Some("store"));
    ok(&mut board, "stream raw");
    board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap();
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("0"));
}
