//! Logs that are packed as a whole: read as what is in them, and what is broken is said.

use crate::common::{folder, ironout, text, write};
use crate::writers::fuzz::fuzz;
use crate::writers::truth::{Truth, read, read_with};
use ironout_cli::input::ReadOptions;
use std::io::Write;

fn gzip(plain: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(plain).expect("memory");
    packed.finish().expect("memory")
}

fn zstd(plain: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest)
}

/// A frame of RFC 8878 whose blocks are not compressed, written out from its text.
fn zstd_raw(plain: &[u8]) -> Vec<u8> {
    let mut out = 0xfd2f_b528_u32.to_le_bytes().to_vec();
    // Content size in four bytes, one segment, no checksum, no dictionary.
    out.push(0b1010_0000);
    out.extend((plain.len() as u32).to_le_bytes());
    let blocks: Vec<&[u8]> = plain.chunks(100_000).collect();
    for (index, block) in blocks.iter().enumerate() {
        let head = (block.len() as u32) << 3 | u32::from(index + 1 == blocks.len());
        out.extend(&head.to_le_bytes()[..3]);
        out.extend(*block);
    }
    out
}

/// The lower half of XXH64 with seed 0, of which a frame keeps four bytes: written out from its specification.
fn twox(plain: &[u8]) -> u32 {
    const P: [u64; 5] = [
        0x9e37_79b1_85eb_ca87,
        0xc2b2_ae3d_27d4_eb4f,
        0x1656_67b1_9e37_79f9,
        0x85eb_ca77_c2b2_ae63,
        0x27d4_eb2f_1656_67c5,
    ];
    let round =
        |sum: u64, lane: u64| sum.wrapping_add(lane.wrapping_mul(P[1])).rotate_left(31).wrapping_mul(P[0]);
    let word = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    let mut lanes = [P[0].wrapping_add(P[1]), P[1], 0, 0_u64.wrapping_sub(P[0])];
    let stripes = plain.chunks_exact(32);
    let mut rest = stripes.remainder();
    for stripe in stripes {
        for (lane, bytes) in lanes.iter_mut().zip(stripe.chunks_exact(8)) {
            *lane = round(*lane, word(bytes));
        }
    }
    let turned = lanes.iter().zip([1, 7, 12, 18]).map(|(lane, by)| lane.rotate_left(by));
    let mut sum = turned.fold(0_u64, u64::wrapping_add);
    for lane in lanes {
        sum = (sum ^ round(0, lane)).wrapping_mul(P[0]).wrapping_add(P[3]);
    }
    sum = sum.wrapping_add(plain.len() as u64);
    while rest.len() >= 8 {
        sum = (sum ^ round(0, word(&rest[..8]))).rotate_left(27).wrapping_mul(P[0]).wrapping_add(P[3]);
        rest = &rest[8..];
    }
    if rest.len() >= 4 {
        let half = u64::from(u32::from_le_bytes(rest[..4].try_into().expect("four bytes")));
        sum = (sum ^ half.wrapping_mul(P[0])).rotate_left(23).wrapping_mul(P[1]).wrapping_add(P[2]);
        rest = &rest[4..];
    }
    for byte in rest {
        sum = (sum ^ u64::from(*byte).wrapping_mul(P[4])).rotate_left(11).wrapping_mul(P[0]);
    }
    sum = (sum ^ (sum >> 33)).wrapping_mul(P[1]);
    sum = (sum ^ (sum >> 29)).wrapping_mul(P[2]);
    (sum ^ (sum >> 32)) as u32
}

#[test]
fn a_file_of_zstd_is_read_as_what_is_in_it() {
    let truth = Truth::new("packed_zstd");
    let plain = std::fs::read(&truth.csv).expect("a file");
    assert!(plain.len() > 200_000, "{}", plain.len());
    let (one, other) = plain.split_at(plain.len() / 3);
    // A frame that holds something else than content, as programs with several threads write it.
    let skipped = [&0x184d_2a53_u32.to_le_bytes()[..], &5_u32.to_le_bytes(), b"other"].concat();
    for (name, packed) in [
        ("packed", zstd(&plain)),
        ("raw blocks", zstd_raw(&plain)),
        ("two frames", [zstd(one), zstd_raw(other)].concat()),
        (
            "frames between others",
            [skipped.clone(), zstd(one), skipped.clone(), zstd(other), skipped].concat(),
        ),
    ] {
        let log = read(&packed).unwrap_or_else(|failure| panic!("{name}: {failure}"));
        assert_eq!((log.rows, &log.field_ut), (truth.log.rows, &truth.log.field_ut), "{name}");
        assert!(log.read_as.format.contains("zstd"), "{name}: {}", log.read_as.format);
        // Cut off: what is whole is read, and the cut is said; or nothing is read, with what to do.
        match read(&packed[..packed.len() / 2]) {
            Ok(log) => {
                assert!(log.rows < truth.log.rows, "{name}");
                assert!(log.notices.iter().any(|notice| notice.contains("truncated")), "{:?}", log.notices);
            }
            Err(failure) => assert!(failure.message.contains("truncated"), "{name}: {failure}"),
        }
    }
    // The program answers alike, whatever the file is called.
    let here = folder("packed_zstd_program");
    let (own, packed) = (text(&truth.csv).to_string(), write(&here, "log.csv", zstd(&plain)));
    let offset = |log: &str| {
        let run = ironout(["fit", log, "--json"]);
        assert_eq!(run.status, 0, "{log}: {}", run.stderr);
        run.json()["offset_ut"].clone()
    };
    assert_eq!(offset(text(&packed)), offset(&own));
}

#[test]
fn content_that_was_changed_on_the_way_is_told_by_its_checksum() {
    let truth = Truth::new("packed_checksum");
    let plain = std::fs::read(&truth.csv).expect("a file");
    // A digit of the last row, where it stands in the file as it is.
    let mut packed = zstd_raw(&plain);
    packed[4] |= 0b100;
    let whole = twox(&plain);
    packed.extend(whole.to_le_bytes());
    let log = read(&packed).expect("a log");
    assert_eq!((log.rows, log.notices.len()), (truth.log.rows, 0), "{:?}", log.notices);
    let content = packed.len() - 4;
    let digit = packed[..content].iter().rposition(u8::is_ascii_digit).expect("a digit");
    packed[digit] ^= 1;
    let log = read(&packed).expect("a log");
    assert!(log.notices.iter().any(|notice| notice.contains("another checksum")), "{:?}", log.notices);
}

#[test]
fn a_file_of_zstd_that_is_broken_says_so_and_what_to_do() {
    let truth = Truth::new("packed_broken");
    let plain = std::fs::read(&truth.csv).expect("a file");
    let packed = zstd(&plain);
    let here = folder("packed_broken_files");
    for (name, bytes) in [
        ("mark_alone.zst", packed[..4].to_vec()),
        // A descriptor that asks for a dictionary, of which there is none.
        ("dictionary.zst", [&packed[..4], &[0b0000_0011, 0x58], &[7; 40]].concat()),
    ] {
        let path = write(&here, name, bytes);
        let error = ironout(["fit", text(&path), "--json"]).error();
        let message = error["message"].as_str().unwrap_or_default();
        assert!(message.contains("zstd") && message.contains("Fix:"), "{name}: {error}");
        assert_eq!(error["file"].as_str(), Some(text(&path)), "{error}");
    }
}

#[test]
fn broken_files_are_answered_or_refused() {
    let truth = Truth::new("packed_fuzz");
    let plain = std::fs::read(&truth.csv).expect("a file");
    let short = &plain[..plain.len().min(30_000)];
    for (name, packed) in [("gzip", &[gzip(short)][..]), ("zstd", &[zstd(short), zstd_raw(short)])] {
        let good: Vec<&[u8]> = packed.iter().map(Vec::as_slice).collect();
        for good in &good {
            let scale = ReadOptions { ut_per_count: Some([0.1; 3]), ..ReadOptions::default() };
            // The last line is cut off.
            let end = short.iter().rposition(|byte| *byte == b'\n').expect("lines");
            assert!(read_with(&short[..=end], &scale).is_ok() && good.len() > 1000, "{name}");
        }
        let accepted = fuzz(name, &good, 4000);
        assert!(accepted < 4000, "{name}: {accepted}");
    }
}
