//! Logs that are packed as a whole, by gzip or Zstandard: read as what is in them.

use crate::failure::{Failure, Outcome};
use std::io::{self, ErrorKind, Read};

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
    pub fn told(first: &[u8]) -> Option<Self> {
        match first {
            [0x1f, 0x8b, ..] => Some(Packing::Gzip),
            [0x28, 0xb5, 0x2f, 0xfd] => Some(Packing::Zstd),
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
            Packing::Zstd => Box::new(ruzstd::decoding::StreamingDecoder::new(source).map_err(|error| {
                Failure::usage(format!("this file is packed by zstd and broken: {error}. Fix: copy it again"))
            })?),
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
