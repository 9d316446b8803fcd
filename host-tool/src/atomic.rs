//! Files that are there whole or not at all.

use crate::failure::{Failure, Outcome};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `path` through a file beside it that takes its place only when everything has been written: a reader
/// never sees half a file, and an old one survives any failure.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Outcome<()> {
    let name = path
        .file_name()
        .ok_or_else(|| Failure::usage("this is no file name: name a file to write").in_file(path))?;
    let mut beside = std::ffi::OsString::from(".");
    beside.push(name);
    beside.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(beside);
    let fail = |error: std::io::Error| Failure::io("write", path, &error);
    let written = (|| {
        let file = File::create(&part)?;
        let mut out = BufWriter::with_capacity(1 << 16, file);
        fill(&mut out)?;
        out.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
        std::fs::rename(&part, path)
    })();
    written.map_err(|error| {
        // The part is worthless; that it cannot be removed would hide the real error.
        let _ = std::fs::remove_file(&part);
        fail(error)
    })
}
