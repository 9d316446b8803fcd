//! Rows on their way into a log, while it is not known yet which columns it will have.

use crate::atomic;
use crate::failure::{Failure, Outcome};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file next to the log, which goes with this value.
pub struct Spool {
    path: PathBuf,
    output: PathBuf,
    out: BufWriter<File>,
}

impl Spool {
    /// A new one for the log at `output`.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn beside(output: &Path) -> Outcome<Self> {
        let name = output
            .file_name()
            .ok_or_else(|| Failure::usage("this is not a file name. Name a file to write").in_file(output))?;
        let mut beside = std::ffi::OsString::from(".");
        beside.push(name);
        beside.push(format!(".{}.rows", std::process::id()));
        let path = output.with_file_name(beside);
        let file = File::create(&path).map_err(|error| Failure::io("write", output, &error))?;
        Ok(Spool { path, output: output.to_path_buf(), out: BufWriter::new(file) })
    }

    /// Where rows are written.
    pub fn out(&mut self) -> &mut impl Write {
        &mut self.out
    }

    /// Writes the log: comments, a header with these columns, and the rows; cells of columns that came later are empty.
    ///
    /// # Errors
    /// A full disk.
    pub fn finish(mut self, comments: &[String], names: &[String]) -> Outcome<()> {
        let failed = |error: std::io::Error| Failure::io("write", &self.output, &error);
        self.out.flush().map_err(failed)?;
        let rows = BufReader::new(File::open(&self.path).map_err(failed)?);
        let cells = 4 + names.len();
        atomic::write(&self.output, |out| {
            comments.iter().try_for_each(|comment| writeln!(out, "# {comment}"))?;
            write!(out, "t_s,mx_ut,my_ut,mz_ut")?;
            names.iter().try_for_each(|name| write!(out, ",{name}"))?;
            writeln!(out)?;
            for line in rows.lines() {
                let line = line?;
                out.write_all(line.as_bytes())?;
                if !line.starts_with('#') {
                    let missing = cells.saturating_sub(line.split(',').count());
                    (0..missing).try_for_each(|_| out.write_all(b","))?;
                }
                writeln!(out)?;
            }
            Ok(())
        })
    }
}

impl Drop for Spool {
    fn drop(&mut self) {
        // Its rows are in the log; that it cannot be removed is not a reason to fail.
        let _ = std::fs::remove_file(&self.path);
    }
}
