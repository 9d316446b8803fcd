//! From the bytes of a text file to lines: encodings, and what is not text.

use crate::failure::{Failure, Outcome};
use crate::input::guard::{MAX_LINE_BYTES, Objection, Stop};
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::io::Read;

/// A table of another program is read whole; a larger one is cut first.
const MOST_BYTES: u64 = 2 << 30;

/// The text, and how it was written where that is worth a word.
pub struct Decoded {
    /// The text.
    pub text: String,
    /// `UTF-16`, `Windows-1252`; empty for UTF-8.
    pub encoding: &'static str,
}

/// Reads everything as text.
///
/// # Errors
/// A file that is not text, that cannot be read, or with a line that no log has.
pub fn decode(mut source: impl Read) -> Outcome<Decoded> {
    let mut bytes = Vec::new();
    source
        .by_ref()
        .take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Failure::usage(
            "a table of another program may have up to 2 GB, and this one is larger. Split it, and import the parts one by \
             one",
        ));
    }
    let decoded = text_of(bytes)?;
    for (index, line) in decoded.text.split('\n').enumerate() {
        if line.len() > MAX_LINE_BYTES {
            return Err(stop(Objection::LongLine, index as u64 + 1));
        }
    }
    Ok(decoded)
}

fn stop(objection: Objection, line: u64) -> Failure {
    Failure::usage(Stop { objection, line }.to_string()).at_line(line)
}

fn text_of(bytes: Vec<u8>) -> Outcome<Decoded> {
    if let Some((encoding, mark)) = Encoding::for_bom(&bytes) {
        let name = if encoding == UTF_16LE || encoding == UTF_16BE { "UTF-16" } else { "" };
        let (text, _) = encoding.decode_without_bom_handling(bytes.get(mark..).unwrap_or_default());
        return clean(text.into_owned(), name);
    }
    if let Some(encoding) = utf16_without_mark(&bytes) {
        let (text, _) = encoding.decode_without_bom_handling(&bytes);
        return clean(text.into_owned(), "UTF-16");
    }
    match String::from_utf8(bytes) {
        Ok(text) => clean(text, ""),
        Err(error) => {
            // µ and ° of an older program, or a line that a serial port garbled.
            let (text, _) = WINDOWS_1252.decode_without_bom_handling(error.as_bytes());
            clean(text.into_owned(), "Windows-1252")
        }
    }
}

fn clean(text: String, encoding: &'static str) -> Outcome<Decoded> {
    if let Some(at) = memchr::memchr(0, text.as_bytes()) {
        let line =
            memchr::memchr_iter(b'\n', text.as_bytes().get(..at).unwrap_or_default()).count() as u64 + 1;
        return Err(stop(Objection::Binary, line));
    }
    // Line ends of very old systems.
    let text = if !text.contains('\n') && text.contains('\r') { text.replace('\r', "\n") } else { text };
    Ok(Decoded { text, encoding })
}

/// UTF-16 without a mark: ASCII letters with a zero on the same side of nearly each.
fn utf16_without_mark(bytes: &[u8]) -> Option<&'static Encoding> {
    let head = bytes.get(..bytes.len().min(4096) & !1)?;
    let pairs = head.len() / 2;
    if pairs < 8 {
        return None;
    }
    let zeros = |side: usize| head.chunks_exact(2).filter(|pair| pair.get(side) == Some(&0)).count();
    let (first, second) = (zeros(0), zeros(1));
    match (first * 10 > pairs * 9, second * 10 > pairs * 9) {
        (true, false) if second == 0 => Some(UTF_16BE),
        (false, true) if first == 0 => Some(UTF_16LE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str, big: bool) -> Vec<u8> {
        text.encode_utf16()
            .flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() })
            .collect()
    }

    #[test]
    fn encodings() {
        let text = "X (µT);Y\n1;2\n";
        let marked = [vec![0xff, 0xfe], utf16(text, false)].concat();
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        for (bytes, name) in [
            (text.as_bytes().to_vec(), ""),
            (["\u{feff}", text].concat().into_bytes(), ""),
            (marked, "UTF-16"),
            (utf16(text, false), "UTF-16"),
            (utf16(text, true), "UTF-16"),
            (latin, "Windows-1252"),
        ] {
            let decoded = decode(bytes.as_slice()).expect("text");
            assert_eq!((decoded.text.as_str(), decoded.encoding), (text, name));
        }
        assert_eq!(decode(&b"a\nb\0c"[..]).map(|_| ()).expect_err("binary").line, Some(2));
    }
}
