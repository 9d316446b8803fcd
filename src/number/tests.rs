//! Every character and every bit as the standard library has them.

extern crate std;
use super::{Num, read};
use std::format;
use std::string::{String, ToString};

/// splitmix64.
fn draws(seed: u64) -> impl Iterator<Item = u64> {
    let mut state = seed;
    core::iter::from_fn(move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Some(z ^ (z >> 31))
    })
}

const CORNERS: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.1,
    0.5,
    1.5,
    2.5,
    0.05,
    0.15,
    9.995,
    999_999.5,
    1e-5,
    9.999e-5,
    1e-4,
    1e15,
    9_999_999_999_999_998.0,
    1e16,
    1e17,
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    f64::INFINITY,
    123_456.789,
];

fn same(value: f64) {
    assert_eq!(format!("{:?}", Num(value)), format!("{value:?}"));
    if value.abs() < 1e30 {
        assert_eq!(Num(value).to_string(), value.to_string());
        for decimals in [0, 1, 2, 3, 4, 6] {
            assert_eq!(format!("{:.decimals$}", Num(value)), format!("{value:.decimals$}"), "{value:?}");
        }
    }
    assert_eq!(format!("{:.1e}", Num(value)), format!("{value:.1e}"), "{value:?}");
    assert_eq!(format!("{:e}", Num(value)), format!("{value:e}"), "{value:?}");
}

#[test]
fn numbers_print_as_they_always_did() {
    for value in CORNERS {
        same(value);
        same(-value);
    }
    assert_eq!(format!("{:?} {:.3}", Num(f64::NAN), Num(-f64::NAN)), "NaN NaN");
    for (index, bits) in draws(1).take(6000).enumerate() {
        same(f64::from_bits(bits));
        // Magnitudes that are printed.
        let value = (bits as i64) as f64 / 10_f64.powi((index % 24) as i32);
        same(value);
        let single = f32::from_bits(bits as u32);
        assert_eq!(format!("{:?}", Num(single)), format!("{single:?}"));
        let single = value as f32;
        assert_eq!(format!("{:?} {:.3}", Num(single), Num(single)), format!("{single:?} {single:.3}"));
    }
}

fn reads(text: &str) {
    let (ours, std) = (read(text), text.parse::<f64>().ok());
    assert_eq!(ours.map(f64::to_bits), std.map(f64::to_bits), "{text:?}: {ours:?} {std:?}");
}

#[test]
fn texts_are_read_to_the_same_bits() {
    for text in [
        "0",
        "-0",
        "1",
        "+1",
        "-1.5",
        ".5",
        "5.",
        "1e0",
        "1E3",
        "1e+3",
        "1e-3",
        "1.e1",
        ".1e1",
        "00012.500",
        "1e400",
        "1e-400",
        "-1e999999999999",
        "1e-999999999999",
        "0e999",
        "4.9e-324",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "2.2250738585072011e-308",
        "1.7976931348623157e308",
        "1.7976931348623159e308",
        "9007199254740993",
        "9007199254740992.5",
        "9007199254740993.0000000000000000000000000000000000000001",
        "0.000000000000000000000000000000000000000000000000000000000000000000000000001",
        "inf",
        "-Infinity",
        "NaN",
    ] {
        if text.eq_ignore_ascii_case("nan") {
            assert!(read(text).unwrap().is_nan());
        } else {
            reads(text);
        }
    }
    for bits in draws(2).take(6000) {
        let value = f64::from_bits(bits);
        if value.is_finite() {
            reads(&format!("{value:?}"));
            reads(&format!("{value:.20e}"));
            reads(&format!("{:.3}", value % 1e6));
        }
        reads(&format!("{}.{}e{}", bits % 1000, bits >> 20, (bits % 700) as i32 - 350));
    }
}

#[test]
fn what_is_no_number_is_none() {
    for text in [
        "", "-", "+", ".", "e", "e5", ".e5", "1e", "1e+", "1e5.", "1.2.3", "--1", "1 ", " 1", "0x10",
        "1_000", "nano", "1f", "infinit", "\u{661}",
    ] {
        assert_eq!((read(text), text.parse::<f64>().ok()), (None, None), "{text:?}");
    }
}

#[test]
fn random_texts_are_read_or_refused_alike() {
    const LETTERS: &[u8] = b"0123456789.eE+-0159in";
    for bits in draws(3).take(20_000) {
        let text: String = (0..bits % 9)
            .map(|at| char::from(LETTERS[(bits >> (7 * at)) as usize % LETTERS.len()]))
            .collect();
        reads(&text);
    }
}
