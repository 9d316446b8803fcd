//! What the library and the firmware take of a microcontroller's flash and RAM: the table of `cargo footprint`, and its snapshot.
//!
//! Linked programs have `opt-level = "s"` and fat LTO (`[profile.c]`) and are compared with one that uses nothing of the library; images are the firmware of `cargo fw-NAME`.

use crate::m4::{M4Error, build_image, sections, size, snapshot::TOLERANCE};
use crate::symbols::{Placed, groups, list};
use ironout_rig::qemu::Firmware;
use object::{Object, ObjectSection, ObjectSymbol};
use std::path::{Path, PathBuf};

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Program {
    /// What is linked; its image is `linked-KEY`.
    pub key: &'static str,
    /// Features of the library that it needs.
    pub features: &'static str,
    /// Bytes of flash before the library was made smaller, on 2026-11-27.
    pub before: u64,
    /// Bytes that are wanted; a limit that is not met is shown, not held.
    pub wanted: Option<u64>,
}

const fn program(key: &'static str, features: &'static str, before: u64, wanted_kib: u64) -> Program {
    Program { key, features, before, wanted: Some(wanted_kib * 1024) }
}

/// The programs, from the smallest use of the library on.
pub const PROGRAMS: [Program; 13] = [
    Program { key: "apply", features: "", before: 140, wanted: Some(205) },
    program("sums", "", 952, 1),
    program("trace", "", 19_080, 12),
    program("adjusted", "", 20_208, 18),
    program("session", "session", 51_920, 26),
    program("session-record", "record", 60_608, 30),
    program("session-store", "record", 63_624, 32),
    program("live", "effects", 23_808, 12),
    program("session-live", "session,effects", 69_248, 40),
    Program { key: "live-record", features: "record,effects", before: 28_632, wanted: None },
    Program { key: "session-store-effects", features: "record,effects", before: 63_624, wanted: None },
    Program { key: "session-methods", features: "session,methods", before: 51_920, wanted: None },
    program("study", "study", 52_536, 60),
];

/// A firmware image.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Name of the row.
    pub key: &'static str,
    /// The board's feature.
    pub board: &'static str,
    /// Without the study and the other methods.
    pub is_lean: bool,
    /// See [`Program`].
    pub before: u64,
}

const fn image(key: &'static str, board: &'static str, is_lean: bool, before: u64) -> Image {
    Image { key, board, is_lean, before }
}

/// Bytes of flash that are wanted of an image, and of a lean one.
const WANTED: [u64; 2] = [140 * 1024, 90 * 1024];

/// The images.
pub const IMAGES: [Image; 6] = [
    image("pico", "board-pico", false, 251_892),
    image("mps2", "board-mps2", false, 220_272),
    image("microbit-v2", "board-microbit-v2", false, 227_328),
    image("stm32f3discovery", "board-stm32f3discovery", false, 236_544),
    image("pico-lean", "board-pico", true, 251_892),
    image("mps2-lean", "board-mps2", true, 220_272),
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

/// What counts as flash of a linked program; its vector table is the same for all.
const FLASH_SECTIONS: [&str; 3] = [".text", ".rodata", ".data"];

/// A program with no more of the library than it needs.
fn build(key: &str, features: &str) -> Result<PathBuf, M4Error> {
    build_image(&format!("linked-{key}"), "c", features)
}

/// Flash of a program, bytes.
fn flash(key: &str, features: &str) -> Result<u64, M4Error> {
    let sections = sections(&build(key, features)?)?;
    Ok(FLASH_SECTIONS.iter().map(|name| size(&sections, name)).sum())
}

/// Builds the programs and measures them.
///
/// # Errors
/// See [`M4Error`].
pub fn programs() -> Result<Vec<Row>, M4Error> {
    let nothing = flash("nothing", "")?;
    let rows = PROGRAMS.iter().map(|program| {
        let Program { key, features, before, wanted } = *program;
        let flash = flash(key, features)?.saturating_sub(nothing);
        Ok(Row { key, before, flash, statics: None, wanted })
    });
    rows.collect()
}

fn failed(error: impl std::fmt::Display) -> M4Error {
    M4Error::Failed(error.to_string())
}

fn build_firmware(image: &Image) -> Result<Firmware, M4Error> {
    let build = if image.is_lean { Firmware::build_lean } else { Firmware::build_for };
    build(image.board).map_err(failed)
}

/// Builds the images of the boards and measures them; of those that an emulator runs only, or of all.
///
/// # Errors
/// [`M4Error::Failed`] with what the build says.
pub fn images(emulated_only: bool) -> Result<Vec<Row>, M4Error> {
    let is_emulated = |image: &&Image| matches!(image.board, "board-pico" | "board-mps2");
    let rows = IMAGES.iter().filter(|image| !emulated_only || is_emulated(image)).map(|image| {
        let size = build_firmware(image)?.footprint().map_err(failed)?;
        let Image { key, before, .. } = *image;
        let wanted = WANTED.get(usize::from(image.is_lean)).copied();
        Ok(Row { key, before, flash: size.flash(), statics: Some(size.data + size.bss), wanted })
    });
    rows.collect()
}

/// Symbols of these sections, and the bytes that the sections have.
fn placed(image: &Path, sections: &[&str]) -> Result<(Vec<Placed>, u64), M4Error> {
    let bytes = std::fs::read(image)?;
    let file = object::File::parse(&*bytes).map_err(failed)?;
    let counted: Vec<_> = file
        .sections()
        .filter(|section| section.name().is_ok_and(|name| sections.contains(&name)))
        .map(|section| (section.index(), section.size()))
        .collect();
    let is_counted = |index| counted.iter().any(|(section, _)| Some(*section) == index);
    let placed = file.symbols().filter(|symbol| is_counted(symbol.section_index())).map(|symbol| {
        // The lowest bit of a function's address says that it is Thumb code.
        let address = symbol.address() & !u64::from(symbol.kind() == object::SymbolKind::Text);
        Placed { name: symbol.name().unwrap_or_default().to_owned(), address, size: symbol.size() }
    });
    Ok((placed.collect(), counted.iter().map(|(_, size)| size).sum()))
}

/// Builds a program or an image, or every program, and lists where its flash goes.
///
/// # Errors
/// See [`M4Error`].
pub fn symbols(key: Option<&str>) -> Result<String, M4Error> {
    /// Smaller symbols are listed for a single program only, bytes.
    const LEAST_IN_OVERVIEW: u64 = 400;
    const LEAST_OF_ONE: u64 = 16;
    if let Some(image) = IMAGES.iter().find(|image| key == Some(image.key)) {
        let firmware = build_firmware(image)?;
        let sections = [".vector_table", ".boot2", ".text", ".rodata", ".data"];
        let groups = groups(placed(firmware.path(), &sections)?, (Vec::new(), 0));
        return Ok(list(image.key, &groups, LEAST_OF_ONE));
    }
    let chosen: Vec<_> = PROGRAMS.iter().filter(|program| key.is_none_or(|key| key == program.key)).collect();
    if chosen.is_empty() {
        return Err(M4Error::Failed(format!("no program or image is called {}", key.unwrap_or_default())));
    }
    let least = if key.is_some() { LEAST_OF_ONE } else { LEAST_IN_OVERVIEW };
    let nothing = placed(&build("nothing", "")?, &FLASH_SECTIONS)?;
    let lists = chosen.iter().map(|program| {
        let all = placed(&build(program.key, program.features)?, &FLASH_SECTIONS)?;
        Ok(list(program.key, &groups(all, nothing.clone()), least))
    });
    Ok(lists.collect::<Result<Vec<_>, M4Error>>()?.join("\n"))
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

/// The rows that are known: what was measured now, and the others as they are stored.
pub fn with_stored(rows: &[Row], stored: &str) -> Vec<Row> {
    let keys = PROGRAMS.iter().map(|program| (program.key, program.before, program.wanted)).chain(
        IMAGES.iter().map(|image| (image.key, image.before, WANTED.get(usize::from(image.is_lean)).copied())),
    );
    let known = keys.filter_map(|(key, before, wanted)| {
        let measured = rows.iter().find(|row| row.key == key).cloned();
        measured.or_else(|| {
            let number = |column| stored_number(stored, key, column);
            Some(Row { key, before, flash: number(2)?, statics: number(6), wanted })
        })
    });
    known.collect()
}

/// A number of the stored table, by the row's key and the column.
fn stored_number(stored: &str, key: &str, column: usize) -> Option<u64> {
    let line = stored.lines().find(|line| line.split_whitespace().next() == Some(key))?;
    line.split_whitespace().nth(column)?.parse().ok()
}

/// Where the snapshot lies.
pub fn snapshot_path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/footprint.txt"))
}

/// Rows that take more flash than the stored table says, one sentence each.
pub fn worse(rows: &[Row], stored: &str) -> Vec<String> {
    let grown = rows.iter().filter_map(|row| match stored_number(stored, row.key, 2) {
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
        // What was not measured stays as it was stored.
        let kept = with_stored(&[Row { key: "live", ..row(7) }], &stored);
        let flash: Vec<_> = kept.iter().map(|row| (row.key, row.flash)).collect();
        assert_eq!(flash, [("session", 40_000), ("live", 7)]);
    }
}
