//! A calibration that comes in over the console: whole and sound it waits to be accepted, and cut anywhere it changes nothing.

use crate::common::records;
use crate::common::{accepted_board, last, value, world_board};
use ironout::effect::{BuiltIn, Drift, Gain, Nonlinearity, Offset};
use ironout::protocol::LOAD_LINE_BYTES;
use ironout::record::Record;
use ironout::sensor::AxisMap;
use ironout_rig::board::SimBoard;
use ironout_rig::chips::TornPage;
use ironout_simulation::Motion;
use std::fmt::Write;

/// The lines that load these bytes.
fn lines(bytes: &[u8]) -> String {
    let crc = bytes.last_chunk().copied().map_or(0, u32::from_le_bytes);
    let mut text = format!("cal load begin {} {crc:08x}\n", bytes.len());
    for (line, chunk) in bytes.chunks(LOAD_LINE_BYTES).enumerate() {
        write!(text, "cal load data {} ", line * LOAD_LINE_BYTES).unwrap();
        chunk.iter().for_each(|byte| write!(text, "{byte:02x}").unwrap());
        text.push('\n');
    }
    text + "cal load end\n"
}

/// A calibration with two effects, and a board that has another one in use.
fn two_effects() -> Record {
    let column = ironout::effect::ColumnName::new("temp_c").unwrap();
    records::with(&[
        BuiltIn::Offset(Offset::linear(column, 25.0)),
        BuiltIn::Gain(Gain { column, reference: 1.0 / 3.0 }),
    ])
}

/// What is in use, and what stands in the memory.
fn in_use(board: &mut SimBoard) -> (Vec<String>, Vec<u8>) {
    let shown = board.command("cal show");
    let memory = board.eeprom.borrow().memory.clone();
    (shown, memory)
}

/// Sends lines; the last answer.
fn send(board: &mut SimBoard, text: &str) -> String {
    board.received();
    board.send(text.as_bytes());
    board.received().pop().unwrap_or_default()
}

#[test]
fn a_whole_calibration_waits_is_accepted_and_survives_a_restart_with_every_bit() {
    let mut board = accepted_board(41);
    let record = two_effects();
    let before = in_use(&mut board);
    let bytes = records::bytes(&record);
    assert_eq!(send(&mut board, &lines(&bytes)), "ok state=solved effects=2 field_ut=48.123456789");
    // It waits: what is in use still is.
    assert_eq!(in_use(&mut board), before);
    let status = last(&mut board, "status");
    assert_eq!(value(&status, "state"), "solved", "{status}");
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1 slot=1 sequence=2"));
    let stored = *board.device.record().expect("in use");
    let axes = Some(AxisMap::IDENTITY);
    assert_eq!(stored, Record { sequence: 2, axes, ..record });
    assert_eq!(value(&last(&mut board, "status"), "state"), "idle");
    board.restart();
    board.run_ms(100);
    assert_eq!(board.device.record(), Some(&stored));
    // And the record goes out as it came in, but for its number and the mounting.
    let dump = board.command("cal dump");
    assert_eq!(value(dump.last().unwrap(), "covariance"), "0", "the one that was sent had none");
    let dumped = dumped(&dump);
    assert_eq!(Record::decode(&dumped), Ok(stored));
}

/// The bytes that `cal dump` says.
fn dumped(lines: &[String]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for line in lines.iter().filter_map(|line| line.strip_prefix("+ record=")) {
        let (offset, hex) = line.split_once(' ').expect("offset and bytes");
        assert_eq!(offset.parse(), Ok(bytes.len()));
        let pairs = hex.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap());
        bytes.extend(pairs.map(|pair| u8::from_str_radix(pair, 16).unwrap()));
    }
    bytes
}

#[test]
fn a_transfer_cut_anywhere_changes_nothing() {
    let mut fresh = accepted_board(42);
    let before = in_use(&mut fresh);
    let record = two_effects();
    let whole = lines(&records::bytes(&record));
    // Cut after each byte but the last, which is the end of the last line: then the power goes, or a new transfer begins after half a line, or nothing more comes.
    for cut in 0..whole.len() - 1 {
        let (half, _) = whole.split_at(cut);
        fresh.send(half.as_bytes());
        match cut % 3 {
            0 => {
                fresh.restart();
                fresh.run_ms(100);
            }
            1 => {
                // Whatever is left of the line is a line of its own.
                send(&mut fresh, "\n");
                let answer = send(&mut fresh, &whole);
                assert!(answer.starts_with("ok state=solved"), "cut at {cut}: {answer}");
                assert!(last(&mut fresh, "cal cancel").starts_with("ok"));
            }
            _ => {
                send(&mut fresh, "\n");
                let refused = last(&mut fresh, "cal accept");
                assert!(refused.starts_with("err state"), "cut at {cut}: {refused}");
            }
        }
        assert_eq!(in_use(&mut fresh), before, "cut at {cut}");
    }
}

#[test]
fn what_is_not_what_was_sent_is_refused_whatever_bit_was_lost() {
    let mut board = accepted_board(43);
    let before = in_use(&mut board);
    let bytes = records::bytes(&two_effects());
    for bit in 0..8 * bytes.len() {
        let mut spoilt = bytes.clone();
        spoilt[bit / 8] ^= 1 << (bit % 8);
        // The announcement is of what was meant.
        let text = lines(&spoilt).replacen(
            lines(&spoilt).lines().next().unwrap(),
            lines(&bytes).lines().next().unwrap(),
            1,
        );
        let answer = send(&mut board, &text);
        assert!(answer.starts_with("err refused crc "), "bit {bit}: {answer}");
    }
    // Lines that are lost, come twice, or change places.
    let text = lines(&bytes);
    let all: Vec<&str> = text.lines().collect();
    for line in 1..all.len() - 1 {
        for (name, changed) in [
            ("lost", [&all[..line], &all[line + 1..]].concat()),
            ("twice", [&all[..=line], &all[line..]].concat()),
        ] {
            let sent = changed.join("\n") + "\n";
            board.received();
            board.send(sent.as_bytes());
            let answers = board.received();
            let refused = answers.iter().any(|answer| answer.starts_with("err state byte "));
            let solved = answers.last().is_some_and(|answer| answer.starts_with("ok state=solved"));
            // Of a line that came twice the second is refused and the rest goes on: the whole is right.
            assert_eq!((refused, solved), (true, name == "twice"), "{name} {line}: {answers:?}");
            let _ = board.command("cal cancel");
        }
    }
    assert_eq!(in_use(&mut board), before);
}

#[test]
fn garbage_and_other_commands_in_between_do_no_harm() {
    let mut board = accepted_board(44);
    let text = lines(&records::bytes(&two_effects()));
    for (at, line) in text.lines().enumerate() {
        for noise in ["status", "hlep", "cal load data 9999 00", "cal load begin 4 00000000", "\u{1}\u{2}"] {
            // `begin` of an impossible length is refused before anything is dropped.
            let answer = send(&mut board, &format!("{noise}\n"));
            assert!(!answer.is_empty(), "{noise}");
        }
        let answer = send(&mut board, &format!("{line}\n"));
        assert!(answer.starts_with("ok"), "{at} {line}: {answer}");
    }
    assert!(last(&mut board, "cal accept").starts_with("ok calibrated=1"));
}

#[test]
fn power_lost_while_it_is_stored_leaves_the_old_or_the_new_one_whole() {
    let record = two_effects();
    let text = lines(&records::bytes(&record));
    let mut old = accepted_board(45);
    let before = *old.device.record().expect("in use");
    let mut seen = [false; 2];
    let memory = old.eeprom.borrow().memory.clone();
    let length = records::bytes(&record).len();
    // Cut after each byte that reaches the cells, and whatever the cells do with the byte after it.
    let torn_pages = [TornPage::Old, TornPage::Erased, TornPage::Garbage];
    for (bytes, torn_page) in (0..=length).flat_map(|bytes| torn_pages.map(|torn| (bytes, torn))) {
        let board = &mut old;
        board.eeprom.borrow_mut().memory.clone_from(&memory);
        board.restart();
        board.run_ms(100);
        send(board, &text);
        board.eeprom.borrow_mut().torn_page = torn_page;
        board.eeprom.borrow_mut().lose_power_after(bytes);
        let answer = last(board, "cal accept");
        board.restart();
        board.run_ms(200);
        let found = *board.device.record().expect("one of them");
        let is_new = Record { sequence: 0, axes: None, ..found } == record;
        assert!(is_new || found == before, "cut after {bytes} bytes: {answer} {found:?}");
        seen[usize::from(is_new)] = true;
    }
    assert_eq!(seen, [true, true], "the cuts come before and after the moment that counts");
}

#[test]
fn a_calibration_that_this_board_cannot_use_is_refused_with_a_reason() {
    let mut board = world_board(Motion::Sphere, 46);
    board.run_ms(100);
    let turned = AxisMap::of_code(2).filter(|map| *map != AxisMap::IDENTITY);
    let otherwise = Record { axes: turned, ..two_effects() };
    assert!(otherwise.axes.is_some(), "another mounting");
    let mut newer = records::bytes(&records::record(3.0));
    newer[4] = 77;
    let newer = records::with_crc(newer);
    for (bytes, start) in [
        (records::bytes(&otherwise), "err refused mounting "),
        (newer, "err refused unsupported "),
        // A record at the beginning of something longer.
        ([records::bytes(&records::record(3.0)), vec![0; 60]].concat(), "err refused crc "),
    ] {
        let answer = send(&mut board, &lines(&bytes));
        assert!(answer.starts_with(start), "{answer}");
        assert!(last(&mut board, "cal accept").starts_with("err state"));
    }
    assert!(last(&mut board, "cal load end").starts_with("err state no calibration is being loaded"));
    assert!(last(&mut board, "cal load begin 600 00000000").starts_with("err usage"));
    last(&mut board, "cal start");
    assert!(
        last(&mut board, "cal load begin 148 00000000").starts_with("err state samples are being collected")
    );
}

#[test]
fn one_solution_waits_at_a_time_and_the_last_that_came_counts() {
    let mut board = world_board(Motion::Sphere, 47);
    board.run_ms(100);
    let text = lines(&records::bytes(&records::with(&[BuiltIn::Nonlinearity(Nonlinearity)])));
    assert!(crate::common::calibrate(&mut board, 60).starts_with("ok verdict=accepted"));
    assert!(send(&mut board, &text).starts_with("ok state=solved effects=1"));
    let show = board.command("cal show");
    assert!(show.iter().any(|line| line.starts_with("+ effect=nonlinearity")), "{show:?}");
    assert!(last(&mut board, "cal cancel").starts_with("ok state=idle"));
    assert!(last(&mut board, "cal accept").starts_with("err state"));
    assert!(send(&mut board, &text).starts_with("ok state=solved"));
    // A new calibration forgets it.
    last(&mut board, "cal start");
    last(&mut board, "cal cancel");
    assert!(last(&mut board, "cal accept").starts_with("err state"));
}

#[test]
fn the_dump_of_a_calibration_has_its_covariance_after_a_restart_too() {
    let mut board = accepted_board(48);
    let dump = board.command("cal dump");
    assert!(dump.iter().map(String::len).sum::<usize>() < ironout::device::MAX_REPLY_BYTES);
    assert_eq!(value(dump.last().unwrap(), "covariance"), "1");
    let rows: Vec<Vec<f64>> = dump
        .iter()
        .filter_map(|line| line.strip_prefix("+ covariance="))
        .map(|row| row.split(',').map(|word| word.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.iter().map(Vec::len).collect::<Vec<_>>(), [9, 8, 7, 6, 5, 4, 3, 2, 1]);
    // The standard error of an offset from 3000 samples of 0.05 uT.
    let sigma_ut = rows[0][0].sqrt();
    assert!((5e-4..1e-2).contains(&sigma_ut), "{sigma_ut}");
    assert_eq!(Record::decode(&dumped(&dump)), Ok(*board.device.record().unwrap()));
    board.restart();
    board.run_ms(100);
    assert_eq!(board.command("cal dump"), dump, "to the last digit");
    // It goes with the record: sent to another board, it is there too.
    let mut other = world_board(Motion::Sphere, 52);
    other.run_ms(100);
    assert!(send(&mut other, &lines(&dumped(&dump))).starts_with("ok state=solved effects=0"));
    assert!(last(&mut other, "cal accept").starts_with("ok calibrated=1"));
    let rows = |lines: &[String]| -> Vec<String> {
        lines.iter().filter(|line| line.starts_with("+ covariance=")).cloned().collect()
    };
    assert_eq!(rows(&other.command("cal dump")), rows(&dump));
}

#[test]
fn the_longest_dump_fits_into_a_reply() {
    let effects = records::all_effects();
    let mut longest = 0;
    for four in effects.windows(4) {
        let record = records::with(four);
        let Ok(encoded) = record.encode() else { continue };
        let mut board = world_board(Motion::Sphere, 49);
        let bytes = encoded.as_bytes();
        board.eeprom.borrow_mut().memory[..bytes.len()].copy_from_slice(bytes);
        board.restart();
        board.run_ms(100);
        longest = longest.max(board.command("cal dump").iter().map(|line| line.len() + 1).sum());
    }
    // Nine rows of nine to one numbers of at most 24 characters, which fewer effects leave room for.
    assert!(longest > 1000 && longest + 45 * 24 + 9 * 13 < ironout::device::MAX_REPLY_BYTES, "{longest}");
}

#[test]
fn a_log_is_streamed_with_its_columns_and_its_gaps_by_number() {
    let mut board = accepted_board(50);
    assert_eq!(last(&mut board, "stream log"), "ok stream=log");
    board.run_ms(1000);
    let lines = board.received();
    assert_eq!(lines[0], "H,t_ms,seq,x,y,z,temp_c", "the chip's own temperature is known");
    let numbers = |line: &String| -> Vec<u64> {
        line.split(',').skip(1).take(2).map(|word| word.parse().expect("a number")).collect()
    };
    let rows: Vec<Vec<u64>> = lines[1..].iter().map(numbers).collect();
    assert!((49..=51).contains(&rows.len()));
    assert!(rows.windows(2).all(|pair| pair[1][1] == pair[0][1] + 1 && pair[1][0] == pair[0][0] + 20));
    // Two columns more: named before the next sample, and they hold.
    last(&mut board, "cov temp_c=31.5");
    last(&mut board, "cov current_a=-2");
    board.run_ms(40);
    let lines = board.received();
    assert_eq!(lines[0], "H,t_ms,seq,x,y,z,temp_c,current_a");
    assert!(lines[1].ends_with(",31.5,-2.0"), "{lines:?}");
    let before = numbers(lines.last().unwrap())[1];
    // A sensor that fails for a while: what is missing then is missing in the numbers.
    board.sensor_faults.nack_randomly(7, 1.0);
    board.run_ms(60);
    board.sensor_faults.clear();
    board.run_ms(600);
    let after = board.received().iter().map(|line| numbers(line)[1]).next().expect("it streams again");
    assert!(after >= before, "{before} {after}");
}

#[test]
fn an_effect_of_time_is_loaded_on_its_own_clock() {
    let mut board = world_board(Motion::Sphere, 51);
    board.run_ms(100);
    let record = records::with(&[BuiltIn::Drift(Drift { reference_s: 1.7e9 })]);
    assert!(send(&mut board, &lines(&records::bytes(&record))).starts_with("ok state=solved effects=1"));
    assert!(last(&mut board, "cal accept").starts_with("ok"));
    let stored = *board.device.record().unwrap();
    assert_eq!(Record { sequence: 0, axes: None, ..stored }, record);
}
