//! Whatever arrives on the console: every line is answered exactly once, and nothing stops the board.

use crate::common::{accepted_board, world_board};
use ironout_rig::board::SimBoard;
use ironout_simulation::Motion;
use proptest::collection::vec;
use proptest::prelude::*;

/// How many lines of `bytes` must be answered: those that end and are not empty.
fn lines_to_answer(bytes: &[u8]) -> usize {
    let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
    lines.pop();
    lines.iter().filter(|line| !line.strip_suffix(b"\r").unwrap_or(line).is_empty()).count()
}

/// Checks the form of everything that was sent, and returns the final lines of the answers.
fn answers(sent: &[String]) -> Vec<&String> {
    let codes = ["unknown", "usage", "long", "busy", "state", "refused", "sensor", "store"];
    for line in sent {
        assert!(line.bytes().all(|byte| (0x20..=0x7e).contains(&byte)), "{line:?}");
        let word = line.split([' ', ',', ':']).next().unwrap_or_default();
        assert!(["+", "ok", "err", "R", "C", "L", "H", "Raw"].contains(&word), "{line:?}");
        if let Some(rest) = line.strip_prefix("err ") {
            let (code, text) = rest.split_once(' ').expect("a code and a text");
            assert!(codes.contains(&code) && !text.is_empty(), "{line:?}");
        }
    }
    sent.iter().filter(|line| line.starts_with("ok") || line.starts_with("err ")).collect()
}

fn is_alive(board: &mut SimBoard) {
    board.send(b"\n");
    let answer = board.command("help");
    assert_eq!(answer.last().map(String::as_str), Some("ok"), "{answer:?}");
}

#[test]
fn the_answers_of_the_contract() {
    let mut board = world_board(Motion::Sphere, 31);
    board.run_ms(100);
    for (line, start) in [
        ("version", "ok ironout="),
        ("hlep", "err unknown "),
        ("effect list", "ok in_use=0"),
        ("effect add drift", "err state no samples to study yet: cal start"),
        ("effect remove drift", "err state drift is not in use"),
        ("effect", "err usage effect list, effect add ID"),
        ("why", "err state no samples to study yet: cal start"),
        ("cov current_a=3.2", "ok current_a=3.2 used=0 tested=1"),
        ("cov a=1 b=2", "err state no room: 3 columns are tested at the same time (temp_c, current_a)"),
        ("cov ax_mps2=0 ay_mps2=0 az_mps2=-9.8", "ok ax_mps2=0.0 ay_mps2=0.0 az_mps2=-9.8 used=0 tested=3"),
        ("cov current_a=-", "ok current_a=- used=0 tested=0"),
        ("cov current_a=much", "err usage cov NAME=VALUE"),
        ("cal begin", "err usage cal start [level]|stop|"),
        ("field -3", "err usage field UT"),
        ("stream raw", "ok stream=raw"),
        ("stream motioncal", "ok stream=motioncal"),
        ("stream log", "ok stream=log"),
        ("stream off", "ok stream=off"),
        ("cal dump", "err state there is no calibration"),
        ("cal load end", "err state no calibration is being loaded"),
        ("cal load begin 9999 00000000", "err usage a record has at most 512 bytes"),
        ("cal load data 0 zz", "err usage cal load begin BYTES CRC"),
        ("cal show", "err state there is no calibration"),
    ] {
        let answer = crate::common::last(&mut board, line);
        assert!(answer.starts_with(start), "{line}: {answer}");
    }
    board.send(&[&[b'a'; 81][..], b"\r\nhelp me\r\n\r\n\nsta\x01tus\n"].concat());
    let sent = board.received();
    let starts: Vec<&str> = answers(&sent).iter().map(|line| line.split(' ').nth(1).unwrap()).collect();
    assert_eq!(starts, ["long", "usage", "usage"]);
    is_alive(&mut board);
}

#[test]
fn the_streams_follow_the_contract() {
    let mut board = accepted_board(32);
    for (command, start, fields) in
        [("stream raw", "R,", 5), ("stream cal", "C,", 7), ("stream motioncal", "Raw:", 9)]
    {
        board.command(command);
        board.run_ms(1000);
        let lines = board.received();
        assert!((49..=51).contains(&lines.len()), "{command}: {}", lines.len());
        for line in &lines {
            assert!(line.starts_with(start) && line.split(',').count() == fields, "{line}");
        }
    }
    board.command("stream off");
    board.run_ms(1000);
    assert_eq!(board.received(), [""; 0]);
}

/// A line without what may change with the figures: numbers, and the side to turn to.
fn shape(line: &str) -> String {
    let words = line.split([' ', ',', '=']).zip(line.matches([' ', ',', '=']).chain([""]));
    let kept = |word: &str| match word.parse::<f64>() {
        Err(_) if word != "-" => word.to_owned(),
        _ => "#".to_owned(),
    };
    let text: String = words.map(|(word, end)| kept(word) + end).collect();
    // The sides to turn from and to are figures as well.
    let mut words: Vec<&str> = text.split(' ').collect();
    for at in 1..words.len() {
        if words[at] == "side" {
            words[at - 1] = "#";
        }
    }
    words.join(" ")
}

#[test]
fn the_documented_session_is_what_the_board_says() {
    let text = include_str!("../../../docs/console.md");
    // Indented lines are the session; what stands between fences is a program's or an example's.
    let parts = text.split("```").step_by(2);
    let mut documented = parts.flat_map(str::lines).filter_map(|line| line.strip_prefix("    ")).peekable();
    let mut board = world_board(Motion::Sphere, 1);
    board.run_ms(100);
    let mut seconds = [3, 57].into_iter();
    let mut commands = 0;
    while let Some(line) = documented.next() {
        let command = line.strip_prefix("> ").unwrap_or_else(|| panic!("a command instead of {line:?}"));
        let mut answer = board.command(command);
        match command {
            "cal start" => board.run_ms(1000 * seconds.next().unwrap()),
            "status" => board.run_ms(1000 * seconds.next().unwrap_or(0)),
            "stream cal" => board.run_ms(40),
            _ => {}
        }
        answer.extend(board.received());
        let mut expected = Vec::new();
        while let Some(line) = documented.next_if(|line| !line.starts_with("> ")) {
            expected.push(shape(line));
        }
        let shapes: Vec<String> = answer.iter().map(|line| shape(line)).collect();
        assert_eq!(shapes, expected, "{command}: {answer:?}");
        commands += 1;
    }
    assert_eq!(commands, 9);
}

/// A line that is likely to mean something.
fn command() -> impl Strategy<Value = Vec<u8>> {
    let words = [
        "help",
        "version",
        "status",
        "cal start",
        "cal stop",
        "cal accept",
        "cal cancel",
        "cal show",
        "cal clear",
        "cal method trace",
        "cal method constant",
        "cal method adjusted",
        "cal",
        "stream raw",
        "stream cal",
        "stream off",
        "stream motioncal",
        "stream log",
        "cal dump",
        "cal load begin 148 00000000",
        "cal load data 0 49524f4e",
        "cal load end",
        "field 48",
        "field 1e300",
        "field NaN",
        "effect add lag",
        "why",
        "cov a=1",
        "",
    ];
    prop_oneof![
        8 => proptest::sample::select(words.to_vec()).prop_map(|word| word.as_bytes().to_vec()),
        1 => vec(any::<u8>(), 0..120),
        1 => vec(0x20..0x7f_u8, 0..100),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_answered_line_by_line(bytes in vec(prop_oneof![any::<u8>(), Just(b'\n'), Just(b' '), Just(b'c')], 0..600)) {
        let mut board = world_board(Motion::Sphere, 33);
        board.send(&bytes);
        let sent = board.received();
        prop_assert_eq!(answers(&sent).len(), lines_to_answer(&bytes));
        is_alive(&mut board);
    }

    #[test]
    fn any_sequence_of_commands_with_faults_in_between_is_answered(
        steps in vec((command(), 0_u64..2000, 0_u8..8), 1..25),
        seed in any::<u64>(),
    ) {
        let mut board = world_board(Motion::Sphere, seed);
        for (line, run_ms, event) in steps {
            match event {
                0 => board.sensor_faults.nack_randomly(seed, 0.1),
                1 => board.store_faults.nack_randomly(seed, 0.1),
                2 => board.sensor_faults.clear(),
                3 => { board.restart(); }
                4 => { let _ = board.press(); }
                _ => {}
            }
            board.run_ms(run_ms);
            let _ = board.received();
            let framed = [&line[..], b"\n"].concat();
            board.send(&framed);
            let sent = board.received();
            prop_assert_eq!(answers(&sent).len(), lines_to_answer(&framed), "{:?}", sent);
        }
        is_alive(&mut board);
    }
}
