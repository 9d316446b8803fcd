//! The decimal digits of a number: as few as tell it from its neighbours, or as many as are asked for.
//!
//! Steele and White (1990), as Burger and Dybvig (1996) give it: the number and half the distances to its neighbours are fractions
//! with a common denominator, and one digit after the other is taken from them.

use super::big::Big;
use core::cmp::Ordering;
use heapless::Vec;

/// The most digits that are worked out; more are zeros. Seventeen tell any two numbers apart.
const MOST: usize = 40;

/// A positive number `mantissa · 2^exponent`.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Parts {
    pub(super) mantissa: u64,
    pub(super) exponent: i32,
    /// The next smaller number is half as far away as the next larger one.
    pub(super) is_power: bool,
}

/// How many digits are wanted.
#[derive(Clone, Copy)]
pub(super) enum Wanted {
    /// As few as tell it from its neighbours.
    Shortest,
    /// So many in all.
    Digits(i32),
    /// So many after the point.
    Decimals(i32),
}

/// `0.digits · 10^point`, rounded to the nearest, at the middle to the even digit; none where that is zero.
pub(super) struct Digits {
    pub(super) digits: Vec<u8, MOST>,
    pub(super) point: i32,
}

impl Digits {
    pub(super) fn of(Parts { mantissa, exponent, is_power }: Parts, wanted: Wanted) -> Self {
        // Twice over, or four times at a power of two, so that the half distances are whole.
        let doubled = 1 + u32::from(is_power);
        let (mut number, mut denominator) = (Big::of(mantissa), Big::of(1));
        let (mut above, mut below) = (Big::of(1 + u64::from(is_power)), Big::of(1));
        number.shift(doubled);
        denominator.shift(doubled);
        let up = exponent.max(0).unsigned_abs();
        for part in [&mut number, &mut above, &mut below] {
            part.shift(up);
        }
        denominator.shift(exponent.min(0).unsigned_abs());

        // At or below the place of the first digit: a logarithm of two is a little more than 1233 in 4096.
        let mut point = ((exponent + 63 - mantissa.leading_zeros() as i32) * 1233).div_euclid(4096) - 1;
        denominator.times_ten_to(point.max(0).unsigned_abs());
        for part in [&mut number, &mut above, &mut below] {
            part.times_ten_to(point.min(0).unsigned_abs());
        }
        let is_shortest = matches!(wanted, Wanted::Shortest);
        let is_even = mantissa.is_multiple_of(2);
        // Whether the next larger number's half way reaches a denominator, and counts.
        let reaches = |number: &Big, denominator: &Big| {
            let mut reach = number.clone();
            if is_shortest {
                reach.add(&above);
            }
            match reach.compare(denominator) {
                Ordering::Greater => true,
                Ordering::Equal => is_even || !is_shortest,
                Ordering::Less => false,
            }
        };
        while reaches(&number, &denominator) {
            denominator.times(10, 0);
            point += 1;
        }

        let count = match wanted {
            Wanted::Shortest => MOST as i32,
            Wanted::Digits(count) => count,
            Wanted::Decimals(decimals) => point + decimals,
        };
        let mut digits = Vec::new();
        let mut rounds_up = false;
        for _ in 0..count.min(MOST as i32) {
            for part in [&mut number, &mut above, &mut below] {
                part.times(10, 0);
            }
            let mut digit = 0;
            while number.compare(&denominator).is_ge() {
                number.subtract(&denominator);
                digit += 1;
            }
            let _ = digits.push(digit);
            if is_shortest {
                let is_low = match number.compare(&below) {
                    Ordering::Less => true,
                    Ordering::Equal => is_even,
                    Ordering::Greater => false,
                };
                let mut reach = number.clone();
                reach.add(&above);
                let is_high = match reach.compare(&denominator) {
                    Ordering::Greater => true,
                    Ordering::Equal => is_even,
                    Ordering::Less => false,
                };
                if is_low || is_high {
                    number.times(2, 0);
                    rounds_up = is_high && (!is_low || number.compare(&denominator).is_ge());
                    break;
                }
            }
        }
        if !is_shortest && count >= 0 {
            number.times(2, 0);
            rounds_up = match number.compare(&denominator) {
                Ordering::Greater => true,
                Ordering::Equal => digits.last().is_some_and(|digit| digit % 2 == 1),
                Ordering::Less => false,
            };
        }
        let mut result = Self { digits, point };
        if rounds_up {
            result.round_up();
        }
        result
    }

    /// One more in the last place.
    fn round_up(&mut self) {
        while let Some(digit) = self.digits.last_mut() {
            if *digit < 9 {
                *digit += 1;
                return;
            }
            // The place is a zero now, which need not be written.
            self.digits.pop();
        }
        let _ = self.digits.push(1);
        self.point += 1;
    }

    /// The digit at a place, the first of which stands right of the point; zero where none was worked out.
    pub(super) fn at(&self, place: i32) -> u8 {
        let index = usize::try_from(place.saturating_add(self.point)).ok();
        index.and_then(|index| self.digits.get(index)).copied().unwrap_or(0)
    }
}
