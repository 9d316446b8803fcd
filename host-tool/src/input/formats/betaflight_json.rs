//! Samples of Betaflight Configurator's magnetometer calibration, as it exports them (2026): one JSON object whose `type` is
//! `calibration_tumble`, with `samples` of `x`, `y`, `z` (what the firmware made of its sensor, in counts) and `timestamp` (ms since
//! 1970), and the `firmwareOffsets` that were subtracted.

use crate::failure::{Failure, Outcome};
use crate::input::formats::rotation::LEFT_UP;
use crate::input::formats::stream::{Between, Recording, Stream};
use ironout_analysis::frame::{Frame, IDENTITY, Program, Removed};
use serde::Deserialize;
use std::io::Read;

/// Longest file, bytes: an hour of samples every 80 ms has some tens of megabytes.
const LARGEST_FILE: u64 = 1 << 28;

#[derive(Deserialize)]
struct File {
    samples: Vec<Sample>,
    #[serde(default, rename = "firmwareOffsets")]
    offsets: Option<Offsets>,
}

#[derive(Deserialize)]
struct Sample {
    x: Option<f64>,
    y: Option<f64>,
    z: Option<f64>,
    timestamp: Option<f64>,
}

#[derive(Deserialize)]
struct Offsets {
    x: f64,
    y: f64,
    z: f64,
}

/// Whether a file begins as such an export.
pub fn is_export(first: &[u8]) -> bool {
    let text = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(first).trim_ascii_start();
    text.starts_with(b"{") && memchr::memmem::find(text, b"\"calibration_tumble\"").is_some()
}

/// Reads such an export.
///
/// # Errors
/// Not readable, or of another form.
pub fn read(source: impl Read) -> Outcome<Recording> {
    let mut text = Vec::new();
    source
        .take(LARGEST_FILE)
        .read_to_end(&mut text)
        .map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&text);
    let file: File = serde_json::from_slice(text).map_err(|error| {
        Failure::usage(format!(
            "these samples of Betaflight Configurator cannot be read: {error}. Fix: export them again"
        ))
        .at_line(error.line() as u64)
    })?;
    let mut stream = ["x", "y", "z"].iter().fold(Stream::new("samples"), |stream, axis| {
        stream.with(&format!("m{axis}_counts"), &format!("samples.{axis}"), "counts", Between::Line)
    });
    let first = file.samples.iter().find_map(|sample| sample.timestamp).unwrap_or(0.0);
    let offset = file.offsets.as_ref().map_or([0.0; 3], |offsets| [offsets.x, offsets.y, offsets.z]);
    for sample in &file.samples {
        let time_s = sample.timestamp.map_or(f64::NAN, |time| (time - first) / 1e3);
        let value = |own: Option<f64>, offset: f64| own.map_or(f64::NAN, |own| own + offset);
        let [x, y, z] = offset;
        stream.push(time_s, &[value(sample.x, x), value(sample.y, y), value(sample.z, z)]);
    }
    stream.turn(["mx_counts", "my_counts", "mz_counts"], &LEFT_UP);
    let mut frame = Frame::of(Program::Betaflight, 1.0, LEFT_UP);
    let mut taken_out =
        vec!["rotated from x forward, y left, z up to x forward, y right, z down".to_string()];
    if offset != [0.0; 3] {
        taken_out
            .push(format!("firmwareOffsets: {} counts", offset.map(|value| value.to_string()).join(" ")));
        frame.removed = vec![Removed { from_s: None, offset, matrix: IDENTITY, power: false }];
    }
    Ok(Recording {
        format: "samples of Betaflight Configurator".into(),
        magnetometer: stream,
        frame,
        taken_out,
        ..Recording::default()
    })
}
