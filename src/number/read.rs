//! A number from its text.

use super::big::Big;
use core::cmp::Ordering;

/// The most digits that are looked at; a line of the console has no more. What follows counts as one more that is not zero.
const MOST_DIGITS: u32 = 100;
/// A power of ten beyond which there is only zero, or infinity, whatever the digits.
const MOST_EXPONENT: i32 = 500;

/// The number in double precision that is nearest to a text such as `-12.5`, `.5`, `3.` or `6.02e23`: `str::parse` without its tables.
/// `None` for everything else; `nan`, `inf` and `infinity` in any case are read as there.
///
/// ```
/// assert_eq!(ironout::number::read("-1.25e-3"), Some(-0.00125));
/// assert_eq!(ironout::number::read("1.2.3"), None);
/// ```
pub fn read(text: &str) -> Option<f64> {
    let (is_negative, text) = match text.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let magnitude = if text.eq_ignore_ascii_case(b"nan") {
        f64::NAN
    } else if text.eq_ignore_ascii_case(b"inf") || text.eq_ignore_ascii_case(b"infinity") {
        f64::INFINITY
    } else {
        positive(text)?
    };
    Some(if is_negative { -magnitude } else { magnitude })
}

fn positive(text: &[u8]) -> Option<f64> {
    let mut digits = Big::of(0);
    let (mut count, mut exponent, mut seen) = (0, 0_i32, false);
    let (mut is_after_point, mut rest) = (false, text);
    while let [byte, after @ ..] = rest {
        match byte {
            b'0'..=b'9' => {
                seen = true;
                let digit = byte - b'0';
                if count < MOST_DIGITS {
                    // Zeros in front are no digits.
                    count += u32::from(count > 0 || digit > 0);
                    digits.times(10, u32::from(digit));
                    exponent -= i32::from(is_after_point);
                } else {
                    exponent += i32::from(!is_after_point);
                }
            }
            b'.' if !is_after_point => is_after_point = true,
            _ => break,
        }
        rest = after;
    }
    if !seen {
        return None;
    }
    if let [b'e' | b'E', power @ ..] = rest {
        exponent = exponent.saturating_add(whole(power)?);
    } else if !rest.is_empty() {
        return None;
    }
    Some(nearest(digits, exponent.clamp(-MOST_EXPONENT - 100, MOST_EXPONENT)))
}

/// A whole number with a sign, held within a million.
fn whole(text: &[u8]) -> Option<i32> {
    let (sign, digits) = match text {
        [b'-', rest @ ..] => (-1, rest),
        [b'+', rest @ ..] => (1, rest),
        rest => (1, rest),
    };
    let mut value = 0_i32;
    for byte in digits {
        let digit = byte.checked_sub(b'0').filter(|digit| *digit <= 9)?;
        value = (10 * value + i32::from(digit)).min(1_000_000);
    }
    (!digits.is_empty()).then_some(sign * value)
}

/// The number nearest to `digits · 10^exponent`, at the middle the even one.
fn nearest(digits: Big, exponent: i32) -> f64 {
    let bits = digits.bits() as i32;
    // Beyond these there is nothing, and the long numbers stay short.
    let magnitude = bits + exponent * 3322 / 1000;
    if bits == 0 || magnitude < -1100 {
        return 0.0;
    }
    if magnitude > 1040 {
        return f64::INFINITY;
    }
    let (mut number, mut denominator) = (digits, Big::of(1));
    number.times_ten_to(exponent.max(0).unsigned_abs());
    denominator.times_ten_to(exponent.min(0).unsigned_abs());
    // The quotient lies between one and four times two to the power of `power`.
    let mut power = number.bits() as i32 - denominator.bits() as i32 - 1;
    number.shift((-power).max(0).unsigned_abs());
    denominator.shift(power.max(0).unsigned_abs());
    let mut twice = denominator.clone();
    twice.times(2, 0);
    if number.compare(&twice).is_ge() {
        denominator = twice;
        power += 1;
    }
    // 53 bits, fewer below the least normal number, whose last bit is two to the power of −1074.
    let kept = (power + 1075).min(53);
    if kept < 0 {
        return 0.0;
    }
    let mut mantissa = 0_u64;
    for _ in 0..kept {
        mantissa *= 2;
        if number.compare(&denominator).is_ge() {
            number.subtract(&denominator);
            mantissa += 1;
        }
        number.times(2, 0);
    }
    // What is left is below two denominators: the half of the last bit is one.
    let rounds_up = match number.compare(&denominator) {
        Ordering::Greater => true,
        Ordering::Equal => mantissa % 2 == 1,
        Ordering::Less => false,
    };
    // A carry goes on into the exponent by itself, up to infinity.
    let above_least = (power + 1074 - 52).max(0) as u64;
    let bits = (above_least << 52) + mantissa + u64::from(rounds_up);
    // A subnormal number has no leading bit to add.
    f64::from_bits(if power < -1022 {
        mantissa + u64::from(rounds_up)
    } else {
        bits.min(f64::INFINITY.to_bits())
    })
}
