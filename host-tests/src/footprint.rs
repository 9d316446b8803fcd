//! What the library and the firmware take of a microcontroller's flash and RAM: the table of `cargo footprint`, and its snapshot.
//!
//! Linked programs have `opt-level = "s"` and fat LTO (`[profile.c]`) and are compared with one that uses nothing of the library; images are the firmware of `cargo fw-NAME`.

use crate::m4::{M4Error, TARGET, build_images, sections, size, snapshot::TOLERANCE};
use ironout_rig::qemu::Firmware;
use std::path::PathBuf;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Program {
    /// What is linked; its image is `linked-KEY`.
    pub key: &'static str,
    /// Bytes of flash before the library was made smaller, on 2026-11-27.
    pub before: u64,
    /// Bytes that are wanted; a limit that is not met is shown, not held.
    pub wanted: Option<u64>,
}

const fn program(key: &'static str, before: u64, wanted_kib: Option<u64>) -> Program {
    let wanted = match wanted_kib {
        Some(kib) => Some(kib * 1024),
        None => None,
    };
    Program { key, before, wanted }
}

/// The programs, from the smallest use of the library on.
pub const PROGRAMS: [Program; 11] = [
    Program { key: "apply", before: 140, wanted: Some(205) },
    program("sums", 1_840, Some(1)),
    program("trace", 19_080, Some(12)),
    program("adjusted", 20_208, Some(18)),
    program("session", 51_920, Some(26)),
    program("session-record", 60_608, Some(30)),
    program("session-store", 63_624, Some(32)),
    program("live", 23_808, Some(12)),
    program("live-record", 28_632, None),
    program("session-live", 69_248, Some(40)),
    program("study", 52_536, Some(60)),
];

/// A firmware image: its name and the features that make it.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Name of the row.
    pub key: &'static str,
    /// Features of the firmware.
    pub features: &'static str,
    /// See [`Program`].
    pub before: u64,
    /// See [`Program`].
    pub wanted: Option<u64>,
}

/// The images.
pub const IMAGES: [Image; 4] = [
    Image { key: "pico", features: "board-pico", before: 0, wanted: Some(140 * 1024) },
    Image { key: "mps2", features: "board-mps2", before: 0, wanted: Some(140 * 1024) },
    Image { key: "microbit-v2", features: "board-microbit-v2", before: 0, wanted: Some(140 * 1024) },
    Image {
        key: "stm32f3discovery",
        features: "board-stm32f3discovery",
        before: 0,
        wanted: Some(140 * 1024),
    },
];

/// A measured row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was linked.
    pub key: &'static str,
    /// Bytes of flash before, see [`Program`].
    pub before: u64,
    /// Bytes of flash now: code, constants, initial values.
    pub flash: u64,
    /// Bytes of statics; of images only.
    pub statics: Option<u64>,
    /// Bytes that are wanted.
    pub wanted: Option<u64>,
}

/// Builds the programs and measures them.
///
/// # Errors
/// See [`M4Error`].
pub fn programs() -> Result<Vec<Row>, M4Error> {
    let images = build_images("c", TARGET)?;
    let flash = |key: &str| -> Result<u64, M4Error> {
        let path: &PathBuf = images
            .get(&format!("linked-{key}"))
            .ok_or_else(|| M4Error::Failed(format!("cargo built no image linked-{key}")))?;
        let sections = sections(path)?;
        Ok([".text", ".rodata", ".data"].iter().map(|name| size(&sections, name)).sum())
    };
    let nothing = flash("nothing")?;
    let rows = PROGRAMS.iter().map(|program| {
        let flash = flash(program.key)?.saturating_sub(nothing);
        let Program { key, before, wanted } = *program;
        Ok(Row { key, before, flash, statics: None, wanted })
    });
    rows.collect()
}

/// Builds the images of the boards and measures them.
///
/// # Errors
/// [`M4Error::Failed`] with what the build says.
pub fn images() -> Result<Vec<Row>, M4Error> {
    let rows = IMAGES.iter().map(|image| {
        let size = Firmware::build_for(image.features)
            .and_then(|firmware| firmware.footprint())
            .map_err(|error| M4Error::Failed(error.to_string()))?;
        let Image { key, before, wanted, .. } = *image;
        Ok(Row { key, before, flash: size.flash(), statics: Some(size.data + size.bss), wanted })
    });
    rows.collect()
}

/// The readable table.
pub fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<22} {:>8} {:>8} {:>7} {:>8} {:>8}\n",
        "linked", "before", "now", "change", "wanted", "statics"
    );
    let or_dash = |value: Option<u64>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
    for row in rows {
        let change = (row.flash as f64 / row.before as f64 - 1.0) * 100.0;
        text += &format!(
            "{:<22} {:>8} {:>8} {:>5.0} % {:>8} {:>8}\n",
            row.key,
            row.before,
            row.flash,
            change,
            or_dash(row.wanted),
            or_dash(row.statics)
        );
    }
    text
}

/// Where the snapshot lies.
pub fn snapshot_path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/footprint.txt"))
}

/// Rows that take more flash than the stored table says, one sentence each.
pub fn worse(rows: &[Row], stored: &str) -> Vec<String> {
    let stored_flash = |key: &str| {
        let line = stored.lines().find(|line| line.split_whitespace().next() == Some(key))?;
        line.split_whitespace().nth(2)?.parse::<u64>().ok()
    };
    let grown = rows.iter().filter_map(|row| match stored_flash(row.key) {
        None => Some(format!("{} is not in the snapshot", row.key)),
        Some(old) if row.flash as f64 > old as f64 * (1.0 + TOLERANCE) => {
            Some(format!("{} grew from {old} to {} bytes", row.key, row.flash))
        }
        Some(_) => None,
    });
    grown.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(flash: u64) -> Row {
        Row { key: "session", before: 50_000, flash, statics: None, wanted: Some(26_624) }
    }

    #[test]
    fn a_row_that_grows_by_more_than_three_percent_fails() {
        let stored = table(&[row(40_000)]);
        assert!(stored.contains("-20 %"), "{stored}");
        assert!(worse(&[row(41_200)], &stored).is_empty());
        assert_eq!(worse(&[row(41_201)], &stored), ["session grew from 40000 to 41201 bytes"]);
        assert_eq!(worse(&[row(1)], ""), ["session is not in the snapshot"]);
    }
}
