//! What a calibration costs on the RP2040: time of a sample and of a solve, samples beside the solve, stack.

use crate::support::{board, figure, firmware, numbers, ok};
use ironout_rig::pico::{self, CYCLES_PER_US};

const PERIOD_S: f64 = 8.0;
/// Bytes of flash and RAM that the board may take, the second with what the stack has reached. Of its 2 MiB and 264 KiB; the
/// limits are there to make growth seen.
const MOST_FLASH: u64 = 232 * 1024;
const MOST_RAM: u64 = 48 * 1024;

#[test]
fn no_sample_is_lost_beside_a_solve_and_flash_ram_and_stack_stay_within_their_limits() {
    if !pico::available("cost") {
        return;
    }
    let (mut board, _chip) = board(PERIOD_S);
    board.run_ms(500).unwrap();
    let cycles_in = |board: &mut pico::Pico, ms: u64| {
        let before = board.state().unwrap();
        board.run_ms(ms).unwrap();
        let after = board.state().unwrap();
        after.cycles - before.cycles
    };
    let idle = cycles_in(&mut board, 2_000);
    ok(&mut board, "cal start");
    let collecting = cycles_in(&mut board, (PERIOD_S * 1000.0) as u64);
    let samples = 100.0 * PERIOD_S;
    let a_sample = (collecting - idle * PERIOD_S / 2.0) / samples;
    let longest_push_us = figure(&ok(&mut board, "version"), "longest_turn_us");
    ok(&mut board, "status");
    ok(&mut board, "stream raw");
    board.run_ms(200).unwrap();
    let begun = board.state().unwrap();
    let stopped = ok(&mut board, "cal stop");
    let stop_ms = board.state().unwrap().ms - begun.ms;
    assert_eq!(stopped.value("verdict"), Some("accepted"), "{stopped}");
    board.run_ms(300).unwrap();
    let lines = board.take_streamed();
    ok(&mut board, "stream off");
    let version = ok(&mut board, "version");
    // Code cannot run from a flash that erases: a sector takes 45 ms, and three conversions pass unseen.
    ok(&mut board, "cal accept");
    board.run_ms(100).unwrap();
    let lost = figure(&ok(&mut board, "version"), "samples_lost");
    assert!(lost <= 4.0, "{lost} samples lost while storing");
    println!(
        "busy {:.2} % idle, {:.2} % collecting; a sample of the session {:.0} cycles in the mean, its longest turn {:.0} us; cal stop {:.0} ms",
        100.0 * idle / (2e6 * CYCLES_PER_US),
        100.0 * collecting / (PERIOD_S * 1e6 * CYCLES_PER_US),
        a_sample,
        longest_push_us,
        stop_ms
    );
    println!("the longest turn of all: {} us", version.value("longest_turn_us").unwrap_or("-"));
    assert_eq!(version.value("samples_lost"), Some("0"), "{version}");
    let times: Vec<i64> = lines.iter().map(|line| numbers::<i64>(line, 1)[0]).collect();
    assert!(times.windows(2).all(|pair| (9..=11).contains(&(pair[1] - pair[0]))), "{times:?}");

    let bottom = firmware().symbol("_stack_end").unwrap();
    let region = firmware().symbol("_stack_start").unwrap() - bottom;
    // The emulated memory starts as zeros.
    let untouched = board.memory(bottom, region).unwrap().iter().take_while(|&&byte| byte == 0).count();
    let stack = region - untouched as u64;
    let size = firmware().footprint().unwrap();
    let ram = size.data + size.bss + stack;
    println!(
        "flash {} bytes; RAM {ram} bytes: statics {}, stack {stack}",
        size.flash(),
        size.data + size.bss
    );
    assert!(size.flash() <= MOST_FLASH, "{} bytes of flash", size.flash());
    assert!(ram <= MOST_RAM, "{ram} bytes of RAM");
}
