//! What a serial monitor or a logger writes before each line: taken off, its time kept.

use crate::input::text::clock;
use std::borrow::Cow;

/// A line without its prefix.
#[derive(Debug, Clone, PartialEq)]
pub struct Bare<'a> {
    /// What the board said.
    pub text: Cow<'a, str>,
    /// The monitor's time, in seconds; of day where it is a time of day.
    pub time_s: Option<f64>,
}

/// Takes colours and the prefix off a line: `12:34:56.789 -> `, `[12:34:56.789] `, `2026-01-02 12:34:56.789 > `,
/// `[00:00:01.234,000] <inf> main: `, `I (1234) main: `.
///
/// Also off go `[INFO] [1700000000.02] [node]: `, the checksum of an NMEA sentence, and brackets around a whole line.
pub fn bare(line: &str) -> Bare<'_> {
    let text = without_colours(line.trim_end_matches('\r'));
    if let Some(inner) = unwrapped(&text) {
        return Bare { text: Cow::Owned(inner.to_string()), time_s: None };
    }
    let found = stamped(&text)
        .or_else(|| espressif(&text))
        .or_else(|| ros(&text))
        .map(|(time_s, rest)| (time_s, rest.to_string()));
    match found {
        Some((time_s, rest)) => Bare { text: Cow::Owned(rest), time_s: Some(time_s) },
        None => Bare { text, time_s: None },
    }
}

fn without_colours(line: &str) -> Cow<'_, str> {
    if !line.contains('\u{1b}') {
        return Cow::Borrowed(line);
    }
    let mut out = String::with_capacity(line.len());
    let mut rest = line;
    while let Some(at) = rest.find('\u{1b}') {
        out.push_str(&rest[..at]);
        let tail = &rest[at + 1..];
        rest = match tail.strip_prefix('[') {
            Some(code) => {
                code.find(|c: char| c.is_ascii_alphabetic()).and_then(|end| code.get(end + 1..)).unwrap_or("")
            }
            None => tail,
        };
    }
    out.push_str(rest);
    Cow::Owned(out)
}

/// A date or time of day, and an arrow, a bracket or a blank after it. A comma after it is a column's.
fn stamped(line: &str) -> Option<(f64, &str)> {
    let line = line.trim_start();
    let (stamp, rest) = match line.strip_prefix('[') {
        Some(inside) => inside.split_once(']')?,
        None => {
            let digits = |c: char| c.is_ascii_digit() || "-:.T/+Z,".contains(c);
            let first = line.find(|c| !digits(c)).unwrap_or(line.len());
            let (head, tail) = line.split_at(first);
            // A date and a time of day with a blank between them.
            match tail.strip_prefix(' ') {
                Some(time) if head.len() == 10 && !head.contains(':') => {
                    let second = time.find(|c| !digits(c)).unwrap_or(time.len());
                    let end = first + 1 + second;
                    (line.get(..end)?, line.get(end..)?)
                }
                _ => (head, tail),
            }
        }
    };
    if stamp.ends_with(',') {
        return None;
    }
    let time_s = clock::seconds(stamp.as_bytes())?;
    // Behind a tab stands the next cell of a table.
    if rest.starts_with('\t') {
        return None;
    }
    let rest = rest.trim_start();
    let arrow = ["->", "=>", ">", "|"].iter().find_map(|arrow| rest.strip_prefix(arrow));
    let rest = match arrow {
        Some(rest) => rest.trim_start(),
        // A stamp with nothing behind it, or a column's separator: no prefix.
        None if rest.is_empty() || rest.starts_with([';', ',']) => return None,
        None => rest,
    };
    let rest = match rest.strip_prefix('<').and_then(|tagged| tagged.split_once("> ")) {
        // Zephyr: the level, and the module before a colon.
        Some((level, said)) if level.len() <= 4 => said.split_once(": ").map_or(said, |(_, said)| said),
        _ => rest,
    };
    Some((time_s, rest))
}

/// `(1, 2, 3)` and `[1, 2, 3]` without the brackets, `$MAG,1,2,3*5A` without the checksum.
fn unwrapped(line: &str) -> Option<&str> {
    let line = line.trim();
    if line.starts_with('$') {
        let (said, sum) = line.rsplit_once('*')?;
        return (sum.len() == 2 && sum.bytes().all(|b| b.is_ascii_hexdigit())).then_some(said);
    }
    let inner = [('(', ')'), ('[', ']')]
        .iter()
        .find_map(|(open, close)| line.strip_prefix(*open)?.strip_suffix(*close))?;
    let plain = inner.bytes().all(|b| b.is_ascii_digit() || b" \t,;.+-eE".contains(&b));
    plain.then_some(inner)
}

/// `[INFO] [1700000000.02] [node]: `, as ROS logs: seconds since 1970.
fn ros(line: &str) -> Option<(f64, &str)> {
    let (level, rest) = line.strip_prefix('[')?.split_once("] [")?;
    let (stamp, rest) = rest.split_once(']')?;
    let level_is_word = level.len() <= 6 && level.bytes().all(|b| b.is_ascii_alphabetic() || b == b' ');
    let digits = stamp.len() <= 24 && stamp.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if !level_is_word || !digits {
        return None;
    }
    let said = rest.split_once(": ").map_or(rest, |(_, said)| said);
    Some((stamp.parse().ok()?, said))
}

/// `I (1234) tag: `, as ESP-IDF logs: milliseconds since the start.
fn espressif(line: &str) -> Option<(f64, &str)> {
    let inside = ["I (", "W (", "E (", "D (", "V ("].iter().find_map(|head| line.strip_prefix(head))?;
    let (ms, rest) = inside.split_once(") ")?;
    if ms.is_empty() || ms.len() > 12 || !ms.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let (_, said) = rest.split_once(": ")?;
    Some((ms.parse::<f64>().ok()? / 1e3, said))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes() {
        for (line, time_s, text) in [
            ("00:00:02.500 -> 1,2,3", Some(2.5), "1,2,3"),
            ("[00:00:02.500] X: 1", Some(2.5), "X: 1"),
            ("1970-01-01 00:00:02.5 > Raw:1", Some(2.5), "Raw:1"),
            ("1970-01-01T00:00:02.5Z 1 2 3", Some(2.5), "1 2 3"),
            ("[00:00:02.500,000] <inf> mag: x=1 y=2", Some(2.5), "x=1 y=2"),
            ("\u{1b}[0;32mI (2500) mag: x=1\u{1b}[0m", Some(2.5), "x=1"),
            ("00:00:02.500,1,2,3", None, "00:00:02.500,1,2,3"),
            ("00:00:02.500;1;2", None, "00:00:02.500;1;2"),
            ("1970-01-01 00:00:02.5\t1\t2", None, "1970-01-01 00:00:02.5\t1\t2"),
            ("1,2,3\r", None, "1,2,3"),
            ("[INFO] [2.5] [imu]: mag=(1, 2, 3)", Some(2.5), "mag=(1, 2, 3)"),
            ("(1.5, -2, 3)", None, "1.5, -2, 3"),
            ("$MAG,1,2,3*5A", None, "$MAG,1,2,3"),
            ("0.5 1 2 3", None, "0.5 1 2 3"),
            ("", None, ""),
            ("\u{1b}[", None, ""),
            ("[", None, "["),
        ] {
            let found = bare(line);
            assert_eq!((found.text.as_ref(), found.time_s), (text, time_s), "{line}");
        }
    }
}
