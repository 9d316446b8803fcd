//! The lines of a log and the cells of a line.

use crate::failure::{Failure, Outcome};
use crate::input::guard::{Guard, Stop};
use crate::input::read_as::Origin;
use std::io::{self, BufRead, BufReader, Read};

/// One line of a log, without its end.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a> {
    /// Its bytes.
    pub text: &'a [u8],
    /// Its number, from 1.
    pub number: u64,
    /// Whether a line break followed: where none did, the recording may have been cut off.
    pub ended: bool,
}

impl Line<'_> {
    /// Whether it is the header or a row, and not a comment or empty.
    pub fn is_row(&self) -> bool {
        self.text.first() != Some(&b'#') && !self.text.trim_ascii().is_empty()
    }
}

/// Reads a log line by line, byte order mark removed.
pub struct Lines<R> {
    reader: BufReader<Guard<R>>,
    buffer: Vec<u8>,
    number: u64,
    origin: Origin,
}

/// The values of `# vehicle: …`, `# sensor: …` and `# start: …`; the first of each counts.
fn take_origin(comment: &[u8], origin: &mut Origin) {
    let text = String::from_utf8_lossy(comment);
    let Some((key, value)) = text.trim_start_matches('#').split_once(':') else { return };
    let value: String = value.trim().chars().filter(|c| !c.is_control()).take(MAX_ORIGIN_CHARS).collect();
    let slot = match key.trim() {
        "vehicle" => &mut origin.vehicle,
        "sensor" => &mut origin.sensor,
        "start" => &mut origin.start,
        _ => return,
    };
    if !value.is_empty() {
        slot.get_or_insert(value);
    }
}

/// An identifier is not text.
const MAX_ORIGIN_CHARS: usize = 80;

impl<R: Read> Lines<R> {
    /// Reads from `source`.
    pub fn new(source: R) -> Self {
        Lines {
            reader: BufReader::with_capacity(1 << 16, Guard::new(source)),
            buffer: Vec::new(),
            number: 0,
            origin: Origin::default(),
        }
    }

    /// The next line; `None` at the end. Errors name the line.
    pub fn next_line(&mut self) -> Outcome<Option<Line<'_>>> {
        self.buffer.clear();
        if self.reader.read_until(b'\n', &mut self.buffer).map_err(|error| broken(&error))? == 0 {
            return Ok(None);
        }
        self.number += 1;
        let ended = self.buffer.last() == Some(&b'\n');
        while matches!(self.buffer.last(), Some(b'\n' | b'\r')) {
            self.buffer.pop();
        }
        Ok(Some(Line { text: &self.buffer, number: self.number, ended }))
    }

    /// The next line that is the header or a row.
    pub fn next_row(&mut self) -> Outcome<Option<Line<'_>>> {
        let ended = loop {
            match self.next_line()? {
                None => return Ok(None),
                Some(line) if line.is_row() => break line.ended,
                Some(_) => {}
            }
            // The line that was passed over is still in the buffer.
            if self.buffer.first() == Some(&b'#') {
                take_origin(&self.buffer, &mut self.origin);
            }
        };
        // Borrowed again: a line that is returned from inside the loop would be borrowed in every round.
        Ok(Some(Line { text: &self.buffer, number: self.number, ended }))
    }

    /// What the comments so far say of the log's origin.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.reader.get_ref().bytes()
    }
}

fn broken(error: &io::Error) -> Failure {
    match error.get_ref().and_then(|inner| inner.downcast_ref::<Stop>()) {
        Some(stop) => Failure::usage(stop.to_string()).at_line(stop.line),
        None => Failure::usage(format!("cannot read: {error}")),
    }
}

/// Cuts lines into cells: at every comma where there are no quotes, by the rules of CSV where there are.
pub struct Cutter {
    quoted: csv::ByteRecord,
    ends: Vec<usize>,
}

impl Cutter {
    /// A cutter.
    pub fn new() -> Self {
        Cutter { quoted: csv::ByteRecord::new(), ends: Vec::new() }
    }

    /// Cuts a line; the cells are then at [`Cutter::cell`]. Gives their number.
    pub fn cut(&mut self, text: &[u8]) -> usize {
        self.ends.clear();
        self.quoted.clear();
        if memchr::memchr(b'"', text).is_none() {
            self.ends.extend(memchr::memchr_iter(b',', text));
            self.ends.push(text.len());
            return self.ends.len();
        }
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text);
        // A line in memory cannot fail to be read; quotes are balanced, the guard saw to that.
        match reader.read_byte_record(&mut self.quoted) {
            Ok(true) => self.quoted.len(),
            _ => 0,
        }
    }

    /// A cell of the line that was cut last.
    pub fn cell<'a>(&'a self, text: &'a [u8], index: usize) -> &'a [u8] {
        if self.ends.is_empty() {
            return self.quoted.get(index).unwrap_or_default();
        }
        let start = if index == 0 { 0 } else { self.ends.get(index - 1).map_or(0, |end| end + 1) };
        let end = self.ends.get(index).copied().unwrap_or(start);
        text.get(start..end).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> Vec<String> {
        let mut cutter = Cutter::new();
        let count = cutter.cut(text.as_bytes());
        (0..count).map(|i| String::from_utf8_lossy(cutter.cell(text.as_bytes(), i)).into_owned()).collect()
    }

    #[test]
    fn cells_with_and_without_quotes() {
        assert_eq!(cells("a,,c"), ["a", "", "c"]);
        assert_eq!(cells(",").len(), 2);
        assert_eq!(cells("\"a,b\",c,\"d \"\"e\"\"\""), ["a,b", "c", "d \"e\""]);
    }

    #[test]
    fn lines_of_any_ending_are_numbered_with_comments_and_gaps() {
        let mut lines = Lines::new("\u{feff}# c\r\n\r\na,b\r\n  \n#x\n1,2".as_bytes());
        let mut seen = Vec::new();
        while let Some(line) = lines.next_row().expect("text") {
            seen.push((line.number, String::from_utf8_lossy(line.text).into_owned()));
        }
        assert_eq!(seen, [(3, "a,b".to_string()), (6, "1,2".to_string())]);
    }
}
