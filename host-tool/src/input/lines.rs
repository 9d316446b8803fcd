//! The lines of a log as they stand, for copying.

use super::guard::Guard;
use crate::failure::{Failure, Outcome};
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// Lines without their ends, byte order mark removed.
pub struct Lines {
    reader: BufReader<Guard<File>>,
    line: Vec<u8>,
}

/// Opens the file for [`Lines::next_line`].
pub fn plain_lines(path: &Path) -> Outcome<Lines> {
    let file = File::open(path).map_err(|error| Failure::io("open", path, &error))?;
    Ok(Lines { reader: BufReader::with_capacity(1 << 16, Guard::new(file)), line: Vec::new() })
}

impl Lines {
    /// The next line; `None` at the end.
    pub fn next_line(&mut self) -> io::Result<Option<&[u8]>> {
        self.line.clear();
        if self.reader.read_until(b'\n', &mut self.line)? == 0 {
            return Ok(None);
        }
        while matches!(self.line.last(), Some(b'\n' | b'\r')) {
            self.line.pop();
        }
        Ok(Some(&self.line))
    }
}
