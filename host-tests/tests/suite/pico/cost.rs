//! What a calibration costs on the RP2040: time of a sample and of a solve, samples beside the solve, stack.

use crate::pico::support::{board, figure, firmware, numbers, ok, stack_used};
use ironout_rig::pico::{self, CYCLES_PER_US};

const PERIOD_S: f64 = 8.0;
/// Bytes of flash and RAM that the board may take, the second with what the stack has reached. Of its 2 MiB and 264 KiB; the
/// limits are there to make growth seen.
const MOST_FLASH: u64 = 284 * 1024;
const MOST_RAM: u64 = 56 * 1024;

#[test]
fn no_sample_is_lost_beside_a_solve_and_flash_ram_and_stack_stay_within_their_limits() {
    if !pico::available("cost") {
        return;
    }
    let (mut board, _chip) = board(PERIOD_S);
    board.run_ms(500).unwrap();
    ok(&mut board, "cal start");
    board.watch(firmware().function("take_sample").unwrap()).unwrap();
    let before = board.state().unwrap();
    board.run_ms((PERIOD_S * 1000.0) as u64).unwrap();
    let busy = (board.state().unwrap().cycles - before.cycles) / (PERIOD_S * 1e6 * CYCLES_PER_US);
    let sample = board.watched().unwrap();
    assert!(sample.count as f64 >= 100.0 * PERIOD_S - 2.0, "{sample:?}");
    ok(&mut board, "status");
    ok(&mut board, "stream raw");
    board.run_ms(200).unwrap();
    board.watch(firmware().function("Session::stop").unwrap()).unwrap();
    let stopped = ok(&mut board, "cal stop");
    let solve = board.watched().unwrap();
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
        "collecting 100 samples a second the core is {:.1} % busy; a sample {:.0} cycles in the mean, {:.0} at most, of {}; \
         Session::stop {:.0} cycles, {:.1} ms; the longest turn {} us",
        100.0 * busy,
        sample.mean_cycles,
        sample.worst_cycles,
        sample.count,
        solve.worst_cycles,
        solve.worst_cycles / CYCLES_PER_US / 1e3,
        version.value("longest_turn_us").unwrap_or("-"),
    );
    assert_eq!(version.value("samples_lost"), Some("0"), "{version}");
    // Beside the stream, the answers and the solve; of the chip's own rhythm.
    let jitter_us = figure(&version, "stamp_jitter_us");
    println!("stamps of samples within {jitter_us} us of one period after the one before");
    assert!(jitter_us < 100.0, "{version}");
    let times: Vec<i64> = lines.iter().map(|line| numbers::<i64>(line, 1)[0]).collect();
    assert!(times.windows(2).all(|pair| (9..=11).contains(&(pair[1] - pair[0]))), "{times:?}");

    let stack = stack_used(&mut board);
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
