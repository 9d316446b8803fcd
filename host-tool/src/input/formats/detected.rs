//! Which binary format a file is in, told by its first bytes.

use crate::input::formats::{betaflight_json, mavlink};

/// How many first bytes [`detect`] wants to see; fewer are fine where the file has no more.
pub const FIRST_BYTES: usize = 4096;

/// The formats of other programs that are read as recordings of several streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// PX4 ULog.
    Ulog,
    /// ArduPilot DataFlash, binary (`.bin`).
    DataflashBinary,
    /// ArduPilot DataFlash, as text (`.log`).
    DataflashText,
    /// Betaflight or INAV blackbox.
    Blackbox,
    /// Samples of Betaflight Configurator.
    BetaflightJson,
    /// MAVLink telemetry (`.tlog`).
    Mavlink,
    /// MCAP, as ROS 2 records it.
    Mcap,
    /// An SQLite file, as rosbag2 writes it (`.db3`).
    Rosbag,
}

/// The format whose mark `first` holds; `None` where it is none of them. Most marks stand at the very beginning, that of a
/// blackbox log may have the rest of an erased flash before it.
pub fn detect(first: &[u8]) -> Option<Format> {
    const BLACKBOX: &[u8] = b"H Product:Blackbox";
    if first.starts_with(b"ULog\x01\x12\x35") {
        return Some(Format::Ulog);
    }
    if first.starts_with(&[0xa3, 0x95]) {
        return Some(Format::DataflashBinary);
    }
    if first.starts_with(b"\x89MCAP0\r\n") {
        return Some(Format::Mcap);
    }
    if first.starts_with(b"SQLite format 3\0") {
        return Some(Format::Rosbag);
    }
    if mavlink::is_log(first) {
        return Some(Format::Mavlink);
    }
    if betaflight_json::is_export(first) {
        return Some(Format::BetaflightJson);
    }
    if first.windows(BLACKBOX.len()).any(|window| window == BLACKBOX) {
        return Some(Format::Blackbox);
    }
    let text = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(first).trim_ascii_start();
    let line = text.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let definition = line.strip_prefix(b"FMT,").is_some() && line.iter().filter(|b| **b == b',').count() >= 5;
    definition.then_some(Format::DataflashText)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_told_and_nothing_else() {
        assert_eq!(detect(b"ULog\x01\x12\x35\x01"), Some(Format::Ulog));
        assert_eq!(detect(&[0xa3, 0x95, 0x80]), Some(Format::DataflashBinary));
        assert_eq!(detect(b"\xff\xff\xffH Product:Blackbox flight data"), Some(Format::Blackbox));
        assert_eq!(detect(b"\x89MCAP0\r\n\x01"), Some(Format::Mcap));
        assert_eq!(
            detect(b"\r\nFMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\r\n"),
            Some(Format::DataflashText)
        );
        for other in [&b"t_s,mx_ut,my_ut,mz_ut\n"[..], b"", b"FMT,a\n", b"ULog", b"\x89PNG\r\n"] {
            assert_eq!(detect(other), None, "{other:?}");
        }
    }
}
