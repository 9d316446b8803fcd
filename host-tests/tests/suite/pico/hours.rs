//! Hours of the image as it is flashed: half a minute of them by default, `IRONOUT_PICO_HOURS=24` for a day, which takes a host
//! several.

use crate::pico::support::{FIELD_UT, board, figure, numbers, ok, stack_used};
use ironout_rig::pico::{self, Pico};

/// The motion, s.
const PERIOD_S: f64 = 8.0;
/// Board time from one sample to the next, ms.
const BEAT_MS: u64 = 10;
/// Board time between two looks at the board, ms.
const LOOK_MS: u64 = 10_000;
/// After so much nothing new happens, ms.
const WARM_MS: u64 = 20_000;
/// Samples that one flash erase costs.
const ERASED: f64 = 4.0;

/// When a sample was taken, ms, and its number.
fn sampled(board: &mut Pico) -> (u64, u64) {
    ok(board, "stream log");
    let line = loop {
        let line = board.next_streamed(1_000).unwrap();
        if line.starts_with("L,") {
            break line;
        }
    };
    ok(board, "stream off");
    board.take_streamed();
    let [t_ms, seq, ..] = numbers::<f64>(&line, 1)[..] else { panic!("{line}") };
    (t_ms as u64, seq as u64)
}

#[test]
#[ignore = "minutes on the emulated chip: .ci/long runs it"]
fn after_hours_no_sample_is_missing_the_calibration_stands_and_nothing_has_grown() {
    if !pico::available("hours") {
        return;
    }
    let asked = std::env::var("IRONOUT_PICO_HOURS").ok().and_then(|text| text.parse::<f64>().ok());
    let hours = asked.unwrap_or(0.01);
    let (mut board, _chip) = board(PERIOD_S);
    board.run_ms(500).unwrap();
    ok(&mut board, &format!("field {FIELD_UT}"));
    ok(&mut board, "cal start");
    board.run_ms((PERIOD_S * 1000.0) as u64).unwrap();
    assert_eq!(ok(&mut board, "cal stop").value("verdict"), Some("accepted"));
    ok(&mut board, "cal accept");
    board.run_ms(200).unwrap();
    let shown = ok(&mut board, "cal show").to_string();
    let lost = |board: &mut Pico| figure(&ok(board, "version"), "samples_lost");
    let lost_before = lost(&mut board);
    assert!(lost_before <= ERASED, "{lost_before} samples lost while storing");
    let resets = board.state().unwrap().resets;
    // It collects and studies meanwhile, and is asked.
    ok(&mut board, "cal start");
    let (begin_ms, begin) = sampled(&mut board);
    let end_ms = begin_ms + (hours * 3_600_000.0) as u64;
    let (mut looks, mut stack) = (0_u64, None);
    let (last_ms, last) = loop {
        board.run_ms(LOOK_MS).unwrap();
        looks += 1;
        let status = ok(&mut board, "status");
        assert_eq!((status.value("faults"), status.value("calibrated")), (Some("0"), Some("1")), "{status}");
        ok(&mut board, "why");
        let now = sampled(&mut board);
        if now.0 >= begin_ms + WARM_MS {
            stack.get_or_insert(stack_used(&mut board));
        }
        if looks.is_multiple_of(360) {
            println!("{:.2} h", (now.0 - begin_ms) as f64 / 3.6e6);
        }
        if now.0 >= end_ms && stack.is_some() {
            break now;
        }
    };
    let (passed_ms, samples) = (last_ms - begin_ms, last - begin);
    let version = ok(&mut board, "version");
    println!("{:.3} h, {samples} samples, {looks} looks; {version}", passed_ms as f64 / 3.6e6);
    // Each beat has its sample, and one: the reading may wait for the end of a turn.
    assert!(samples.abs_diff(passed_ms / BEAT_MS) <= 1, "{samples} samples in {passed_ms} ms");
    assert!(lost(&mut board) <= lost_before, "{version}");
    assert_eq!(ok(&mut board, "cal show").to_string(), shown, "what is in use did not move");
    let grown = stack_used(&mut board);
    assert!(grown <= stack.unwrap_or(0) + 256, "the stack went from {stack:?} to {grown} bytes");
    assert_eq!(board.state().unwrap().resets, resets, "it has not begun anew");
    ok(&mut board, "cal cancel");
    assert_eq!(ok(&mut board, "status").value("state"), Some("idle"));
}
