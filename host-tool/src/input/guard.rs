//! A reader in front of the CSV parser that stops on what is not a CSV log: binary files, other encodings, lines
//! without end, quotes that never close. It counts lines, so that the place can be named.

use std::io::{self, Read};

/// The longest line a log may have, in bytes. A thousand columns of 15 digits are 16 KB.
pub const MAX_LINE_BYTES: usize = 256 * 1024;

/// What the guard found; carried inside an [`io::Error`] through the CSV parser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objection {
    /// A zero byte: the file is not text.
    Binary,
    /// A UTF-16 byte order mark.
    Utf16,
    /// A line longer than [`MAX_LINE_BYTES`].
    LongLine,
    /// An odd number of quotes in a line: a quoted cell that runs on.
    OpenQuote,
}

/// [`Objection`] and the line it is about, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stop {
    /// What was found.
    pub objection: Objection,
    /// Where.
    pub line: u64,
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self.objection {
            Objection::Binary => {
                "this is not text (it contains zero bytes). Expected a CSV log with a header line such as \
                 t_s,mx_ut,my_ut,mz_ut. Convert a binary log first"
            }
            Objection::Utf16 => "this is UTF-16 text: save the file as UTF-8 (CSV UTF-8 in a spreadsheet)",
            Objection::LongLine => {
                "the line is longer than 262144 bytes. A log has one sample per line. Is a line break missing?"
            }
            Objection::OpenQuote => {
                "a quote (\") is opened and not closed on this line: close it, or remove the quotes"
            }
        })
    }
}

impl std::error::Error for Stop {}

/// Passes bytes on, without a byte order mark, as long as they look like lines of text.
pub struct Guard<R> {
    inner: R,
    line: u64,
    line_bytes: usize,
    odd_quotes: bool,
    comment: bool,
    started: bool,
    bytes: u64,
}

impl<R: Read> Guard<R> {
    /// Guards `inner`.
    pub fn new(inner: R) -> Self {
        Guard { inner, line: 1, line_bytes: 0, odd_quotes: false, comment: false, started: false, bytes: 0 }
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    fn stop(&self, objection: Objection) -> io::Error {
        io::Error::new(io::ErrorKind::InvalidData, Stop { objection, line: self.line })
    }

    fn inspect(&mut self, mut chunk: &[u8]) -> io::Result<()> {
        if memchr::memchr(0, chunk).is_some() {
            return Err(self.stop(Objection::Binary));
        }
        while !chunk.is_empty() {
            let end = memchr::memchr(b'\n', chunk);
            let part = &chunk[..end.unwrap_or(chunk.len())];
            if self.line_bytes == 0 {
                self.comment = part.first() == Some(&b'#');
            }
            self.line_bytes += part.len();
            if self.line_bytes > MAX_LINE_BYTES {
                return Err(self.stop(Objection::LongLine));
            }
            if !self.comment && memchr::memchr_iter(b'"', part).count() % 2 == 1 {
                self.odd_quotes = !self.odd_quotes;
            }
            let Some(end) = end else { break };
            if self.odd_quotes {
                return Err(self.stop(Objection::OpenQuote));
            }
            self.line += 1;
            self.line_bytes = 0;
            chunk = &chunk[end + 1..];
        }
        Ok(())
    }
}

impl<R: Read> Read for Guard<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.len() < 3 {
            return self.inner.read(buffer);
        }
        let mut count = self.inner.read(buffer)?;
        if !self.started {
            // The mark is three bytes: a reader may hand them over one by one.
            while count > 0 && count < 3 {
                match self.inner.read(&mut buffer[count..])? {
                    0 => break,
                    more => count += more,
                }
            }
            self.started = true;
            self.bytes += count as u64;
            if buffer[..count].starts_with(&[0xff, 0xfe]) || buffer[..count].starts_with(&[0xfe, 0xff]) {
                return Err(self.stop(Objection::Utf16));
            }
            if buffer[..count].starts_with(&[0xef, 0xbb, 0xbf]) {
                buffer.copy_within(3..count, 0);
                count -= 3;
                if count == 0 {
                    return self.read(buffer);
                }
            }
        } else {
            self.bytes += count as u64;
        }
        self.inspect(&buffer[..count])?;
        if count == 0 && self.odd_quotes {
            return Err(self.stop(Objection::OpenQuote));
        }
        Ok(count)
    }
}
