//! Words and tables on standard output.

use crate::failure::{Failure, Outcome};
use crate::paint;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Standard output carries a file (`-o -`): words go to standard error.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Whether a path stands for standard output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Leaves standard output to the file where `-o -` asks for it there: words go to standard error from now on.
///
/// # Errors
/// With `--json`, whose object wants the same place.
pub fn leave_to(path: Option<&Path>, json: bool) -> Outcome<()> {
    if !path.is_some_and(is_standard) {
        return Ok(());
    }
    if json {
        return Err(Failure::usage(
            "-o - and --json both write to standard output. Name a file with -o, or omit --json",
        ));
    }
    TAKEN.store(true, Ordering::Relaxed);
    Ok(())
}

/// The first thing that went wrong on standard output: an answer that was not delivered must not end as done.
static UNDELIVERED: Mutex<Option<String>> = Mutex::new(None);

/// Remembers a failed write for [`finish`]. A closed pipe (`ironout … | head`) is no failure: the reader has enough.
pub fn note(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        UNDELIVERED.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| error.to_string());
    }
}

/// Whether all that was said arrived; to be asked once, at the end.
///
/// # Errors
/// Standard output could not be written (a full disk).
pub fn finish() -> Outcome<()> {
    note(io::stdout().flush());
    match UNDELIVERED.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) => Err(Failure::usage(format!("cannot write to standard output: {error}"))),
        None => Ok(()),
    }
}

/// One line on standard output.
pub fn line(text: &str) {
    if TAKEN.load(Ordering::Relaxed) {
        eprintln!("{text}");
    } else {
        note(writeln!(io::stdout(), "{text}"));
    }
}

/// `value` with `decimals` places, or a dash where it is unknown.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    match value.filter(|value| value.is_finite()) {
        Some(value) => format!("{value:.decimals$}"),
        None => "-".to_string(),
    }
}

/// A JSON number, or null where it is unknown or not finite.
pub fn json_number(value: Option<f64>) -> serde_json::Value {
    value.filter(|value| value.is_finite()).map_or(serde_json::Value::Null, serde_json::Value::from)
}

/// Several lines on standard output, each with its end; in colour if the terminal shows it and `NO_COLOR` is not set.
pub fn text(text: &str) {
    if TAKEN.load(Ordering::Relaxed) {
        anstream::eprint!("{}", paint::text(text));
        return;
    }
    note(write!(anstream::stdout(), "{}", paint::text(text)));
}
