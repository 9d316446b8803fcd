//! The records of an MCAP file (mcap.dev/spec): framed here, so that a file that is cut off or broken gives what is whole in it;
//! packed chunks are unpacked in `packed`.

use crate::failure::Outcome;
use crate::input::formats::feed::{Feed, bytes_at, u16_at, u64_at};
use crate::input::formats::ros::packed::{self, Packing};
use std::io::Read;

/// The kinds of records that are read.
pub mod op {
    #![allow(missing_docs)] // as the specification names them
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const DATA_END: u8 = 0x0f;
}

const MAGIC_BYTES: usize = 8;
/// Kind and length.
const HEAD_BYTES: usize = 9;
/// Times, sizes and checksum of a chunk before the name of its compression.
const CHUNK_BYTES: usize = 32;
/// `zstd` and `lz4` are shorter.
const LONGEST_NAME: usize = 64;
/// The largest record, bytes: a picture of a camera next to the sensors, and no more than memory bears.
const LARGEST_RECORD: u64 = 1 << 28;
/// A packed chunk of any file may have records of so many bytes; that of a larger file of so many times its size.
const SMALL_RECORD: u64 = 1 << 20;
const PACKED: u64 = 16;

/// Passes every record of the data to `take`: its kind and its content. Gives what is to be said of the end.
///
/// # Errors
/// The source cannot be read.
pub fn records(
    feed: &mut Feed<impl Read>,
    size_bytes: u64,
    take: &mut impl FnMut(u8, &[u8]),
) -> Outcome<Vec<String>> {
    let mut notices = Vec::new();
    let magic = feed.ahead(MAGIC_BYTES)?.len();
    feed.pass(magic);
    loop {
        let head = feed.ahead(HEAD_BYTES)?;
        let (Some(&kind), Some(length)) = (head.first(), u64_at(head, 1)) else {
            notices.push(cut_off(feed));
            return Ok(notices);
        };
        match kind {
            // What follows repeats what was read, for readers that jump.
            op::DATA_END | op::FOOTER => return Ok(notices),
            op::CHUNK => match chunk(feed, length, size_bytes, take)? {
                Chunk::Whole => {}
                Chunk::CutOff => {
                    notices.push(cut_off(feed));
                    return Ok(notices);
                }
                Chunk::Broken(why) => {
                    notices.push(format!(
                        "a chunk before byte {} is damaged ({why}). ironout skips the rest of it",
                        feed.position()
                    ));
                }
            },
            op::SCHEMA | op::CHANNEL | op::MESSAGE if length <= LARGEST_RECORD => {
                let whole = HEAD_BYTES + usize::try_from(length).unwrap_or(usize::MAX);
                match feed.ahead(whole)?.get(HEAD_BYTES..whole) {
                    Some(content) => take(kind, content),
                    None => {
                        notices.push(cut_off(feed));
                        return Ok(notices);
                    }
                }
                feed.pass(whole);
            }
            _ => {
                if !feed.skip(length.saturating_add(HEAD_BYTES as u64))? {
                    notices.push(cut_off(feed));
                    return Ok(notices);
                }
            }
        }
    }
}

fn cut_off(feed: &Feed<impl Read>) -> String {
    format!("the file is truncated or damaged at byte {}. ironout read up to there", feed.position())
}

enum Chunk {
    Whole,
    CutOff,
    Broken(String),
}

/// One chunk. The records of one that is not packed stand there as outside of it: only its head is passed.
fn chunk(
    feed: &mut Feed<impl Read>,
    length: u64,
    size_bytes: u64,
    take: &mut impl FnMut(u8, &[u8]),
) -> Outcome<Chunk> {
    let head = feed.ahead(HEAD_BYTES + CHUNK_BYTES + LONGEST_NAME)?;
    let Some(name) = bytes_at::<4>(head, HEAD_BYTES + CHUNK_BYTES - 4) else { return Ok(Chunk::CutOff) };
    if u32::from_le_bytes(name) == 0 {
        let own = HEAD_BYTES + CHUNK_BYTES + 8;
        return Ok(if feed.skip(own as u64)? { Chunk::Whole } else { Chunk::CutOff });
    }
    let most = match size_bytes {
        0 => LARGEST_RECORD,
        size => size.saturating_mul(PACKED).clamp(SMALL_RECORD, LARGEST_RECORD),
    };
    let Some((name, behind)) = text(head, HEAD_BYTES + CHUNK_BYTES - 4) else {
        return Ok(match feed.skip(length.saturating_add(HEAD_BYTES as u64))? {
            true => Chunk::Broken("its compression has no name".into()),
            false => Chunk::CutOff,
        });
    };
    // Behind the name stands the length of what is packed.
    let own = behind + 8;
    let Some(packed) = length.checked_sub((own - HEAD_BYTES) as u64) else {
        return Ok(match feed.skip(length.saturating_add(HEAD_BYTES as u64))? {
            true => Chunk::Broken("it is shorter than its head".into()),
            false => Chunk::CutOff,
        });
    };
    if !feed.skip(own as u64)? {
        return Ok(Chunk::CutOff);
    }
    let Some(packing) = Packing::named(&name) else {
        return Ok(match feed.skip(packed)? {
            true => Chunk::Broken(format!("its compression {name} is neither zstd nor lz4")),
            false => Chunk::CutOff,
        });
    };
    let (outcome, left) = packed::records(feed, packed, packing, most, take);
    if !feed.skip(left)? {
        return Ok(Chunk::CutOff);
    }
    Ok(match outcome {
        Ok(()) => Chunk::Whole,
        Err(why) => Chunk::Broken(why),
    })
}

/// A text with its length before it, and the byte behind it.
fn text(content: &[u8], at: usize) -> Option<(String, usize)> {
    let length = usize::try_from(u32::from_le_bytes(bytes_at(content, at)?)).ok()?;
    let from = at + 4;
    let end = from.checked_add(length)?;
    Some((String::from_utf8_lossy(content.get(from..end)?).into_owned(), end))
}

/// A schema: its number and name.
pub fn schema(content: &[u8]) -> Option<(u16, String)> {
    Some((u16_at(content, 0)?, text(content, 2)?.0))
}

/// A channel of messages.
#[derive(Debug, Clone)]
pub struct Channel {
    /// The number of its schema.
    pub schema: u16,
    /// Its topic.
    pub topic: String,
    /// How its messages are written.
    pub encoding: String,
}

/// A channel: its number and what it is.
pub fn channel(content: &[u8]) -> Option<(u16, Channel)> {
    let (topic, behind) = text(content, 4)?;
    let (encoding, _) = text(content, behind)?;
    Some((u16_at(content, 0)?, Channel { schema: u16_at(content, 2)?, topic, encoding }))
}

/// A message: the number of its channel, the time at which it was recorded in ns, and its content.
pub fn message(content: &[u8]) -> Option<(u16, i64, &[u8])> {
    // Channel, number in the sequence, time of recording, time of publishing.
    Some((u16_at(content, 0)?, u64_at(content, 6)?.cast_signed(), content.get(22..)?))
}
