//! What no well-behaved client sends: each line is answered once, and the console works afterwards.

use crate::qemu::support::{ask, board, ok, start};
use ironout_rig::qemu::{self, Emulator, Options, PoweredOff};
use std::time::Duration;

/// Sends bytes that make one line, and returns the code it is refused with.
fn refused(board: &mut Emulator, bytes: &[u8]) -> String {
    board.console.send(bytes).unwrap();
    let reply = board.console.reply("odd bytes").unwrap();
    reply.code().unwrap_or_else(|| panic!("{bytes:?} was accepted: {reply}")).to_owned()
}

#[test]
fn odd_lines_are_refused_and_the_console_goes_on() {
    let Some(_turn) = qemu::turn("odd lines") else { return };
    let mut board = board();
    assert_eq!(refused(&mut board, b"dance\n"), "unknown");
    assert_eq!(refused(&mut board, b"cal\n"), "usage");
    assert_eq!(refused(&mut board, b"cal shwo\n"), "usage");
    assert_eq!(refused(&mut board, b"field -3\n"), "usage");
    assert_eq!(refused(&mut board, b"field nan\n"), "usage");
    assert_eq!(refused(&mut board, b"why\n"), "state");
    assert_eq!(refused(&mut board, b"ver\x07sion\n"), "usage");
    assert_eq!(refused(&mut board, "große Felder\n".as_bytes()), "usage");
    assert_eq!(refused(&mut board, &[b"x".repeat(81), b"\n".to_vec()].concat()), "long");
    assert_eq!(refused(&mut board, &[b"x".repeat(20_000), b"\n".to_vec()].concat()), "long");
    let every_byte: Vec<u8> = (0..=255).filter(|&byte| byte != b'\n').chain([b'\n']).collect();
    assert!(["usage", "long"].contains(&refused(&mut board, &every_byte).as_str()));
    // A line of exactly 80 characters is no long line.
    assert_eq!(refused(&mut board, &[b"x".repeat(80), b"\n".to_vec()].concat()), "unknown");
    assert!(ok(&mut board, "help").info.len() > 3);
    assert_eq!(ok(&mut board, "version").value("board"), Some("mps2"));
}

#[test]
fn empty_lines_and_silence_have_no_answer() {
    let Some(_turn) = qemu::turn("empty lines") else { return };
    let mut board = board();
    assert_eq!(board.console.drain(Duration::from_millis(200)).unwrap(), Vec::<String>::new(), "a banner");
    board.console.send(b"\n\r\n\n\r\n").unwrap();
    assert_eq!(board.console.drain(Duration::from_millis(200)).unwrap(), Vec::<String>::new());
    board.console.send(b"version\r\n").unwrap();
    assert!(board.console.reply("version").unwrap().is_ok());
}

#[test]
fn commands_sent_at_once_are_all_answered_in_their_order() {
    let Some(_turn) = qemu::turn("many commands") else { return };
    let mut board = board();
    // Far more than the board's buffers hold, and none of the answers read meanwhile.
    let rounds = 200;
    board.console.send("version\ndance\nfield 48\n".repeat(rounds).as_bytes()).unwrap();
    for round in 0..rounds {
        assert!(board.console.reply("version").unwrap().is_ok(), "round {round}");
        assert_eq!(board.console.reply("dance").unwrap().code(), Some("unknown"), "round {round}");
        assert_eq!(board.console.reply("field").unwrap().value("field_ut"), Some("48.0"), "round {round}");
    }
}

#[test]
fn without_a_sensor_the_console_says_so_and_the_sensor_is_found_later() {
    let Some(_turn) = qemu::turn("absent sensor") else { return };
    let options = Options { sensor: false, ..Options::default() };
    let mut board = start(PoweredOff::new(crate::qemu::support::firmware(), &options).unwrap());
    for command in ["cal start", "stream raw"] {
        let reply = ask(&mut board, command);
        assert_eq!(reply.code(), Some("sensor"), "{command}: {reply}");
    }
    let status = ok(&mut board, "status");
    assert!(status.info.iter().any(|line| line.contains("LSM303DLHC")), "{status}");
    assert_ne!(status.value("faults"), Some("0"), "{status}");
    let mut board = start(board.power_cut().unwrap().with_sensor(true));
    ok(&mut board, "stream raw");
    board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap();
    assert_eq!(ok(&mut board, "status").value("faults"), Some("0"));
}

#[test]
fn a_terminal_that_stops_reading_does_not_stop_the_board() {
    let Some(_turn) = qemu::turn("stalled terminal") else { return };
    let mut board = board();
    let help = ok(&mut board, "help").to_string();
    let whole: Vec<&str> = help.lines().collect();
    // Answers of far more than every buffer on the way holds, and nobody reads them.
    board.console.send("help\n".repeat(1_500).as_bytes()).unwrap();
    std::thread::sleep(Duration::from_secs(1));
    let mut lines = Vec::new();
    loop {
        let more = board.console.drain(Duration::from_secs(5)).unwrap();
        if more.is_empty() {
            break;
        }
        lines.extend(more);
    }
    let broken: Vec<&String> = lines.iter().filter(|line| !whole.contains(&line.as_str())).collect();
    assert!(lines.len() < 1_500 * whole.len(), "nothing was lost: the terminal never stalled");
    // Where text was dropped one line is cut, and what follows is whole again.
    assert!(broken.iter().all(|cut| whole.iter().any(|line| line.starts_with(cut.as_str()))), "{broken:?}");
    println!("{} lines, {} cut", lines.len(), broken.len());
    assert!(broken.len() <= 20, "{} lines of {} are broken", broken.len(), lines.len());
    assert!(ok(&mut board, "version").is_ok());
    assert_eq!(ok(&mut board, "status").value("faults"), Some("0"));
}
