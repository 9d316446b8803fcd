//! What the tests of the command share: running it, files of their own, the real recordings.

pub mod alike;
pub mod target;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What a run of `ironout` gave.
pub struct Run {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// Standard output as one JSON object, and nothing else there.
    pub fn json(&self) -> serde_json::Value {
        let trimmed = self.stdout.trim_end_matches('\n');
        assert!(!trimmed.contains('\n'), "one object on one line: {trimmed}");
        let value: serde_json::Value = serde_json::from_str(trimmed)
            .unwrap_or_else(|error| panic!("no JSON ({error}): {:?} stderr {:?}", self.stdout, self.stderr));
        assert!(value.is_object());
        value
    }

    /// Standard error with one blank between words: where its lines break depends on the length of paths.
    pub fn said(&self) -> String {
        self.stderr.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The error object, of exit status 2.
    pub fn error(&self) -> serde_json::Value {
        assert_eq!(self.status, 2, "stdout {} stderr {}", self.stdout, self.stderr);
        let error = self.json()["error"].clone();
        for key in ["file", "line", "column", "message"] {
            assert!(error.get(key).is_some(), "no {key} in {error}");
        }
        error
    }
}

/// Runs the command with these arguments.
pub fn ironout<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Run {
    let Output { status, stdout, stderr } =
        Command::new(env!("CARGO_BIN_EXE_ironout")).args(arguments).output().expect("the command starts");
    Run {
        status: status.code().expect("ends by itself"),
        stdout: String::from_utf8(stdout).expect("text"),
        stderr: String::from_utf8(stderr).expect("text"),
    }
}

/// A folder of the test's own, empty.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("a folder for the test");
    path
}

/// Writes a file.
pub fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, content).expect("a file for the test");
    path
}

/// A real recording, or `None` (and a word about it) where the recordings are not at hand.
pub fn recording(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    // Written directly: the test harness swallows eprintln!.
    let _ = writeln!(std::io::stderr(), "SKIPPED: the recording {name} is not here");
    None
}

/// A small log with the shape of a public complaint, or `None` (and a word about it) where they are not at hand.
pub fn case(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/cases")).join(name);
    if path.exists() {
        return Some(path);
    }
    let _ = writeln!(std::io::stderr(), "SKIPPED: the case {name} is not here");
    None
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

/// Simulates a log in a folder.
pub fn simulate(here: &Path, name: &str, options: &[&str]) -> PathBuf {
    let log = here.join(name);
    let run = ironout(["simulate", "-o", text(&log)].iter().chain(options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    log
}

/// The log with its rows changed: cells by the names of their columns.
pub fn changed(
    here: &Path,
    log: &Path,
    name: &str,
    change: impl Fn(&dyn Fn(&str) -> usize, &mut Vec<f64>),
) -> PathBuf {
    let content = std::fs::read_to_string(log).expect("text");
    let mut lines = content.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header").to_string();
    let names: Vec<String> = header.split(',').map(String::from).collect();
    let place = |name: &str| names.iter().position(|own| own == name).expect("a column");
    let mut out = header.clone() + "\n";
    for line in lines {
        let mut cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        change(&place, &mut cells);
        let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:.5}")).collect();
        out += &(cells.join(",") + "\n");
    }
    write(here, name, out)
}

/// The calibration of a log that is accepted.
pub fn calibrate(here: &Path, log: &Path, options: &[&str]) -> PathBuf {
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(log), "-o", text(&cal)].iter().chain(options));
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    cal
}
