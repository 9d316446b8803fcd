//! The lines of `cal load`.

use super::{Command, LOAD_LINE_BYTES, Load, LoadBytes, MAX_LINE, ParseError, parse};

#[test]
fn the_three_lines_are_read() {
    assert_eq!(
        parse("cal load begin 512 00c0FFEE"),
        Ok(Command::CalLoad(Load::Begin { bytes: 512, crc: 0x00c0_ffee }))
    );
    assert_eq!(parse("cal load end"), Ok(Command::CalLoad(Load::End)));
    let Ok(Command::CalLoad(Load::Data { offset: 484, bytes })) = parse("cal load data 484 00ff7A") else {
        panic!("no data")
    };
    assert_eq!(bytes.as_slice(), [0, 0xff, 0x7a]);
}

#[test]
fn the_longest_line_is_no_longer_than_lines_are() {
    let mut line = heapless::String::<MAX_LINE>::new();
    line.push_str("cal load data 484 ").expect("room");
    for _ in 0..LOAD_LINE_BYTES {
        line.push_str("5a").expect("room");
    }
    let Ok(Command::CalLoad(Load::Data { bytes, .. })) = parse(&line) else { panic!("{line}") };
    assert_eq!(bytes.as_slice(), [0x5a; LOAD_LINE_BYTES]);
    line.push_str("5a").expect("room");
    assert!(matches!(parse(&line), Err(ParseError::Usage(_))));
}

#[test]
fn what_is_written_otherwise_is_refused() {
    for line in [
        "cal load",
        "cal load begin",
        "cal load begin 512",
        "cal load begin +512 00c0ffee",
        "cal load begin 70000 00c0ffee",
        "cal load begin 512 c0ffee",
        "cal load begin 512 +0c0ffee",
        "cal load begin 512 00c0ffee now",
        "cal load data 0",
        "cal load data 0 0",
        "cal load data 0 0g",
        "cal load data -1 00",
        "cal load data 0 00 11",
        "cal load end now",
        "cal load rest",
    ] {
        assert!(matches!(parse(line), Err(ParseError::Usage(_))), "{line}");
    }
    assert_eq!(LoadBytes::from_hex(""), None);
    assert_eq!(LoadBytes::from_hex("é"), None);
}
