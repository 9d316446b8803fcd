//! Tables held to their snapshots.

use std::io;
use std::path::Path;

/// Decimals may differ by this much: another host's sine differs in the last bit, and a sum of a thousand follows.
const TOLERANCE: f64 = 0.01;

/// Holds `text` to the snapshot at `path`.
///
/// # Errors
/// The snapshot cannot be read, or lines of it differ: then the message has them.
pub fn hold(path: &Path, text: &str) -> io::Result<()> {
    let at = |error: String| io::Error::other(format!("{}: {error}", path.display()));
    let stored = std::fs::read_to_string(path).map_err(|error| at(error.to_string()))?;
    let found = differences(&stored, text);
    if found.is_empty() {
        Ok(())
    } else {
        Err(at(format!("{} lines differ\n{}", found.len(), found.join("\n"))))
    }
}

/// The lines that differ, old under a minus and new under a plus. Words, whole numbers and percentages are held exactly;
/// decimals to one in a hundred, or to one of their last digit.
pub fn differences(stored: &str, text: &str) -> Vec<String> {
    let (mut old, mut new) = (stored.lines(), text.lines());
    let mut found = vec![];
    loop {
        match (old.next(), new.next()) {
            (None, None) => return found,
            (old, new) if old.zip(new).is_some_and(|(a, b)| alike(a, b)) => {}
            (old, new) => {
                found.push(format!("- {}\n+ {}", old.unwrap_or_default(), new.unwrap_or_default()));
            }
        }
    }
}

fn alike(a: &str, b: &str) -> bool {
    let (mut a, mut b) = (a.split_whitespace(), b.split_whitespace());
    loop {
        match (a.next(), b.next()) {
            (None, None) => return true,
            (Some(a), Some(b)) if a == b || close(a, b) => {}
            _ => return false,
        }
    }
}

fn close(a: &str, b: &str) -> bool {
    let decimals = |word: &str| word.split_once('.').map(|(_, rest)| rest.trim_end_matches('*').len());
    let number = |word: &str| word.trim_end_matches('*').parse::<f64>().ok();
    let (Some(places), Some(x), Some(y)) = (decimals(a), number(a), number(b)) else { return false };
    // Half a unit more than one of the last digit, for the rounding of the comparison itself.
    let step = 1.5 * 10f64.powi(-(places as i32));
    decimals(b) == Some(places)
        && a.ends_with('*') == b.ends_with('*')
        && (x - y).abs() <= step.max(TOLERANCE * x.abs())
}
