//! A number on its way to text.

use core::fmt::{self, Write};

use super::digits::{Digits, Parts, Wanted};

/// A number that prints itself as `f32` and `f64` do, without their tables: `{:?}` are the fewest digits that read back to the same
/// bits, `{:.3}` three decimals, `{:.1e}` two digits and a power of ten. Signs, widths and fills are not looked at.
///
/// ```
/// use ironout::number::Num;
/// assert_eq!(format!("{:?} {:?} {:.2} {:.1e}", Num(0.1), Num(3.0_f32), Num(-2.005), Num(4.5e-4)), "0.1 3.0 -2.00 4.5e-4");
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct Num {
    is_negative: bool,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Zero,
    Infinite,
    NoNumber,
    Parts(Parts),
}

/// Of the bits of a number in binary: `fraction` of them, above these an exponent of `width` bits, and the sign.
const fn of_bits(bits: u64, fraction: u32, width: u32) -> Num {
    let is_negative = bits >> (fraction + width) != 0;
    let low = bits & ((1 << fraction) - 1);
    let exponent = (bits >> fraction) & ((1 << width) - 1);
    let bias = (1 << (width - 1)) - 1 + fraction as i32;
    let kind = match (exponent, low) {
        (0, 0) => Kind::Zero,
        (0, mantissa) => Kind::Parts(Parts { mantissa, exponent: 1 - bias, is_power: false }),
        (exponent, low) if exponent == (1 << width) - 1 => {
            if low == 0 {
                Kind::Infinite
            } else {
                Kind::NoNumber
            }
        }
        (exponent, low) => Kind::Parts(Parts {
            mantissa: low | 1 << fraction,
            exponent: exponent as i32 - bias,
            is_power: low == 0 && exponent > 1,
        }),
    };
    Num { is_negative, kind }
}

impl From<f64> for Num {
    fn from(value: f64) -> Self {
        of_bits(value.to_bits(), 52, 11)
    }
}

impl From<f32> for Num {
    fn from(value: f32) -> Self {
        of_bits(u64::from(value.to_bits()), 23, 8)
    }
}

/// A [`struct@Num`].
#[allow(non_snake_case, reason = "it reads as the type it makes")]
pub fn Num(value: impl Into<Num>) -> Num {
    value.into()
}

impl Num {
    /// Its digits; `None` and its word written where it has none to show.
    fn digits(&self, f: &mut fmt::Formatter<'_>, wanted: Wanted) -> Result<Option<Digits>, fmt::Error> {
        let (sign, none) = match self.kind {
            Kind::NoNumber => ("", Some("NaN")),
            Kind::Infinite => ("-", Some("inf")),
            Kind::Zero | Kind::Parts(_) => ("-", None),
        };
        if self.is_negative {
            f.write_str(sign)?;
        }
        Ok(match (none, self.kind) {
            (Some(word), _) => {
                f.write_str(word)?;
                None
            }
            (None, Kind::Parts(parts)) => Some(Digits::of(parts, wanted)),
            (None, _) => Some(Digits { digits: heapless::Vec::new(), point: 1 }),
        })
    }
}

fn put(f: &mut fmt::Formatter<'_>, digit: u8) -> fmt::Result {
    f.write_char(char::from(b'0' + digit))
}

/// Without a power of ten, with so many decimals.
fn plain(f: &mut fmt::Formatter<'_>, digits: &Digits, decimals: i32) -> fmt::Result {
    for place in (-digits.point).min(-1)..decimals {
        if place == 0 {
            f.write_char('.')?;
        }
        put(f, digits.at(place))?;
    }
    Ok(())
}

/// With a power of ten, with so many decimals.
fn powered(f: &mut fmt::Formatter<'_>, digits: &Digits, decimals: i32) -> fmt::Result {
    for place in 0..=decimals {
        if place == 1 {
            f.write_char('.')?;
        }
        put(f, digits.at(place - digits.point))?;
    }
    write!(f, "e{}", digits.point - 1)
}

impl fmt::Display for Num {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = f.precision().map(|decimals| decimals as i32);
        let wanted = decimals.map_or(Wanted::Shortest, Wanted::Decimals);
        let Some(digits) = self.digits(f, wanted)? else { return Ok(()) };
        let after = digits.digits.len() as i32 - digits.point;
        plain(f, &digits, decimals.unwrap_or(after.max(0)))
    }
}

impl fmt::Debug for Num {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if f.precision().is_some() {
            return fmt::Display::fmt(self, f);
        }
        let Some(digits) = self.digits(f, Wanted::Shortest)? else { return Ok(()) };
        let count = digits.digits.len() as i32;
        // From 1e-4 to below 1e16 without a power of ten.
        if self.kind == Kind::Zero || (-3..=16).contains(&digits.point) {
            plain(f, &digits, (count - digits.point).max(1))
        } else {
            powered(f, &digits, count - 1)
        }
    }
}

impl fmt::LowerExp for Num {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = f.precision().map(|decimals| decimals as i32);
        let wanted = decimals.map_or(Wanted::Shortest, |decimals| Wanted::Digits(decimals + 1));
        let Some(digits) = self.digits(f, wanted)? else { return Ok(()) };
        powered(f, &digits, decimals.unwrap_or((digits.digits.len() as i32 - 1).max(0)))
    }
}
