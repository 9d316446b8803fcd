//! The files that the page is made of, packed into the program.

use flate2::read::GzDecoder;
use std::io::Read;

include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// The analysis as WebAssembly, packed by gzip.
pub(crate) const MODULE: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/module.wasm.gz"));

/// Bytes of the module as it is sent: packed by gzip.
pub fn module_bytes() -> usize {
    MODULE.len()
}

/// A file of the page, packed; nothing of a name that there is not.
pub(crate) fn packed(name: &str) -> &'static [u8] {
    FILES.iter().find(|(own, _)| *own == name).map_or(&[], |(_, bytes)| bytes)
}

/// The text of a file of the page.
pub(crate) fn text(name: &str) -> String {
    let mut text = String::new();
    // The bytes are the build's own; what cannot be read shows as a page without it, which the tests would see.
    let _ = GzDecoder::new(packed(name)).read_to_string(&mut text);
    text
}

/// The licences of the libraries in the page and in the program, and of the program itself.
pub fn licences() -> String {
    format!(
        "ironout\n\n{}\n\nthree.js\n\n{}\n\nuPlot\n\n{}\n\n{}",
        include_str!("../../LICENSE").trim(),
        text("three.LICENSE").trim(),
        text("uplot.LICENSE").trim(),
        text("crates.LICENSES.txt")
    )
}
