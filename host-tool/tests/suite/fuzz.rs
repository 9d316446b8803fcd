//! Every parser on broken input: seeded mutations of good input, on stable Rust. A parser answers or refuses; it never
//! panics, and what it accepts is sound.
//!
//! `IRONOUT_FUZZ_CASES=1000000 cargo test -p ironout-cli --test suite -- fuzz::` for a long run.

use ironout::calibration::Calibration;
use ironout::extended::Effects;
use ironout::fit::{Method, Order};
use ironout::protocol::{Line, LineSplitter, parse};
use ironout::record::Record;
use ironout_cli::cal_file::CalFile;
use ironout_cli::input::{ReadOptions, read_stream};
use rand::{RngExt, SeedableRng, rngs::ChaCha12Rng};

/// Mutates seeds of a corpus; the same for the same seed.
struct Mutator {
    rng: ChaCha12Rng,
}

impl Mutator {
    fn new(seed: u64) -> Self {
        Self { rng: ChaCha12Rng::seed_from_u64(seed) }
    }

    fn below(&mut self, n: usize) -> usize {
        self.rng.random_range(0..n.max(1))
    }

    /// Bytes that parsers stumble over.
    fn token(&mut self) -> &'static [u8] {
        const TOKENS: [&[u8]; 26] = [
            b"",
            b"0",
            b"-",
            b"nan",
            b"NaN",
            b"inf",
            b"-inf",
            b"1e999",
            b"-1e-999",
            b"\n",
            b"\r\n",
            b"\r",
            b",",
            b",,",
            b"\"",
            b"#",
            b" ",
            b"\0",
            b"\xff",
            b"\xef\xbb\xbf",
            b"99999999999999999999",
            b"{",
            b"}",
            b"null",
            b"[",
            b":",
        ];
        TOKENS[self.below(TOKENS.len())]
    }

    fn mutate(&mut self, corpus: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = corpus[self.below(corpus.len())].clone();
        for _ in 0..=self.below(6) {
            let at = self.below(bytes.len() + 1);
            let end = (at + self.below(24)).min(bytes.len());
            match self.below(8) {
                0 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                1 if at < bytes.len() => bytes[at] = self.rng.random(),
                2 => drop(bytes.drain(at..end)),
                3 => {
                    let copy = bytes[at..end].to_vec();
                    let to = self.below(bytes.len() + 1);
                    bytes.splice(to..to, copy);
                }
                4 => bytes.truncate(at),
                5 => {
                    // The tail of another seed.
                    let other = &corpus[self.below(corpus.len())];
                    let from = self.below(other.len() + 1);
                    bytes.truncate(at);
                    bytes.extend_from_slice(&other[from..]);
                }
                _ => {
                    let token = self.token();
                    bytes.splice(at..at, token.iter().copied());
                }
            }
            bytes.truncate(20_000);
        }
        bytes
    }
}

fn cases(default: u64) -> u64 {
    std::env::var("IRONOUT_FUZZ_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Runs `check` on mutations; says which input broke it.
fn fuzz(
    name: &str,
    corpus: &[Vec<u8>],
    default: u64,
    check: impl Fn(&[u8]) + std::panic::RefUnwindSafe,
) -> u64 {
    let count = cases(default);
    for case in 0..count {
        let input = Mutator::new(case).mutate(corpus);
        let result = std::panic::catch_unwind(|| check(&input));
        assert!(result.is_ok(), "{name}, case {case}: {:?}", String::from_utf8_lossy(&input));
    }
    count
}

#[test]
fn console_lines() {
    let corpus: Vec<Vec<u8>> = [
        "help\nversion\nstatus\n",
        "cal start\r\ncal stop\r\ncal accept\r\n",
        "cal method adjusted\ncal method trace\ncal method constant\n",
        "stream off\nstream raw\nstream cal\nstream motioncal\n",
        "effect add offset:temp_c\neffect remove drift\neffect list\nwhy\n",
        "cov current_a=3.2\nfield 48.5\ncal show\ncal clear\ncal cancel\n",
    ]
    .iter()
    .map(|text| text.as_bytes().to_vec())
    .collect();
    fuzz("console", &corpus, 20_000, |bytes| {
        let mut lines = LineSplitter::new();
        for byte in bytes {
            if let Some(Line::Text(text)) = lines.push(*byte) {
                assert!(text.len() <= 80 && !text.is_empty());
                if let Err(error) = parse(text) {
                    assert!(!format!("{error:?}").is_empty());
                }
            }
        }
    });
}

fn good_record() -> Record {
    Record {
        sequence: 7,
        calibration: Calibration {
            offset_ut: [93.25, -1.0 / 3.0, 1e-17],
            matrix: [[1.01, 0.02, -0.03], [0.0, 0.97, 0.1], [0.0, 0.0, 1.1]],
            field_ut: 48.123_456_789,
        },
        effects: Effects::none(),
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.26,
        axes: None,
        predicted_error: ironout::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    }
}

#[test]
fn stored_records() {
    let good = good_record();
    let encoded = good.encode().expect("a record of this size fits");
    let corpus = vec![encoded.as_bytes().to_vec()];
    fuzz("record", &corpus, 20_000, |bytes| {
        if let Ok(record) = Record::decode(bytes) {
            // The checksum let it through, so nothing of it was changed.
            assert!(record.calibration.is_sound(), "{record:?}");
        }
    });
    let back = Record::decode(encoded.as_bytes()).expect("an untouched record reads back");
    assert_eq!(format!("{back:?}"), format!("{good:?}"));
}

#[test]
fn csv_logs() {
    let corpus: Vec<Vec<u8>> = [
        "t_s,mx_ut,my_ut,mz_ut\n0,1.5,-2,40\n0.02,1.6,-2.1,40.2\n0.04,2,3,4\n",
        "# a comment\nt_us,mx_ut,my_ut,mz_ut,ax_mps2,ay_mps2,az_mps2,temp_c\n0,1,2,3,0,0,-9.8,25\n20000,1,2,3,0,0,-9.8,\n",
        "mx_counts,my_counts,mz_counts,current_a,note\n1,2,3,0.5,hello\n-4,5,-6,0.25,\"a, b\"\n",
        "t_s,mx_ut,my_ut,mz_ut,gx_radps,gy_radps,gz_radps,heading_deg\r\n0,1,2,3,0.1,0.2,0.3,359\r\n1,1,2,3,0,0,0,1\r\n",
    ]
    .iter()
    .map(|text| text.as_bytes().to_vec())
    .collect();
    fuzz("csv", &corpus, 20_000, |bytes| {
        let options = ReadOptions { ut_per_count: Some([0.1; 3]), ..ReadOptions::default() };
        match read_stream(bytes, bytes.len() as u64, &options) {
            Ok(log) => {
                for row in log.samples() {
                    assert!(log.field(row).iter().all(|v| v.is_finite()), "row {row}");
                }
            }
            Err(failure) => assert!(!failure.message.is_empty()),
        }
    });
}

#[test]
fn calibration_files() {
    let good = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/cal.json"))
        .expect("the fixture lies in the repository");
    assert!(CalFile::parse(&good).is_ok(), "the seed itself is good");
    let corpus = vec![good.into_bytes()];
    fuzz("CAL.json", &corpus, 5_000, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        if let Ok(file) = CalFile::parse(&text)
            && let Ok(calibration) = file.calibration()
        {
            let numbers = calibration.offset_ut.iter().chain(calibration.matrix.iter().flatten());
            assert!(numbers.chain([&calibration.field_ut]).all(|v| v.is_finite()), "{calibration:?}");
        }
    });
}
