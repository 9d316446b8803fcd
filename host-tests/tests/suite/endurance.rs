//! A day of the board's own clock, and a hundred thousand lines that nobody would type: on the simulated bus, with the firmware's
//! own device and driver.

use crate::common::{NOISE_UT, accepted_board, calibrate, last, value, world};
use ironout_rig::board::SimBoard;
use ironout_simulation::Motion;
use rand::{RngExt, SeedableRng, rngs::ChaCha12Rng};

const DAY_MS: u64 = 24 * 3_600_000;

#[test]
fn after_a_day_the_clock_the_counts_and_the_calibration_are_right() {
    let world = world(Motion::Sphere, 71);
    // Four minutes of motion again and again.
    let mut board = SimBoard::new(move |t_s: f64| world.sensor_ut(t_s % 240.0), NOISE_UT, 71);
    board.run_ms(100);
    calibrate(&mut board, 60);
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"));
    let shown = board.command("cal show");
    last(&mut board, "cal start");
    board.run_ms(DAY_MS);

    let status = board.command("status");
    assert!(status.iter().any(|line| line.contains("condition=good")), "{status:?}");
    let status = status.last().unwrap();
    let n: u64 = value(status, "n").parse().unwrap();
    let skipped: u64 = value(status, "skipped").parse().unwrap();
    assert_eq!(value(status, "faults"), "0");
    // Fifty a second, to the sample: none lost, none counted twice.
    let all = DAY_MS / 20;
    assert!(n.abs_diff(all - skipped) <= 1, "{n} and {skipped} of {all}");
    let verdict = last(&mut board, "cal stop");
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    assert!(value(&verdict, "error_percent").parse::<f64>().unwrap() < 0.01, "{verdict}");
    assert_eq!(board.command("cal show"), shown, "what is in use did not move");

    assert_eq!(last(&mut board, "stream raw"), "ok stream=raw");
    board.run_ms(1_000);
    let lines = board.received();
    let times: Vec<u64> = lines.iter().map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert!(times[0] > DAY_MS, "{}", lines[0]);
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] == 20), "{times:?}");
    let version = board.command("version");
    assert!(version.iter().any(|line| line.contains("samples_lost=0")), "{version:?}");
}

/// Lines of the contract, to be spoilt.
const SEEDS: [&str; 24] = [
    "help",
    "version",
    "status",
    "cal start",
    "cal stop",
    "cal cancel",
    "cal show",
    "cal method adjusted",
    "cal method trace",
    "stream off",
    "stream raw",
    "stream cal",
    "stream motioncal",
    "field 48.5",
    "cov temp_c=31.5",
    "cov current_a=-3e2",
    "effect list",
    "why",
    "cal load",
    "cal dump",
    "cal accept",
    "cal clear",
    "effect add offset:temp_c",
    "effect remove offset:temp_c",
];

/// Whether a line may change what is stored: those are tried elsewhere.
fn stores(line: &[u8]) -> bool {
    let text = String::from_utf8_lossy(line);
    let words: Vec<&str> = text.split(' ').filter(|word| !word.is_empty()).collect();
    matches!(words[..], ["cal", "accept" | "clear", ..] | ["effect", "add" | "remove", ..])
}

fn line(rng: &mut ChaCha12Rng) -> Vec<u8> {
    let mut bytes = SEEDS[rng.random_range(0..SEEDS.len())].as_bytes().to_vec();
    for _ in 0..rng.random_range(0..4) {
        let at = rng.random_range(0..=bytes.len());
        match rng.random_range(0..5) {
            0 => bytes.insert(at, rng.random_range(1..=255)),
            1 if at < bytes.len() => drop(bytes.remove(at)),
            2 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            3 => bytes.extend_from_within(at..),
            _ => bytes.truncate(at),
        }
    }
    bytes.retain(|&byte| byte != b'\n' && byte != b'\r');
    bytes
}

#[test]
fn a_hundred_thousand_spoilt_lines_are_each_answered_once_and_change_no_calibration() {
    let mut board = accepted_board(72);
    let shown = board.command("cal show");
    let mut rng = ChaCha12Rng::seed_from_u64(72);
    let (mut sent, mut answered, mut refused) = (0, 0, 0);
    while sent < 100_000 {
        let line = line(&mut rng);
        if stores(&line) || line.is_empty() {
            continue;
        }
        sent += 1;
        board.send(&[&line[..], b"\n"].concat());
        for said in board.received() {
            match said.as_str() {
                line if line == "ok" || line.starts_with("ok ") => answered += 1,
                line if line.starts_with("err ") => refused += 1,
                line if line.starts_with("+ ") => {}
                line => assert!(
                    ["R,", "C,", "Raw:"].iter().any(|mark| line.starts_with(mark)),
                    "{line:?} in between"
                ),
            }
        }
        assert_eq!(answered + refused, sent, "after {:?}", String::from_utf8_lossy(&line));
    }
    assert!(answered > 10_000 && refused > 10_000, "{answered} answered, {refused} refused");
    board.send(b"stream off\ncal cancel\n");
    board.received();
    assert_eq!(board.command("cal show"), shown);
    board.restart();
    board.run_ms(100);
    assert_eq!(board.command("cal show"), shown);
}
