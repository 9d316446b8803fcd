//! Logs that are packed as a whole, by gzip or Zstandard: read as what is in them.

use crate::failure::{Failure, Outcome};
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::io::{self, Cursor, ErrorKind, Read};

/// Bytes that tell how a file is packed.
pub const MARK_BYTES: u64 = 4;
/// Longest content that is unpacked, bytes: a packed file can stand for any number of zeros.
const LONGEST: u64 = 16 << 30;

/// How a file is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// gzip.
    Gzip,
    /// Zstandard.
    Zstd,
}

impl Packing {
    /// By the first bytes.
    pub fn detect(first: &[u8]) -> Option<Self> {
        match first {
            [0x1f, 0x8b, ..] => Some(Packing::Gzip),
            // The mark of a frame, and those of a frame that is skipped.
            [0x28, 0xb5, 0x2f, 0xfd] | [0x50..=0x5f, 0x2a, 0x4d, 0x18] => Some(Packing::Zstd),
            _ => None,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Packing::Gzip => "gzip",
            Packing::Zstd => "zstd",
        }
    }

    /// The content of a source that is packed so.
    ///
    /// # Errors
    /// Its head makes no sense.
    pub fn unpack<'s>(self, source: impl Read + 's) -> Outcome<Unpacked<'s>> {
        let content: Box<dyn Read + 's> = match self {
            Packing::Gzip => Box::new(flate2::read::MultiGzDecoder::new(source)),
            Packing::Zstd => {
                let mut frames = Frames { source, decoder: FrameDecoder::new(), in_frame: false };
                frames.next().map_err(|error| {
                    Failure::usage(format!("this zstd file is damaged: {error}. Fix: copy it again"))
                })?;
                Box::new(frames)
            }
        };
        Ok(Unpacked { content, left: LONGEST, broken: None })
    }
}

/// Content of a packed file. Where the file is broken it ends, and what is wrong is kept.
pub struct Unpacked<'s> {
    content: Box<dyn Read + 's>,
    left: u64,
    broken: Option<String>,
}

impl Unpacked<'_> {
    /// What is wrong with the packed file.
    pub fn broken(&self) -> Option<&str> {
        self.broken.as_deref()
    }
}

impl Read for Unpacked<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.broken.is_some() {
            return Ok(0);
        }
        match self.content.read(buffer) {
            Err(error) if error.kind() != ErrorKind::Interrupted => {
                self.broken = Some(error.to_string());
                Ok(0)
            }
            Ok(count) if count as u64 > self.left => {
                self.broken = Some("its content is longer than 16 GB".into());
                Ok(0)
            }
            Ok(count) => {
                self.left -= count as u64;
                Ok(count)
            }
            interrupted => interrupted,
        }
    }
}

/// Frames of Zstandard one behind the other, as `cat` and programs with several threads write them.
struct Frames<S> {
    source: S,
    decoder: FrameDecoder,
    in_frame: bool,
}

impl<S: Read> Frames<S> {
    /// Goes on to the next frame that holds something; gives whether there is one.
    fn next(&mut self) -> io::Result<bool> {
        loop {
            let mut first = Vec::new();
            if self.source.by_ref().take(1).read_to_end(&mut first)? == 0 {
                return Ok(false);
            }
            match self.decoder.reset(Cursor::new(first).chain(&mut self.source)) {
                Ok(()) => {
                    self.in_frame = true;
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    let length = u64::from(length);
                    if io::copy(&mut self.source.by_ref().take(length), &mut io::sink())? < length {
                        return Err(ErrorKind::UnexpectedEof.into());
                    }
                }
                Err(error) => return Err(io::Error::other(error)),
            }
        }
    }
}

impl<S: Read> Read for Frames<S> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while !buffer.is_empty() && (self.in_frame || self.next()?) {
            while self.decoder.can_collect() == 0 && !self.decoder.is_finished() {
                let some = BlockDecodingStrategy::UptoBytes(buffer.len());
                self.decoder.decode_blocks(&mut self.source, some).map_err(io::Error::other)?;
            }
            match self.decoder.read(buffer)? {
                0 => {
                    self.in_frame = false;
                    let (own, stated) =
                        (self.decoder.get_calculated_checksum(), self.decoder.get_checksum_from_data());
                    if stated.is_some() && own != stated {
                        return Err(io::Error::other("its content has another checksum than it states"));
                    }
                }
                count => return Ok(count),
            }
        }
        Ok(0)
    }
}
