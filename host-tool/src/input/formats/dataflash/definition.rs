//! What a `FMT` message defines: the name, letters and labels of one kind of message.

use crate::input::formats::feed::bytes_at;

/// The header of a binary message: two marks and its type.
pub const HEADER_BYTES: usize = 3;
/// The type of `FMT` itself, and its length with header.
pub const FMT: (u8, usize) = (128, 89);

/// One kind of message.
#[derive(Debug, Clone)]
pub struct Definition {
    /// Its number, by which other messages name it.
    pub kind: u8,
    /// Its name: `MAG`.
    pub name: String,
    /// Its labels: `TimeUS`, `MagX`, …
    pub labels: Vec<String>,
    /// A letter a field, and where it lies behind the header.
    fields: Vec<(u8, usize)>,
    /// Length with header.
    pub length: usize,
}

impl Definition {
    /// From number, name, letters, labels and length with header; `None` where a letter is unknown, or the fields do not fit.
    pub fn new(kind: u8, name: &str, letters: &str, labels: &str, length: usize) -> Option<Self> {
        let mut at = 0;
        let mut fields = Vec::new();
        for letter in letters.trim().bytes() {
            fields.push((letter, at));
            at += size(letter)?;
        }
        let labels: Vec<String> = labels.split(',').map(|label| label.trim().to_string()).collect();
        (length >= HEADER_BYTES + at).then(|| Definition {
            kind,
            name: name.trim().to_string(),
            labels,
            fields,
            length,
        })
    }

    /// From the body of a binary `FMT`: its type too. The definition is `None` where it makes no sense.
    pub fn from_fmt(body: &[u8]) -> Option<(u8, Option<Self>)> {
        let (kind, length) = (*body.first()?, usize::from(*body.get(1)?));
        let text = |from: usize, to: usize| Some(string(body.get(from..to)?));
        Some((kind, Self::new(kind, &text(2, 6)?, &text(6, 22)?, &text(22, 86)?, length)))
    }

    /// Which field has a label.
    pub fn label(&self, label: &str) -> Option<usize> {
        self.labels.iter().position(|known| known == label)
    }

    /// The letter of a field.
    pub fn letter(&self, field: usize) -> Option<u8> {
        self.fields.get(field).map(|(letter, _)| *letter)
    }

    /// The number in a field of a binary body; NaN for text and where there is none.
    pub fn number(&self, body: &[u8], field: usize) -> f64 {
        self.fields.get(field).and_then(|(letter, at)| number(*letter, body, *at)).unwrap_or(f64::NAN)
    }

    /// The text in a field of a binary body.
    pub fn text(&self, body: &[u8], field: usize) -> String {
        let bytes = self.fields.get(field).and_then(|(letter, at)| body.get(*at..at + size(*letter)?));
        string(bytes.unwrap_or_default())
    }
}

/// Text up to its first zero byte.
fn string(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).trim().to_string()
}

fn size(letter: u8) -> Option<usize> {
    Some(match letter {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'e' | b'E' | b'f' | b'L' | b'n' => 4,
        b'q' | b'Q' | b'd' => 8,
        b'N' => 16,
        b'a' | b'Z' => 64,
        _ => return None,
    })
}

/// The letters of AP_Logger; `c`, `C`, `e`, `E` are hundredths, `L` is degrees × 10⁷.
fn number(letter: u8, body: &[u8], at: usize) -> Option<f64> {
    Some(match letter {
        b'b' => f64::from(i8::from_le_bytes(bytes_at(body, at)?)),
        b'B' | b'M' => f64::from(u8::from_le_bytes(bytes_at(body, at)?)),
        b'h' => f64::from(i16::from_le_bytes(bytes_at(body, at)?)),
        b'H' => f64::from(u16::from_le_bytes(bytes_at(body, at)?)),
        b'c' => f64::from(i16::from_le_bytes(bytes_at(body, at)?)) / 100.0,
        b'C' => f64::from(u16::from_le_bytes(bytes_at(body, at)?)) / 100.0,
        b'g' => half(u16::from_le_bytes(bytes_at(body, at)?)),
        b'i' => f64::from(i32::from_le_bytes(bytes_at(body, at)?)),
        b'I' => f64::from(u32::from_le_bytes(bytes_at(body, at)?)),
        b'e' => f64::from(i32::from_le_bytes(bytes_at(body, at)?)) / 100.0,
        b'E' => f64::from(u32::from_le_bytes(bytes_at(body, at)?)) / 100.0,
        b'L' => f64::from(i32::from_le_bytes(bytes_at(body, at)?)) / 1e7,
        b'f' => f64::from(f32::from_le_bytes(bytes_at(body, at)?)),
        b'd' => f64::from_le_bytes(bytes_at(body, at)?),
        b'q' => i64::from_le_bytes(bytes_at(body, at)?) as f64,
        b'Q' => u64::from_le_bytes(bytes_at(body, at)?) as f64,
        _ => return None,
    })
}

/// A number of 16 bits, IEEE 754 binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from((bits >> 10) & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2_f64.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_numbers_of_their_size_and_scale() {
        let definition = Definition::new(1, "X", "QBhcCLfeg", "TimeUS,I,a,b,c,d,e,f,g", 64).expect("sound");
        let mut body = Vec::new();
        body.extend(1_500_000_u64.to_le_bytes());
        body.push(3);
        body.extend((-7_i16).to_le_bytes());
        body.extend((-250_i16).to_le_bytes());
        body.extend(40_000_u16.to_le_bytes());
        body.extend((-353_632_620_i32).to_le_bytes());
        body.extend(2.5_f32.to_le_bytes());
        body.extend(123_456_i32.to_le_bytes());
        body.extend(0xc500_u16.to_le_bytes());
        let found: Vec<f64> = (0..9).map(|field| definition.number(&body, field)).collect();
        assert_eq!(found, [1.5e6, 3.0, -7.0, -2.5, 400.0, -35.363_262, 2.5, 1234.56, -5.0]);
        assert!(definition.number(&body[..20], 8).is_nan() && definition.number(&body, 9).is_nan());
        assert!(Definition::new(1, "X", "Q?", "a,b", 64).is_none());
        assert!(Definition::new(1, "X", "Q", "a", 5).is_none());
    }
}
