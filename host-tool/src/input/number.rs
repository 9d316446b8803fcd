//! Decimal numbers, fast where the answer is exact and left to the standard library otherwise.

/// Powers of ten that are exact in f64.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Parses one cell, surrounding blanks removed. `None` is text; NaN and infinities are numbers here and are
/// judged by the caller, who knows which column they stand in.
///
/// Plain decimals of at most 15 digits take a short path: the digits as an integer are below 2⁵³ and one
/// division by an exact power of ten is correctly rounded, so the result is that of the standard parser.
pub fn parse(cell: &[u8]) -> Option<f64> {
    let cell = cell.trim_ascii();
    plain_decimal(cell).or_else(|| std::str::from_utf8(cell).ok()?.parse().ok())
}

fn plain_decimal(cell: &[u8]) -> Option<f64> {
    let (negative, digits) = match cell {
        [b'-', rest @ ..] => (true, rest),
        rest => (false, rest),
    };
    if digits.is_empty() || digits.len() > 16 {
        return None;
    }
    let (mut value, mut count, mut decimals) = (0_u64, 0_usize, None);
    for &byte in digits {
        match byte {
            b'0'..=b'9' => {
                value = value * 10 + u64::from(byte - b'0');
                count += 1;
                decimals = decimals.map(|n: usize| n + 1);
            }
            b'.' if decimals.is_none() => decimals = Some(0),
            _ => return None,
        }
    }
    if count == 0 || count > 15 {
        return None;
    }
    let magnitude = value as f64 / EXACT_POWERS[decimals.unwrap_or(0)];
    Some(if negative { -magnitude } else { magnitude })
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn the_short_path_gives_the_bits_of_the_standard_parser() {
        for text in [
            "0",
            "-0",
            "24.128",
            "-33.761",
            "0.0126",
            "123456789012345",
            "0.1",
            ".5",
            "5.",
            "-9.9190",
            "1e-3",
        ] {
            assert_eq!(
                parse(text.as_bytes()).map(f64::to_bits),
                text.parse().ok().map(f64::to_bits),
                "{text}"
            );
        }
    }

    #[test]
    fn text_is_none_and_blanks_are_trimmed() {
        for text in ["", " ", "-", ".", "1.2.3", "0x10", "1,5", "12a", "--1", "1 2"] {
            assert_eq!(parse(text.as_bytes()), None, "{text:?}");
        }
        assert_eq!(parse(b" 1.5\t"), Some(1.5));
        assert!(parse(b"NaN").is_some_and(f64::is_nan));
        assert_eq!(parse(b"-inf"), Some(f64::NEG_INFINITY));
    }
}
