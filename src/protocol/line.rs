//! Bytes of a serial line into command lines.

use super::motioncal::{PACKET_BEGINS, PACKET_BYTES};
use heapless::Vec;

/// The most characters a line may have, its end not counted.
pub const MAX_LINE: usize = 80;

/// A line that has ended. Empty lines are not reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line<'a> {
    /// Printable ASCII.
    Text(&'a str),
    /// It had more than [`MAX_LINE`] characters; none of it is kept.
    TooLong,
    /// It held a byte outside 0x20–0x7e.
    NotText,
    /// No line: a packet of MotionCal's, whole and not looked into.
    Packet(&'a [u8; PACKET_BYTES]),
}

/// Collects bytes up to the end of a line. However long or broken the input, it needs 80 bytes, and the next
/// line starts afresh.
#[derive(Debug, Clone, Default)]
pub struct LineSplitter {
    buffer: Vec<u8, MAX_LINE>,
    /// The line that was reported last is still in `buffer`.
    ended: bool,
    /// A `\r` came: fine before `\n`, not text anywhere else.
    carriage_return: bool,
    too_long: bool,
    not_text: bool,
    /// The bytes belong to a packet.
    packet: bool,
}

impl LineSplitter {
    /// At the beginning of a line.
    pub const fn new() -> Self {
        Self {
            buffer: Vec::new(),
            ended: false,
            carriage_return: false,
            too_long: false,
            not_text: false,
            packet: false,
        }
    }

    /// Takes one byte; returns the line that it ends.
    pub fn push(&mut self, byte: u8) -> Option<Line<'_>> {
        self.push_or_packet(byte, false)
    }

    /// The same where, with `packets`, packets of MotionCal's may come between lines. One is told by its third byte: it is no text,
    /// because MotionCal's first number is zero.
    pub fn push_or_packet(&mut self, byte: u8, packets: bool) -> Option<Line<'_>> {
        if self.ended {
            *self = Self::new();
        }
        let is_text = matches!(byte, 0x20..=0x7e | b'\n' | b'\r');
        self.packet |= packets && !is_text && self.buffer == PACKET_BEGINS;
        if self.packet {
            // There is room: a line may be longer.
            self.too_long |= self.buffer.push(byte).is_err();
            self.ended = self.buffer.len() == PACKET_BYTES;
            return self.last();
        }
        match byte {
            b'\n' => {
                self.ended = true;
                return self.line();
            }
            b'\r' if !self.carriage_return => self.carriage_return = true,
            0x20..=0x7e => {
                self.not_text |= self.carriage_return;
                self.too_long |= self.buffer.push(byte).is_err();
            }
            _ => {
                self.not_text = true;
                // It counts as a character, so that an endless run of such bytes is too long as well.
                self.too_long |= self.buffer.push(b'?').is_err();
            }
        }
        None
    }

    /// The line that [`Self::push`] returned last, until the next byte.
    pub fn last(&self) -> Option<Line<'_>> {
        if self.ended { self.line() } else { None }
    }

    fn line(&self) -> Option<Line<'_>> {
        if self.packet {
            Some(self.buffer.as_slice().try_into().map_or(Line::NotText, Line::Packet))
        } else if self.too_long {
            Some(Line::TooLong)
        } else if self.not_text {
            Some(Line::NotText)
        } else if self.buffer.is_empty() {
            None
        } else {
            // Only ASCII was pushed, so this cannot fail; it need not panic either.
            Some(core::str::from_utf8(&self.buffer).map_or(Line::NotText, Line::Text))
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Line, LineSplitter};
    use std::string::{String, ToString};
    use std::vec::Vec;

    /// Every line that `bytes` contain, texts as they are, others by name.
    fn lines(bytes: &[u8]) -> Vec<String> {
        let mut splitter = LineSplitter::new();
        let mut found = Vec::new();
        for &byte in bytes {
            match splitter.push(byte) {
                Some(Line::Text(text)) => found.push(text.to_string()),
                Some(Line::TooLong) => found.push("TOO LONG".to_string()),
                Some(Line::NotText) => found.push("NOT TEXT".to_string()),
                Some(Line::Packet(_)) => panic!("none was asked for"),
                None => {}
            }
        }
        found
    }

    #[test]
    fn a_packet_is_told_from_a_line_and_only_where_one_may_come() {
        let mut packet = [0; 68];
        packet[..2].copy_from_slice(&[117, 84]);
        packet[60] = b'\n';
        let bytes = [b"uTx\n", &packet[..], b"help\n"].concat();
        let mut splitter = LineSplitter::new();
        let mut found = Vec::new();
        for &byte in &bytes {
            match splitter.push_or_packet(byte, true) {
                Some(Line::Packet(bytes)) => {
                    assert_eq!(bytes, &packet);
                    found.push("PACKET".to_string());
                }
                Some(Line::Text(text)) => found.push(text.to_string()),
                Some(other) => panic!("{other:?}"),
                None => {}
            }
        }
        assert_eq!(found, ["uTx", "PACKET", "help"]);
        assert_eq!(
            lines(&bytes),
            ["uTx", "NOT TEXT", "NOT TEXT"],
            "eight zeros are the beginning of the last"
        );
    }

    #[test]
    fn both_line_ends_and_no_line_for_nothing() {
        assert_eq!(lines(b"status\ncal start\r\n\n\r\nhelp\nunfinished"), ["status", "cal start", "help"]);
    }

    #[test]
    fn eighty_characters_are_a_line_and_eighty_one_are_too_long() {
        let eighty = [b'x'; 80];
        assert_eq!(lines(&[&eighty[..], b"\r\n"].concat()), [String::from_utf8(eighty.to_vec()).unwrap()]);
        assert_eq!(lines(&[&eighty[..], b"x\nhelp\n"].concat()), ["TOO LONG", "help"]);
        assert_eq!(lines(&[&[b'y'; 100_000][..], b"\nhelp\n"].concat()), ["TOO LONG", "help"]);
    }

    #[test]
    fn bytes_that_are_no_text_spoil_their_line_only() {
        assert_eq!(lines(b"sta\x00tus\nhelp\n"), ["NOT TEXT", "help"]);
        assert_eq!(lines(b"\x7f\n\xc3\xa9\n\t\nhelp\n"), ["NOT TEXT", "NOT TEXT", "NOT TEXT", "help"]);
        assert_eq!(lines(b"sta\rtus\n\r\r\nhelp\n"), ["NOT TEXT", "NOT TEXT", "help"]);
        assert_eq!(lines(&[&[0xff; 81][..], b"\nhelp\n"].concat()), ["TOO LONG", "help"]);
    }
}
