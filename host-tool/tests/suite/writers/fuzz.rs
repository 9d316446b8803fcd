//! Broken files: seeded changes of good ones. A reader answers or refuses; it never panics, hangs, or takes memory that the file
//! has no right to.

use crate::writers::truth::read_with;
use ironout_cli::input::ReadOptions;
use rand::{RngExt, SeedableRng, rngs::ChaCha12Rng};

/// Changes one file; the same for the same seed.
pub fn change(seed: u64, good: &[u8]) -> Vec<u8> {
    let mut rng = ChaCha12Rng::seed_from_u64(seed);
    let mut below = |n: usize| rng.random_range(0..n.max(1));
    let mut bytes = good.to_vec();
    for _ in 0..=below(5) {
        let at = below(bytes.len() + 1);
        // Definitions stand at the beginning: half of the changes go there.
        let at = if below(2) == 0 { at.min(below(2048)) } else { at };
        let end = (at + below(24)).min(bytes.len());
        match below(8) {
            0 | 1 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            2 if at < bytes.len() => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][below(5)],
            3 => drop(bytes.drain(at..end)),
            4 => {
                let copy = bytes[at..end].to_vec();
                let to = below(bytes.len() + 1);
                bytes.splice(to..to, copy);
            }
            5 => bytes.truncate(at),
            6 => {
                let numbers = [b"9".as_slice(), b"99999999999", b"-1", b"nan", b",", b"[", b"\n", b"\0"];
                let token = numbers[below(numbers.len())];
                let to = at.min(bytes.len());
                bytes.splice(to..to, token.iter().copied());
            }
            _ => bytes[at..end].fill(0xff),
        }
    }
    bytes
}

/// Reads `cases` changes of the good files of one format in turn; `IRONOUT_FUZZ_CASES` asks for more. Gives how many were read all
/// the same.
pub fn fuzz(name: &str, good: &[&[u8]], cases: u64) -> u64 {
    let cases = std::env::var("IRONOUT_FUZZ_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(cases);
    let (mut accepted, began) = (0, std::time::Instant::now());
    for (case, good) in (0..cases).zip(good.iter().cycle()) {
        let bytes = change(case, good);
        let options = ReadOptions { ut_per_count: Some([0.1; 3]), ..ReadOptions::default() };
        let result = std::panic::catch_unwind(|| match read_with(&bytes, &options) {
            Ok(log) => {
                assert!(log.rows > 0 && log.field_ut.iter().flatten().all(|value| value.is_finite()));
                // Where its mark is spoilt, a file of text may still be a table, and such a one need not have a time.
                let time = log.time_s.as_ref();
                assert!(time.is_none_or(|time| time.is_sorted() && time.len() == log.rows));
                true
            }
            Err(failure) => {
                assert!(!failure.message.is_empty());
                false
            }
        });
        match result {
            Ok(read) => accepted += u64::from(read),
            Err(_) => panic!("{name}: case {case}"),
        }
    }
    println!("{name}: {cases} changed files, {accepted} read, {:.1} s", began.elapsed().as_secs_f64());
    accepted
}
