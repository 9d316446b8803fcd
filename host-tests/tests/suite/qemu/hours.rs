//! Hours of the firmware itself, of a board whose sleep nobody waits for: a minute of them by default, `IRONOUT_QEMU_HOURS=24` for a day.

use crate::qemu::support::{FIELD_UT, attitudes, firmware, numbers, ok, start};
use ironout_rig::qemu::{self, Emulator, Options, PoweredOff};
use std::time::Duration;

/// Board time from one sample to the next, ms.
const BEAT_MS: u64 = 20;

/// When a sample was taken, and its number.
fn sampled(board: &mut Emulator) -> (u64, u64) {
    ok(board, "stream log");
    let line = loop {
        let line = board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap();
        if line.starts_with("L,") {
            break line;
        }
    };
    ok(board, "stream off");
    board.console.take_streamed();
    let [t_ms, seq, ..] = numbers::<f64>(&line, 1)[..] else { panic!("{line}") };
    (t_ms as u64, seq as u64)
}

/// How much deeper one question may go than all before it, bytes: which of them goes deepest is a matter of the moment at which it is
/// asked, and so of the host. What grows with the hours grows by more.
const ONE_DEEPER: u64 = 2048;

#[test]
fn after_hours_no_sample_is_missing_the_calibration_stands_and_nothing_has_grown() {
    let Some(_turn) = qemu::turn("hours") else { return };
    let hours =
        std::env::var("IRONOUT_QEMU_HOURS").ok().and_then(|text| text.parse::<f64>().ok()).unwrap_or(0.01);
    let options = Options { counted: true, waited_for: false, ..Options::default() };
    let mut board = start(PoweredOff::new(firmware(), &options).unwrap());
    ok(&mut board, &format!("field {FIELD_UT}"));
    ok(&mut board, "stream raw");
    // Nobody waits for it: where the host is slow, seconds pass on the board before the sensor feels any field.
    board.expose(attitudes(120).next().unwrap()).unwrap();
    ok(&mut board, "cal start");
    for field_ut in attitudes(120) {
        board.expose(field_ut).unwrap();
    }
    ok(&mut board, "stream off");
    board.console.take_streamed();
    assert_eq!(ok(&mut board, "cal stop").value("verdict"), Some("accepted"));
    ok(&mut board, "cal accept");
    let shown = ok(&mut board, "cal show").to_string();
    // It collects and studies meanwhile, and is asked.
    ok(&mut board, "cal start");
    let (begin_ms, begin) = sampled(&mut board);
    let end_ms = begin_ms + (hours * 3_600_000.0) as u64;
    let (mut questions, mut stack) = (0_u64, None);
    let places: Vec<[f64; 3]> = attitudes(97).collect();
    let (last_ms, last) = loop {
        for _ in 0..10 {
            board.set_field_ut(places[questions as usize % places.len()]).unwrap();
            questions += 1;
            std::thread::sleep(Duration::from_millis(20));
        }
        let status = ok(&mut board, "status");
        assert_eq!((status.value("faults"), status.value("calibrated")), (Some("0"), Some("1")), "{status}");
        board.console.command("why").unwrap();
        // All that there is was done by then.
        if questions >= 30 {
            stack.get_or_insert(board.stack_used().unwrap());
        }
        let now = sampled(&mut board);
        if now.0 >= end_ms && stack.is_some() {
            break now;
        }
    };
    let (passed_ms, samples) = (last_ms - begin_ms, last - begin);
    let version = ok(&mut board, "version");
    println!("{:.3} h, {samples} samples, {questions} attitudes; {version}", passed_ms as f64 / 3.6e6);
    // Each beat has its sample, and one: a turn of a solve may move one of them.
    assert!(samples.abs_diff(passed_ms / BEAT_MS) <= 1, "{samples} samples in {passed_ms} ms");
    assert_eq!(version.value("samples_lost"), Some("0"), "{version}");
    assert_eq!(ok(&mut board, "cal show").to_string(), shown, "what is in use did not move");
    let grown = board.stack_used().unwrap();
    assert!(grown <= stack.unwrap_or(0) + ONE_DEEPER, "the stack went from {stack:?} to {grown} bytes");
    ok(&mut board, "cal cancel");
    assert_eq!(ok(&mut board, "status").value("state"), Some("idle"));
}
