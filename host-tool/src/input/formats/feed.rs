//! The bytes of a file, a piece at a time: however large it is, only a buffer of it is in memory.

use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use std::io::{ErrorKind, Read};

const BUFFER_BYTES: usize = 1 << 18;

/// Looks ahead into a source of bytes.
pub struct Feed<R> {
    source: R,
    buffer: Vec<u8>,
    from: usize,
    position: u64,
    ended: bool,
    progress: Progress,
}

impl<R: Read> Feed<R> {
    /// Reads from `source`; `progress` follows the bytes that were passed.
    pub fn new(source: R, progress: Progress) -> Self {
        Feed { source, buffer: Vec::new(), from: 0, position: 0, ended: false, progress }
    }

    /// The next `count` bytes without passing them; fewer only at the end of the source.
    ///
    /// # Errors
    /// The source cannot be read.
    pub fn ahead(&mut self, count: usize) -> Outcome<&[u8]> {
        if self.buffer.len() - self.from < count && !self.ended {
            self.fill(count)?;
        }
        let end = self.buffer.len().min(self.from + count);
        Ok(self.buffer.get(self.from..end).unwrap_or_default())
    }

    /// Passes `count` bytes, which [`Feed::ahead`] has shown.
    pub fn pass(&mut self, count: usize) {
        let count = count.min(self.buffer.len() - self.from);
        self.from += count;
        self.position += count as u64;
    }

    /// Bytes passed so far.
    pub fn position(&self) -> u64 {
        self.position
    }

    fn fill(&mut self, count: usize) -> Outcome<()> {
        self.buffer.drain(..self.from);
        self.from = 0;
        self.progress.at(self.position);
        while self.buffer.len() < count {
            let held = self.buffer.len();
            // A step at a time: what a broken length asks for is never more than the file has.
            self.buffer.resize(held + BUFFER_BYTES, 0);
            let read = loop {
                match self.source.read(self.buffer.get_mut(held..).unwrap_or_default()) {
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    other => break other,
                }
            };
            self.buffer.truncate(held + read.as_ref().copied().unwrap_or(0));
            match read {
                Ok(0) => {
                    self.ended = true;
                    return Ok(());
                }
                Ok(_) => {}
                Err(error) => return Err(Failure::usage(format!("cannot read: {error}"))),
            }
        }
        Ok(())
    }

    /// Passes `count` bytes that nobody needs to see; false where the source has fewer.
    ///
    /// # Errors
    /// The source cannot be read.
    pub fn skip(&mut self, mut count: u64) -> Outcome<bool> {
        while count > 0 {
            let step = usize::try_from(count).unwrap_or(usize::MAX).min(BUFFER_BYTES);
            let seen = self.ahead(step)?.len();
            self.pass(seen);
            count -= seen as u64;
            if seen < step {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// `N` bytes at `at`; `None` beyond the end.
pub fn bytes_at<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at.checked_add(N)?)?.try_into().ok()
}

/// A little-endian 16-bit number at `at`.
pub fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes_at(bytes, at).map(u16::from_le_bytes)
}

/// A little-endian 64-bit number at `at`.
pub fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes_at(bytes, at).map(u64::from_le_bytes)
}
