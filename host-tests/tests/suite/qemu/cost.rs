//! The longest turn of the firmware's loop, in instructions, whatever it is doing; and what that means for samples and replies.

use crate::qemu::support::{FIELD_UT, attitudes, firmware, numbers, ok, start};
use ironout_rig::qemu::{self, Options, PoweredOff};

/// Of the emulated clock, ns.
const INSTRUCTION_NS: u64 = 32;
/// A turn begins right after a sample, so that one of less than two periods loses none: 40 ms, which at 25 MHz and 1.3 cycles an
/// instruction are these, less what reading the sensor takes.
const MOST_INSTRUCTIONS: u64 = 740_000;

/// The times of streamed samples, ms.
fn times_ms(lines: &[String]) -> Vec<u64> {
    lines.iter().map(|line| numbers::<i64>(line, 1)[0] as u64).collect()
}

/// Runs. Counted time stands still for nobody while the board sleeps: a busy host that takes the emulator away then makes a sample
/// late. What the firmware itself costs is the same in every run, so that one run without a loss shows that it loses none.
const RUNS: usize = 8;

#[test]
fn no_sample_is_lost_and_each_reply_comes_in_time_while_it_collects_solves_answers_and_stores() {
    let Some(_turn) = qemu::turn("cost of a turn") else { return };
    let mut lost = Vec::new();
    for _ in 0..RUNS {
        match run() {
            Ok(()) => return,
            Err(what) => {
                println!("{what}");
                lost.push(what);
            }
        }
    }
    panic!("samples were lost in each of {RUNS} runs: {lost:?}");
}

/// One run; what of its samples was lost, if any was.
fn run() -> Result<(), String> {
    let options = Options { counted: true, ..Options::default() };
    let mut board = start(PoweredOff::new(firmware(), &options).unwrap());
    ok(&mut board, &format!("field {FIELD_UT}"));
    ok(&mut board, "stream raw");
    board.expose(attitudes(120).next().unwrap()).unwrap();
    ok(&mut board, "cal start");
    let mut lines = board.console.take_streamed();
    for (attitude, field_ut) in attitudes(120).enumerate() {
        lines.extend(board.expose(field_ut).unwrap());
        if attitude % 10 == 9 {
            // The first of them over a part of the sphere only, where a full solve takes longest.
            ok(&mut board, "status");
            lines.extend(board.console.take_streamed());
        }
    }
    let asked_ms = *times_ms(&lines).last().unwrap();
    let questions = 60;
    board.console.send("status\n".repeat(questions).as_bytes()).unwrap();
    for _ in 0..questions {
        let reply = board.console.reply("status").unwrap();
        assert_eq!(reply.value("state"), Some("collecting"), "{reply}");
    }
    lines.extend(board.console.take_streamed());
    let answered_ms = *times_ms(&lines).last().unwrap();
    let stopped = ok(&mut board, "cal stop");
    assert_eq!(stopped.value("verdict"), Some("accepted"), "{stopped}");
    ok(&mut board, "cal accept");
    lines.extend(board.console.take_streamed());
    lines.push(board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap());

    let version = ok(&mut board, "version");
    let figure = |key| version.value(key).and_then(|text| text.parse::<u64>().ok()).expect("a number");
    let instructions = figure("longest_turn_us") * 1_000 / INSTRUCTION_NS;
    let waited_ms = answered_ms.saturating_sub(asked_ms);
    println!("the longest turn: {instructions} instructions; {questions} replies in {waited_ms} ms");
    assert!(instructions <= MOST_INSTRUCTIONS, "{instructions} instructions");
    assert!(waited_ms < 2_000, "{questions} replies took {waited_ms} ms");
    // And so say the times of the samples: 50 a second, none left out.
    let times = times_ms(&lines);
    let late: Vec<_> = times.windows(2).filter(|pair| pair[1] - pair[0] >= 40).collect();
    let beats = (times[times.len() - 1] - times[0] + 10) / 20;
    if figure("samples_lost") == 0 && late.is_empty() && times.len() as u64 == beats + 1 {
        return Ok(());
    }
    Err(format!("{} lost, {} of {beats} beats, {late:?}", figure("samples_lost"), times.len() - 1))
}
