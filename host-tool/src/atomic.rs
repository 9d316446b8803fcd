//! Files that are there whole or not at all.

use crate::failure::{Failure, Outcome};
use crate::output;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `path` through a file next to it that takes its place only when everything has been written: a reader
/// never sees half a file, and an old one survives any failure. A link is followed, an old file's rights are kept, and what is no
/// regular file (a terminal, a pipe) is written to and not replaced; `-` is standard output.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Outcome<()> {
    let fail = |error: std::io::Error| Failure::io("write", path, &error);
    if output::is_standard(path) {
        let mut out = BufWriter::with_capacity(1 << 16, std::io::stdout());
        return match fill(&mut out).and_then(|()| out.flush()) {
            // The reader has enough (`| head`).
            Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
            written => {
                written.map_err(|error| Failure::usage(format!("cannot write to standard output: {error}")))
            }
        };
    }
    let old = std::fs::metadata(path).ok();
    if old.as_ref().is_some_and(|old| !old.is_file() && !old.is_dir()) {
        let through = || {
            let mut out = BufWriter::with_capacity(1 << 16, File::options().write(true).open(path)?);
            fill(&mut out)?;
            out.flush()
        };
        return through().map_err(fail);
    }
    if old.as_ref().is_some_and(|old| old.permissions().readonly()) {
        return Err(Failure::usage("this file is read-only. Name another one with -o").in_file(path));
    }
    // A link's target is replaced, not the link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let name = target
        .file_name()
        .ok_or_else(|| Failure::usage("this is not a file name. Name a file to write").in_file(path))?;
    let mut beside = std::ffi::OsString::from(".");
    beside.push(name);
    beside.push(format!(".{}.part", std::process::id()));
    let part = target.with_file_name(beside);
    let written = (|| {
        let file = File::create(&part)?;
        if let Some(old) = &old {
            std::fs::set_permissions(&part, old.permissions())?;
        }
        let mut out = BufWriter::with_capacity(1 << 16, file);
        fill(&mut out)?;
        out.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
        std::fs::rename(&part, &target)
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
pub fn not_over(input: &Path, target: &Path) -> Outcome<()> {
    if !output::is_standard(target) && same_file(input, target) {
        return Err(
            Failure::usage("this would overwrite the input file. Name another one with -o").in_file(target)
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn links_rights_and_devices_are_kept() {
        use std::os::unix::fs::PermissionsExt;
        let folder = std::env::temp_dir().join(format!("ironout-atomic-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (real, link) = (folder.join("real.json"), folder.join("link.json"));
        std::fs::write(&real, "old").unwrap();
        std::fs::set_permissions(&real, std::fs::Permissions::from_mode(0o600)).unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write(&link, |out| out.write_all(b"new")).unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(std::fs::read_to_string(&real).unwrap(), "new");
        assert_eq!(real.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        // A failure leaves the old file.
        write(&real, |_| Err(std::io::Error::other("full"))).unwrap_err();
        assert_eq!(std::fs::read_to_string(&real).unwrap(), "new");
        std::fs::set_permissions(&real, std::fs::Permissions::from_mode(0o444)).unwrap();
        assert!(write(&real, |_| Ok(())).unwrap_err().message.contains("read-only"));
        // The bit bucket takes it and stays what it is.
        write(Path::new("/dev/null"), |out| out.write_all(b"gone")).unwrap();
        assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
