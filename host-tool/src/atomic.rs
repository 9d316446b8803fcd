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

/// Whether two paths name the same existing file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Refuses to write over what is read.
pub fn not_over(input: &Path, output: &Path) -> Outcome<()> {
    if same_file(input, output) {
        return Err(Failure::usage("this would replace the file that is read: name another one with -o")
            .in_file(output));
    }
    Ok(())
}
