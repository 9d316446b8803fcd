//! The records of a packed chunk. The decoders are Rust through and through, so that a browser reads what the desk reads.

use crate::input::formats::feed::{Feed, u64_at};
use std::io::{self, ErrorKind, Read};

/// Kind and length of a record.
const HEAD_BYTES: usize = 9;

/// How a chunk is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// Zstandard.
    Zstd,
    /// Frames of LZ4.
    Lz4,
}

impl Packing {
    /// By the name in the file.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "zstd" => Some(Packing::Zstd),
            "lz4" => Some(Packing::Lz4),
            _ => None,
        }
    }
}

/// The bytes of one chunk in the file, and no more of it.
struct Bounded<'f, R> {
    feed: &'f mut Feed<R>,
    left: u64,
}

impl<R: Read> Read for Bounded<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let want = usize::try_from(self.left).unwrap_or(usize::MAX).min(buffer.len());
        if want == 0 {
            return Ok(0);
        }
        let seen = self.feed.ahead(want).map_err(|failure| io::Error::other(failure.message))?;
        let count = seen.len();
        if let Some(into) = buffer.get_mut(..count) {
            into.copy_from_slice(seen);
        }
        self.feed.pass(count);
        self.left -= count as u64;
        Ok(count)
    }
}

/// Passes the records of the next `packed` bytes to `take`; none may be longer than `most`. Gives what is wrong with them, if
/// anything, and how many of the bytes were not looked at.
pub fn records<R: Read>(
    feed: &mut Feed<R>,
    packed: u64,
    packing: Packing,
    most: u64,
    take: &mut impl FnMut(u8, &[u8]),
) -> (Result<(), String>, u64) {
    let mut bounded = Bounded { feed, left: packed };
    let outcome = match packing {
        Packing::Zstd => ruzstd::decoding::StreamingDecoder::new(&mut bounded)
            .map_err(|error| error.to_string())
            .and_then(|decoder| unpacked(decoder, most, take)),
        Packing::Lz4 => unpacked(lz4_flex::frame::FrameDecoder::new(&mut bounded), most, take),
    };
    (outcome, bounded.left)
}

fn unpacked(mut source: impl Read, most: u64, take: &mut impl FnMut(u8, &[u8])) -> Result<(), String> {
    let mut content = Vec::new();
    loop {
        let mut head = [0; HEAD_BYTES];
        match filled(&mut source, &mut head)? {
            0 => return Ok(()),
            HEAD_BYTES => {}
            _ => return Err("its last record is cut off".into()),
        }
        let [kind, ..] = head;
        let length = u64_at(&head, 1).filter(|length| *length <= most);
        let length = length.ok_or_else(|| "a record in it is longer than the file could hold".to_string())?;
        content.clear();
        let read =
            source.by_ref().take(length).read_to_end(&mut content).map_err(|error| error.to_string())?;
        if (read as u64) < length {
            return Err("its last record is cut off".into());
        }
        take(kind, &content);
    }
}

/// Fills the buffer as far as the source goes.
fn filled(source: &mut impl Read, buffer: &mut [u8]) -> Result<usize, String> {
    let mut count = 0;
    while let Some(rest) = buffer.get_mut(count..).filter(|rest| !rest.is_empty()) {
        match source.read(rest) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error.to_string()),
        }
    }
    Ok(count)
}
