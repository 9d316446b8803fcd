//! `cal load …`: a calibration that comes in over the console, line by line.

/// The most bytes of one `cal load data` line: with its offset it is shorter than a line may be.
pub const LOAD_LINE_BYTES: usize = 28;

/// How the three lines are written.
pub(super) const USAGE: &str =
    "cal load begin BYTES CRC, then cal load data OFFSET HEX (up to 28 bytes per line), then cal load end";

/// The bytes of one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadBytes {
    bytes: [u8; LOAD_LINE_BYTES],
    length: u8,
}

impl LoadBytes {
    /// From two hexadecimal digits a byte; `None` for anything else, for none and for more than [`LOAD_LINE_BYTES`].
    pub fn from_hex(text: &str) -> Option<Self> {
        let (pairs, rest) = text.as_bytes().as_chunks::<2>();
        if pairs.is_empty() || pairs.len() > LOAD_LINE_BYTES || !rest.is_empty() {
            return None;
        }
        let mut bytes = [0; LOAD_LINE_BYTES];
        for (byte, [high, low]) in bytes.iter_mut().zip(pairs) {
            *byte = digit(*high)? << 4 | digit(*low)?;
        }
        Some(Self { bytes, length: pairs.len() as u8 })
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }
}

fn digit(character: u8) -> Option<u8> {
    char::from(character).to_digit(16).and_then(|digit| u8::try_from(digit).ok())
}

/// One line of the transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// `cal load begin BYTES CRC`: a record of so many bytes follows, and it ends in this CRC-32 of all before.
    ///
    /// It is not the checksum of the whole record: over a message that ends in its own CRC-32 that is the same for every
    /// message, and would tell nothing.
    Begin {
        /// Bytes of the record.
        bytes: u16,
        /// Its last four bytes, as a number.
        crc: u32,
    },
    /// `cal load data OFFSET HEX`
    Data {
        /// Where the bytes belong.
        offset: u16,
        /// The bytes.
        bytes: LoadBytes,
    },
    /// `cal load end`: that was all of it.
    End,
}

/// Reads what follows `cal load`.
pub(super) fn parse<'a>(verb: Option<&str>, mut words: impl Iterator<Item = &'a str>) -> Option<Load> {
    let (first, second, more) = (words.next(), words.next(), words.next());
    let load = match (verb?, first, second) {
        ("begin", Some(bytes), Some(crc)) => Load::Begin { bytes: number(bytes)?, crc: checksum(crc)? },
        ("data", Some(offset), Some(hex)) => {
            Load::Data { offset: number(offset)?, bytes: LoadBytes::from_hex(hex)? }
        }
        ("end", None, None) => Load::End,
        _ => return None,
    };
    more.is_none().then_some(load)
}

/// Digits only: a sign is no part of it.
fn number(word: &str) -> Option<u16> {
    word.bytes().all(|byte| byte.is_ascii_digit()).then(|| word.parse().ok()).flatten()
}

/// Eight hexadecimal digits.
fn checksum(word: &str) -> Option<u32> {
    let whole = word.len() == 8 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    whole.then(|| u32::from_str_radix(word, 16).ok()).flatten()
}
