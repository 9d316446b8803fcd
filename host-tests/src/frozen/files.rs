//! Files of the frozen set: small inputs of public complaints, and real recordings, as the program reads them.

use crate::frozen::entry::{Entry, Hidden, Made, Rows};
use ironout_cli::cli::LogArgs;
use ironout_cli::plausible::Known;
use ironout_cli::source;
use std::path::{Path, PathBuf};

/// What a file's owner knows besides: microtesla per count.
const UT_PER_COUNT: [(&str, &str); 7] = [
    ("05_uint16.csv", "0.092"),
    ("06_byteswap.csv", "0.092"),
    ("07_wrap16.csv", "0.01"),
    ("13_low_byte_lost.csv", "3.413"),
    ("hand-rotated-counts.csv", "0.1"),
    ("qmc5883l-filtered.csv", "0.0333"),
    ("qmc5883l-noisy.csv", "0.0333"),
];
/// Endings of what lies beside the logs.
const NOT_LOGS: [&str; 3] = ["md", "json", "bbl.txt"];

fn shared() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")).to_path_buf()
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    let below = |path: PathBuf| if path.is_dir() { files_below(&path) } else { vec![path] };
    paths.into_iter().flat_map(below).collect()
}

fn is_log(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    !NOT_LOGS.iter().any(|ending| name.ends_with(ending)) && !name.contains(".truth.")
}

/// Reads a file as `ironout diagnose` does.
fn read(path: &Path) -> Result<Made, String> {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let scale = UT_PER_COUNT.iter().find(|(own, _)| *own == name).map(|(_, scale)| (*scale).to_owned());
    let arguments = LogArgs { ut_per_count: scale, ..LogArgs::of(Path::new(name)) };
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let log = source::read_bytes(&arguments, &bytes, &Known::Earth).map_err(|failure| failure.message)?;
    Ok(Made { rows: Rows::Read(Box::new(log)), hidden: Hidden::Unknown, body_field_ut: None })
}

/// All logs of `shared/cases` and `shared/data`; nothing where the folder is not beside the project.
pub fn files() -> Vec<Entry> {
    let sets = ["cases", "data"].into_iter().flat_map(|set| {
        let paths = files_below(&shared().join(set)).into_iter().filter(|path| is_log(path));
        paths.map(move |path| {
            let relative = path.strip_prefix(shared().join(set)).unwrap_or(&path).display().to_string();
            Entry::new(set, relative, move || read(&path))
        })
    });
    sets.collect()
}
