//! A calibration onto a board, and off it.

use super::console::{Console, Reply};
use super::wire::Trouble;
use ironout::protocol::LOAD_LINE_BYTES;
use ironout::record::{MAX_RECORD_BYTES, Record};
use std::fmt::Write;

/// Bytes of the checksum that a record ends in.
const CRC_BYTES: usize = 4;

/// The lines that put a record on a board, in their order.
pub fn load_lines(bytes: &[u8]) -> Vec<String> {
    let crc = bytes.last_chunk::<CRC_BYTES>().copied().map_or(0, u32::from_le_bytes);
    let data = bytes.chunks(LOAD_LINE_BYTES).enumerate().map(|(line, chunk)| {
        let mut text = format!("cal load data {} ", line * LOAD_LINE_BYTES);
        for byte in chunk {
            // Into a string: it cannot fail.
            let _ = write!(text, "{byte:02x}");
        }
        text
    });
    let begin = format!("cal load begin {} {crc:08x}", bytes.len());
    std::iter::once(begin).chain(data).chain(["cal load end".to_string()]).collect()
}

/// Puts a record on the board, where it waits for `cal accept`. What was in use goes on; `progress` is told the lines that
/// are done, and how many there are.
///
/// # Errors
/// [`Trouble`]; nothing has changed on the board then.
pub fn load(
    console: &mut Console,
    bytes: &[u8],
    mut progress: impl FnMut(usize, usize),
) -> Result<Reply, Trouble> {
    let lines = load_lines(bytes);
    let mut last = Err(Trouble::Foreign(String::new()));
    for (done, line) in lines.iter().enumerate() {
        last = Ok(console.ok(line)?);
        progress(done + 1, lines.len());
    }
    last
}

/// What `cal dump` said.
#[derive(Debug, Clone)]
pub struct Dumped {
    /// The record.
    pub record: Record,
    /// How the errors of offset and matrix hang together, where the board knows it.
    pub covariance: Option<[[f64; 9]; 9]>,
    /// Whether it is the stored calibration, rather than one that waits to be accepted.
    pub stored: bool,
}

/// Brings the board's calibration here.
///
/// # Errors
/// [`Trouble`]; what came is checked as a board checks what it has stored.
pub fn dump(console: &mut Console) -> Result<Dumped, Trouble> {
    let reply = console.ok("cal dump")?;
    parse(&reply).ok_or_else(|| Trouble::Foreign(format!("{} (to cal dump)", reply.closing())))
}

fn parse(reply: &Reply) -> Option<Dumped> {
    let mut bytes = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for line in &reply.info {
        if let Some(text) = line.strip_prefix("record=") {
            let (offset, hex) = text.split_once(' ')?;
            if offset.parse() != Ok(bytes.len()) {
                return None;
            }
            bytes.extend(from_hex(hex)?);
        } else if let Some(text) = line.strip_prefix("covariance=") {
            rows.push(text.split(',').map(|word| word.parse().ok()).collect::<Option<_>>()?);
        }
    }
    if bytes.len() > MAX_RECORD_BYTES || reply.value("bytes")?.parse() != Ok(bytes.len()) {
        return None;
    }
    let covariance = match rows.is_empty() {
        true => None,
        false => Some(symmetric(&rows)?),
    };
    Some(Dumped {
        record: Record::decode(&bytes).ok()?,
        covariance,
        stored: reply.value("stored") == Some("1"),
    })
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let (pairs, rest) = text.as_bytes().as_chunks::<2>();
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let byte = |[high, low]: &[u8; 2]| u8::try_from(digit(*high)? << 4 | digit(*low)?).ok();
    rest.is_empty().then(|| pairs.iter().map(byte).collect()).flatten()
}

/// The whole matrix from the rows of its upper triangle.
fn symmetric(rows: &[Vec<f64>]) -> Option<[[f64; 9]; 9]> {
    let mut matrix = [[0.0; 9]; 9];
    if rows.len() != 9 {
        return None;
    }
    for (i, row) in rows.iter().enumerate() {
        if row.len() != 9 - i || row.iter().any(|value| !value.is_finite()) {
            return None;
        }
        for (k, value) in row.iter().enumerate() {
            matrix[i][i + k] = *value;
            matrix[i + k][i] = *value;
        }
    }
    Some(matrix)
}

#[cfg(test)]
mod tests {
    use super::{from_hex, load_lines};
    use ironout::protocol::{Command, MAX_LINE, parse};

    #[test]
    fn every_line_is_a_command_of_the_board() {
        let bytes: Vec<u8> = (0..512_usize).map(|i| (i * 7) as u8).collect();
        let lines = load_lines(&bytes);
        assert_eq!(lines.len(), 2 + 512_usize.div_ceil(28));
        for line in &lines {
            assert!(line.len() <= MAX_LINE, "{line}");
            assert!(matches!(parse(line), Ok(Command::CalLoad(_))), "{line}");
        }
    }

    #[test]
    fn hexadecimal_digits_come_in_pairs() {
        assert_eq!(from_hex("00ff7A"), Some(vec![0, 0xff, 0x7a]));
        assert_eq!(from_hex("0"), None);
        assert_eq!(from_hex("0g"), None);
    }
}
