//! Words and tables on standard output.

use crate::failure::{Failure, Outcome};
use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

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
    note(writeln!(io::stdout(), "{text}"));
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

/// Several lines on standard output, each with its end.
pub fn text(text: &str) {
    note(write!(io::stdout(), "{text}"));
}

/// Breaks text into lines of at most `width` characters, each after `indent`.
pub fn wrap(text: &str, indent: &str, width: usize) -> Vec<String> {
    hang(text, indent, indent, width)
}

/// The same with another indent from the second line on.
pub fn hang(text: &str, first: &str, rest: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let indent = if lines.is_empty() { first } else { rest };
        let length = indent.chars().count() + line.chars().count() + 1 + word.chars().count();
        if !line.is_empty() && length > width {
            lines.push(format!("{indent}{line}"));
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    if !line.is_empty() {
        lines.push(format!("{}{line}", if lines.is_empty() { first } else { rest }));
    }
    lines
}
