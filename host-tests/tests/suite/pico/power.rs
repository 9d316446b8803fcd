//! Power that fails in the middle of an erase or a program: always the old or the new calibration afterwards.

use crate::pico::support::{board, host_bits, ok, record, shown_bits, store};
use ironout_rig::pico::{self, Pico};

/// The board is turned once in this time.
const PERIOD_S: f64 = 2.0;

/// How many power cuts; `IRONOUT_PICO_CUTS=200` for the long run.
fn cuts() -> u32 {
    std::env::var("IRONOUT_PICO_CUTS").ok().and_then(|text| text.parse().ok()).unwrap_or(24)
}

/// Collects a calibration and solves it; what it has to be, by the host.
fn solve(board: &mut Pico, field_ut: f64) -> Vec<u64> {
    ok(board, &format!("field {field_ut}"));
    ok(board, "stream raw");
    ok(board, "cal start");
    board.take_streamed();
    board.run_ms((PERIOD_S * 1000.0) as u64).unwrap();
    let stopped = ok(board, "cal stop");
    assert_eq!(stopped.value("verdict"), Some("accepted"), "{stopped}");
    let raw = board.take_streamed();
    ok(board, "stream off");
    board.take_streamed();
    host_bits(&raw, field_ut)
}

/// Sends a command that stores something; whether the power failed meanwhile.
fn is_cut(board: &mut Pico, command: &str) -> bool {
    match board.command(command) {
        Ok(reply) => {
            assert!(reply.is_ok(), "{command}: {reply}");
            false
        }
        Err(pico::Error::Stopped(_)) => true,
        Err(error) => panic!("{command}: {error}"),
    }
}

#[test]
fn power_cut_in_any_flash_operation_leaves_the_old_calibration_or_the_new_one() {
    if !pico::available("power cuts") {
        return;
    }
    let (mut board, _chip) = board(PERIOD_S);
    store(&mut board, 0, &record(6, 11.0));
    board.run_ms(200).unwrap();
    let new = solve(&mut board, 50.0);
    let before = board.state().unwrap().flash_operations;
    ok(&mut board, "cal accept");
    let operations = board.state().unwrap().flash_operations - before;
    assert!(operations >= 3, "an erase and several programs: {operations}");
    let mut current = shown_bits(&ok(&mut board, "cal show"));
    assert_eq!(current, new);

    // One operation more than an accept has: then nothing is cut.
    let (mut old, mut taken, cuts) = (0, 0, cuts());
    for cut in 0..cuts {
        let new = solve(&mut board, 40.0 + f64::from(cut) * 0.125);
        board.cut_power_in_flash(u64::from(cut) % (operations + 1), cut).unwrap();
        let was_cut = is_cut(&mut board, "cal accept");
        board.power_cycle().unwrap();
        board.run_ms(100).unwrap();
        let shown = shown_bits(&ok(&mut board, "cal show"));
        if shown == new {
            taken += 1;
        } else {
            assert!(was_cut, "cut {cut}: it was stored and is not there");
            assert_eq!(shown, current, "cut {cut}: neither the old calibration nor the new one");
            old += 1;
        }
        current = shown;
    }
    println!(
        "{cuts} cuts over the {operations} operations of an accept: {old} times the old, {taken} times the new"
    );
    assert!(old > 0 && taken > 0, "{old} {taken}");
}

#[test]
fn power_cut_while_everything_is_cleared_leaves_the_calibration_or_none() {
    if !pico::available("power cuts while clearing") {
        return;
    }
    let (mut board, _chip) = board(PERIOD_S);
    for cut in 0..16_u32 {
        store(&mut board, 0, &[0xFF; 512]);
        store(&mut board, 1, &[0xFF; 512]);
        store(&mut board, cut % 2, &record(6, 11.0));
        store(&mut board, 1 - cut % 2, &record(7, 22.0));
        board.power_cycle().unwrap();
        board.run_ms(100).unwrap();
        board.cut_power_in_flash(u64::from(cut / 2), cut).unwrap();
        let was_cut = is_cut(&mut board, "cal clear");
        board.power_cycle().unwrap();
        board.run_ms(100).unwrap();
        let status = ok(&mut board, "status");
        if status.value("calibrated") == Some("1") {
            assert!(was_cut, "cut {cut}: cleared, and there again");
            assert_eq!(ok(&mut board, "cal show").value("offset_ut"), Some("22.0,22.0,22.0"), "cut {cut}");
        }
    }
}

#[test]
fn decay_and_foreign_bytes_are_told_and_the_other_slot_counts() {
    if !pico::available("decay of the flash") {
        return;
    }
    let (mut board, _chip) = board(PERIOD_S);
    let (old, new) = (record(6, 11.0), record(7, 22.0));
    for bit in (0..new.len() * 8).step_by(97) {
        let mut decayed = new.clone();
        decayed[bit / 8] ^= 1 << (bit % 8);
        store(&mut board, 0, &old);
        store(&mut board, 1, &decayed);
        board.power_cycle().unwrap();
        board.run_ms(60).unwrap();
        assert_eq!(ok(&mut board, "cal show").value("offset_ut"), Some("11.0,11.0,11.0"), "bit {bit}");
    }
    for byte in [0x00, 0x5A] {
        store(&mut board, 0, &[byte; 512]);
        store(&mut board, 1, &[byte; 512]);
        board.power_cycle().unwrap();
        board.run_ms(60).unwrap();
        assert_eq!(ok(&mut board, "status").value("calibrated"), Some("0"));
    }
}
