//! The console as its contract says, on the UART and on USB.

use crate::pico::support::{ask, board, figure, ok};
use ironout_rig::pico::{self, Port};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

#[test]
fn both_ports_answer_as_written_and_each_where_it_was_asked() {
    if !pico::available("console") {
        return;
    }
    let (mut board, _chip) = board(10.0);
    // USB is enumerated in some tens of milliseconds.
    board.run_ms(200).unwrap();
    for port in [Port::Uart, Port::Usb] {
        board.port = port;
        assert!(board.take_streamed().is_empty(), "{port:?}: a banner");
        let help = ok(&mut board, "help");
        assert!(help.info.iter().any(|line| line.contains("cal start")), "{help}");
        let version = ok(&mut board, "version");
        assert_eq!(version.value("board"), Some("pico"), "{version}");
        assert_eq!(version.value("slots"), Some("empty,empty"), "{version}");
        let status = ok(&mut board, "status\r");
        assert_eq!(
            (status.value("state"), status.value("calibrated")),
            (Some("idle"), Some("0")),
            "{status}"
        );
        for (line, code) in [
            ("dance", "unknown"),
            ("field", "usage"),
            ("caf\u{e9}", "usage"),
            (&"x".repeat(81), "long"),
            ("cal stop", "state"),
            ("cal show", "state"),
            ("stream cal", "state"),
        ] {
            assert_eq!(ask(&mut board, line).code(), Some(code), "{port:?}: {line}");
        }
        // Nothing without a question, and nothing for an empty line.
        board.send(port, b"\n\r\n\n").unwrap();
        board.run_ms(300).unwrap();
        assert!(board.take_streamed().is_empty(), "{port:?}");
    }
    // A stream follows the port that asked last.
    ok(&mut board, "stream raw");
    assert!(board.next_streamed(1_000).unwrap().starts_with("R,"));
    board.port = Port::Uart;
    assert!(board.take_streamed().is_empty());
    ok(&mut board, "stream raw");
    assert!(board.next_streamed(1_000).unwrap().starts_with("R,"));
    // A line begun and left alone keeps the other port waiting, and not for ever.
    ok(&mut board, "stream off");
    board.send(Port::Uart, b"stat").unwrap();
    board.run_ms(100).unwrap();
    board.send(Port::Usb, b"status\n").unwrap();
    board.run_ms(3_500).unwrap();
    assert_eq!(board.reply("the line that was ended").unwrap().code(), Some("unknown"));
    board.port = Port::Usb;
    board.take_streamed();
    assert_eq!(ok(&mut board, "status").value("state"), Some("idle"));
}

#[test]
fn a_flood_of_commands_loses_no_reply_and_no_sample() {
    if !pico::available("flood of commands") {
        return;
    }
    let (mut board, _chip) = board(10.0);
    board.run_ms(200).unwrap();
    ok(&mut board, "cal start");
    // At the line's full speed.
    let questions = 100;
    for batch in 0..5 {
        board.send(Port::Uart, "status\n".repeat(questions / 5).as_bytes()).unwrap();
        for question in 0..questions / 5 {
            let reply = board.reply("status").unwrap_or_else(|error| panic!("{batch}.{question}: {error}"));
            let state = board.state().unwrap();
            assert_eq!(reply.value("state"), Some("collecting"), "{batch}.{question}: {reply}\n{state:?}");
        }
    }
    let version = ok(&mut board, "version");
    assert_eq!(version.value("samples_lost"), Some("0"), "{version}");
    assert_eq!(board.state().unwrap().overruns, 0);
}

/// A line of a command's words, some of them changed.
fn mutated(rng: &mut ChaCha8Rng) -> Vec<u8> {
    const LINES: [&str; 14] = [
        "help",
        "version",
        "status",
        "cal start",
        "cal cancel",
        "cal show",
        "cal method trace",
        "stream off",
        "stream raw",
        "effect list",
        "field 50.0",
        "cov current_a=3.2",
        "why",
        "cal load 1 2 3",
    ];
    let mut line = LINES[rng.random_range(0..LINES.len())].as_bytes().to_vec();
    for _ in 0..rng.random_range(0..4) {
        let at = rng.random_range(0..=line.len());
        match rng.random_range(0..4) {
            0 => line.insert(at, rng.random_range(0x20..0x7f)),
            1 if at < line.len() => drop(line.remove(at)),
            2 if at < line.len() => line[at] ^= 1 << rng.random_range(0..8_u32),
            _ => line.extend(std::iter::repeat_n(b'7', rng.random_range(0..100))),
        }
    }
    // It stays one line, and one that wants an answer.
    line.retain(|&byte| byte != b'\n');
    line.insert(0, b' ');
    line.insert(0, b'x');
    if rng.random_bool(0.5) {
        line.drain(..2);
    }
    if line.iter().all(|&byte| byte == b'\r') {
        line.push(b'?');
    }
    line
}

#[test]
fn random_and_mutated_lines_are_each_answered_once_and_change_no_calibration() {
    if !pico::available("mutated lines") {
        return;
    }
    // `IRONOUT_PICO_LINES=100000` for the long run.
    let lines = std::env::var("IRONOUT_PICO_LINES").ok().and_then(|text| text.parse().ok()).unwrap_or(300);
    let (mut board, _chip) = board(10.0);
    crate::pico::support::store(&mut board, 0, &crate::pico::support::record(1, 12.5));
    board.run_ms(200).unwrap();
    let before = ok(&mut board, "cal show");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for number in 0..lines {
        let mut line = mutated(&mut rng);
        let shown = String::from_utf8_lossy(&line).into_owned();
        line.push(b'\n');
        board.send(Port::Uart, &line).unwrap();
        board.reply(&shown).unwrap_or_else(|error| panic!("line {number} {shown:?}: {error}"));
        board.take_streamed();
    }
    ok(&mut board, "stream off");
    assert_eq!(ok(&mut board, "cal show"), before);
    let state = board.state().unwrap();
    assert!(state.resets.is_empty(), "{state:?}");
    assert_eq!(figure(&ok(&mut board, "status"), "faults"), 0.0);
}
