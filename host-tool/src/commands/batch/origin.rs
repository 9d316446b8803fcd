//! Which vehicle and sensor a log is of, and when it began.

use crate::commands::batch::files::Found;
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use std::path::Path;

/// Times of a log from which on they are seconds since 1970 and no time since a start (the year 2000).
const FIRST_EPOCH_S: f64 = 946_684_800.0;
const LAST_EPOCH_S: f64 = 4_102_444_800.0;

/// Where a log is from, as far as anything says.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct From {
    pub vehicle: String,
    pub sensor: String,
    /// Start in UTC, and what says so: `log`, `name` or `file`.
    pub start: Option<(Timestamp, &'static str)>,
}

/// The pattern of `--vehicle-from`, checked.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pattern {
    /// Part by part of the path, in order; each as pieces of text and names.
    parts: Vec<Vec<Piece>>,
}

#[derive(Debug, Clone, PartialEq)]
enum Piece {
    Text(String),
    Any,
    Vehicle,
    Sensor,
}

impl Pattern {
    /// Reads a pattern.
    pub fn parse(text: &str) -> Outcome<Self> {
        let wrong = || {
            Failure::usage(format!(
                "--vehicle-from {text}: expected the last parts of a path with {{vehicle}} in it, and {{sensor}} and * as needed, as in \
                 --vehicle-from '{{vehicle}}/*' or '{{vehicle}}_{{sensor}}_*.csv'"
            ))
        };
        let mut parts = Vec::new();
        for part in text.split('/') {
            let (mut pieces, mut rest) = (Vec::new(), part);
            while let Some(first) = rest.chars().next() {
                let (piece, length) = if rest.starts_with("{vehicle}") {
                    (Piece::Vehicle, 9)
                } else if rest.starts_with("{sensor}") {
                    (Piece::Sensor, 8)
                } else if first == '*' {
                    (Piece::Any, 1)
                } else if first == '{' || first == '}' {
                    return Err(wrong());
                } else {
                    let end = rest.find(['*', '{', '}']).unwrap_or(rest.len());
                    (Piece::Text(rest[..end].to_string()), end)
                };
                pieces.push(piece);
                rest = &rest[length..];
            }
            parts.push(pieces);
        }
        let named = parts.iter().flatten().filter(|piece| **piece == Piece::Vehicle).count();
        if named == 1 { Ok(Pattern { parts }) } else { Err(wrong()) }
    }

    /// Vehicle and sensor of a path; `None` if the path is not as the pattern says.
    fn read(&self, path: &Path) -> Option<(String, String)> {
        let names: Vec<String> =
            path.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        let last = names.len().checked_sub(self.parts.len())?;
        let mut read = (String::new(), String::new());
        for (pieces, name) in self.parts.iter().zip(&names[last..]) {
            if !take(pieces, name, &mut read) {
                return None;
            }
        }
        Some(read)
    }
}

/// Whether a name is as the pieces say; names take as little as they can.
fn take(pieces: &[Piece], name: &str, read: &mut (String, String)) -> bool {
    let Some((piece, rest)) = pieces.split_first() else { return name.is_empty() };
    if let Piece::Text(text) = piece {
        return name.strip_prefix(text.as_str()).is_some_and(|left| take(rest, left, read));
    }
    let least = usize::from(*piece != Piece::Any);
    let ends = name.char_indices().map(|(at, _)| at).chain([name.len()]).filter(|end| *end >= least);
    for end in ends {
        if take(rest, &name[end..], read) {
            match piece {
                Piece::Vehicle => read.0 = name[..end].to_string(),
                Piece::Sensor => read.1 = name[..end].to_string(),
                _ => {}
            }
            return true;
        }
    }
    false
}

/// Where a log is from: by itself, else by its path. `log` is `None` for one that cannot be read.
pub(super) fn origin(found: &Found, log: Option<&Log>, pattern: Option<&Pattern>) -> From {
    let said = log.map(|log| log.read_as.origin.clone()).unwrap_or_default();
    let path = found.path.canonicalize().unwrap_or_else(|_| found.path.clone());
    let (vehicle, sensor) = match pattern {
        Some(pattern) => pattern.read(&path).unwrap_or_default(),
        None => (folder(&found.below), String::new()),
    };
    // With several sensors in a log its number tells them apart.
    let number =
        log.and_then(|log| log.read_as.instance.as_ref()).map(|one| format!("instance {}", one.taken));
    let own_sensor = if sensor.is_empty() { number.unwrap_or_default() } else { sensor };
    From {
        vehicle: said.vehicle.unwrap_or(vehicle),
        sensor: said.sensor.unwrap_or(own_sensor),
        start: start(found, log, said.start.as_deref()),
    }
}

/// The first folder below the one that was named.
fn folder(below: &Path) -> String {
    let mut parts = below.components().map(|part| part.as_os_str().to_string_lossy().into_owned());
    match (parts.next(), parts.next()) {
        (Some(folder), Some(_)) => folder,
        _ => String::new(),
    }
}

fn start(found: &Found, log: Option<&Log>, said: Option<&str>) -> Option<(Timestamp, &'static str)> {
    let by_clock = || {
        let first = *log?.time_s.as_ref()?.first()?;
        (FIRST_EPOCH_S..LAST_EPOCH_S).contains(&first).then(|| Timestamp::from_second(first as i64).ok())?
    };
    let by_file = || {
        let changed = std::fs::metadata(&found.path).ok()?.modified().ok()?;
        Timestamp::try_from(changed).ok()
    };
    said.and_then(instant)
        .or_else(by_clock)
        .map(|start| (start, "log"))
        .or_else(|| Some((in_path(&found.path)?, "name")))
        .or_else(|| Some((by_file()?, "file")))
}

/// A time as ISO 8601 has it; without a zone it is UTC.
fn instant(text: &str) -> Option<Timestamp> {
    let iso = text.replacen(' ', "T", 1);
    if let Ok(instant) = iso.parse::<Timestamp>() {
        return Some(instant);
    }
    let civil =
        iso.parse::<DateTime>().ok().or_else(|| Some(iso.parse::<jiff::civil::Date>().ok()?.into()))?;
    civil.to_zoned(TimeZone::UTC).ok().map(|zoned| zoned.timestamp())
}

/// The date in the name of a file or of its folder, with the time of day if one follows: `2026-03-01/10_11_12.ulg`, `20260301-101112`.
fn in_path(path: &Path) -> Option<Timestamp> {
    let mut names: Vec<String> =
        path.components().rev().take(2).map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    names.reverse();
    let whole = names.join("/");
    // Runs of digits with where they begin and end.
    let mut runs: Vec<(usize, usize, &str)> = Vec::new();
    let mut begin = None;
    for (at, is_digit) in
        whole.char_indices().map(|(at, one)| (at, one.is_ascii_digit())).chain([(whole.len(), false)])
    {
        match (begin, is_digit) {
            (None, true) => begin = Some(at),
            (Some(from), false) => {
                runs.push((from, at, &whole[from..at]));
                begin = None;
            }
            _ => {}
        }
    }
    let is_close = |one: (usize, usize, &str), next: (usize, usize, &str)| next.0 == one.1 + 1;
    let number = |text: &str| text.parse::<i16>().ok();
    let mut last = None;
    for (index, run) in runs.iter().enumerate() {
        let next = |step: usize| runs.get(index + step).copied();
        let (ymd, used) = match (run.2.len(), next(1), next(2)) {
            (8, _, _) => ((number(&run.2[..4]), number(&run.2[4..6]), number(&run.2[6..])), 1),
            (4, Some(month), Some(day))
                if month.2.len() == 2
                    && day.2.len() == 2
                    && is_close(*run, month)
                    && is_close(month, day) =>
            {
                ((number(run.2), number(month.2), number(day.2)), 3)
            }
            _ => continue,
        };
        let (Some(year @ 1990..=2099), Some(month), Some(day)) = ymd else { continue };
        let (Ok(month), Ok(day)) = (i8::try_from(month), i8::try_from(day)) else { continue };
        let Ok(date) = jiff::civil::Date::new(year, month, day) else { continue };
        let before = next(used - 1).unwrap_or(*run);
        let time = next(used).filter(|one| is_close(before, *one)).and_then(|first| {
            let digits = match first.2.len() {
                6 | 4 => first.2.to_string(),
                2 => {
                    let minute = next(used + 1).filter(|one| one.2.len() == 2 && is_close(first, *one))?;
                    let second = next(used + 2).filter(|one| one.2.len() == 2 && is_close(minute, *one));
                    [first.2, minute.2, second.map_or("00", |one| one.2)].concat()
                }
                _ => return None,
            };
            let part = |at: usize| digits.get(at..at + 2).map_or(Some(0), |text| text.parse::<i8>().ok());
            jiff::civil::Time::new(part(0)?, part(2)?, part(4)?, 0).ok()
        });
        last = Some(date.to_datetime(time.unwrap_or(jiff::civil::Time::midnight())));
    }
    last?.to_zoned(TimeZone::UTC).ok().map(|zoned| zoned.timestamp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_tells_when_and_what() {
        for (path, start) in [
            ("log/2026-03-01/10_11_12.ulg", Some("2026-03-01T10:11:12Z")),
            ("v07/flight_20260301-101112.csv", Some("2026-03-01T10:11:12Z")),
            ("v07/2026-03-01.csv", Some("2026-03-01T00:00:00Z")),
            ("v07/2026-13-01.csv", None),
            ("v07/00000012.BIN", None),
            ("v07/log12.csv", None),
        ] {
            assert_eq!(in_path(Path::new(path)).map(|start| start.to_string()).as_deref(), start, "{path}");
        }
        let read = |pattern: &str, path: &str| Pattern::parse(pattern).expect(pattern).read(Path::new(path));
        let both = |vehicle: &str, sensor: &str| Some((vehicle.to_string(), sensor.to_string()));
        assert_eq!(read("{vehicle}/*", "/logs/v07/a.csv"), both("v07", ""));
        assert_eq!(read("{vehicle}_{sensor}_*.csv", "/logs/v07_m2_003.csv"), both("v07", "m2"));
        assert_eq!(read("{vehicle}/{sensor}/*.csv", "/logs/v07/m1/a.ulg"), None);
        for wrong in ["*.csv", "{vehicle}/{vehicle}", "{ship}/*", ""] {
            assert!(Pattern::parse(wrong).is_err(), "{wrong}");
        }
    }
}
