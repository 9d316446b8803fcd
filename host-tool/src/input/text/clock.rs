//! Dates and times of day as seconds.

use jiff::Timestamp;
use jiff::civil::DateTime;

/// Seconds in a day.
pub const DAY_S: f64 = 86_400.0;

/// ISO 8601 (with or without a zone; a blank for the T; a comma for the point) as seconds since 1970, or a time of day
/// (`12:34:56.789`, `12:34:56:789`, `12:34:56`) as seconds since midnight. A date without a zone is taken as UTC: only differences
/// of it are used.
pub fn seconds(text: &[u8]) -> Option<f64> {
    let text = text.trim_ascii();
    if !(8..=40).contains(&text.len()) || !text.first().is_some_and(u8::is_ascii_alphanumeric) {
        return None;
    }
    let text = std::str::from_utf8(text).ok()?;
    if let Some(time) = of_day(text) {
        return Some(time);
    }
    if !text.contains(':') {
        return None;
    }
    if let Some(time) = written_out(text) {
        return Some(time);
    }
    if !text.contains('-') && !text.contains('/') {
        return None;
    }
    let mut iso = text.replacen(' ', "T", 1).replace(',', ".").replace(['/'], "-");
    // Milliseconds after a third colon, as some telephones write them.
    if let Some(time) = iso.find('T').and_then(|at| iso.get(at..))
        && time.matches(':').count() == 3
        && !time.contains('+')
        && let Some(last) = iso.rfind(':')
    {
        iso.replace_range(last..=last, ".");
    }
    if let Ok(stamp) = iso.parse::<Timestamp>() {
        return Some(exact(stamp));
    }
    let civil: DateTime = iso.parse().ok()?;
    civil.to_zoned(jiff::tz::TimeZone::UTC).ok().map(|zoned| exact(zoned.timestamp()))
}

/// Months as their first three letters begin them.
const MONTHS: [&str; 12] =
    ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];

/// A date with the month by its name, with the day in front, or of a clock of twelve hours, as seconds since 1970:
/// `22-May-2021 11:42:54.147`, `May 22, 2021 11:42:54 PM`, `Sat May 22 11:42:54 2021`, `22.05.2021 11:42:54`. Of two numbers that can both
/// be the month, the first is: only differences are used.
fn written_out(text: &str) -> Option<f64> {
    let (mut month, mut year, mut days, mut time, mut afternoon) = (None, None, Vec::new(), None, None);
    // A T between two digits stands for a blank; that of a day of the week or a month does not.
    let bytes = text.as_bytes();
    let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    let between = |at: usize| bytes[at] == b'T' && at > 0 && is_digit(at - 1) && is_digit(at + 1);
    let parts = (0..text.len()).filter(|&at| matches!(bytes[at], b' ' | b',') || between(at));
    let ends = parts.chain([text.len()]);
    let parts = ends.scan(0, |from, at| {
        let part = text.get(*from..at);
        *from = at + 1;
        Some(part.unwrap_or_default())
    });
    for part in parts.filter(|part| !part.is_empty()) {
        if part.contains(':') && time.is_none() {
            // `22/May/2021:11:42:54`.
            let clock = match part.split_once(':') {
                Some((date, clock)) if date.contains(['/', '-']) => {
                    date_parts(date, &mut month, &mut year, &mut days)?;
                    clock
                }
                _ => part,
            };
            time = Some(of_day(clock)?);
            continue;
        }
        match part.to_ascii_lowercase().trim_matches('.') {
            "am" => afternoon = Some(false),
            "pm" => afternoon = Some(true),
            "utc" | "gmt" | "z" | "+0000" | "mon" | "tue" | "wed" | "thu" | "fri" | "sat" | "sun" => {}
            _ => date_parts(part, &mut month, &mut year, &mut days)?,
        }
    }
    let time = time?;
    let time = match afternoon {
        None => time,
        Some(after) if time < 13.0 * 3600.0 => time % (0.5 * DAY_S) + if after { 0.5 * DAY_S } else { 0.0 },
        Some(_) => return None,
    };
    let (month, day, year) = match (month, year, days.as_slice()) {
        (Some(month), Some(year), [day]) => (month, *day, year),
        (None, Some(year), [first, second]) if *first > 12 => (*second, *first, year),
        (None, Some(year), [first, second]) => (*first, *second, year),
        // A clock of twelve hours without a date.
        (None, None, []) if afternoon.is_some() => return Some(time),
        _ => return None,
    };
    let date =
        jiff::civil::Date::new(i16::try_from(year).ok()?, i8::try_from(month).ok()?, i8::try_from(day).ok()?)
            .ok()?;
    let midnight = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?;
    Some(exact(midnight.timestamp()) + time)
}

/// The parts of a date; `None` for what is neither a number nor a month.
fn date_parts(
    text: &str,
    month: &mut Option<u32>,
    year: &mut Option<u32>,
    days: &mut Vec<u32>,
) -> Option<()> {
    for part in text.split(['-', '/', '.']).filter(|part| !part.is_empty()) {
        if let Ok(number) = part.parse::<u32>() {
            match number {
                1..=31 if part.len() <= 2 => days.push(number),
                1900..=2200 if part.len() == 4 => *year = Some(number),
                _ => return None,
            }
            continue;
        }
        let lower = part.to_ascii_lowercase();
        let place = MONTHS.iter().position(|name| lower.get(..3) == Some(*name))?;
        *month = u32::try_from(place + 1).ok();
    }
    Some(())
}

fn exact(stamp: Timestamp) -> f64 {
    stamp.as_second() as f64 + f64::from(stamp.subsec_nanosecond()) / 1e9
}

/// `H:MM:SS` with an optional fraction after a point, a comma or a colon.
fn of_day(text: &str) -> Option<f64> {
    let mut parts = text.splitn(3, ':');
    let whole = |part: &str, most: u32| {
        let short = !part.is_empty() && part.len() <= 2 && part.bytes().all(|b| b.is_ascii_digit());
        short.then(|| part.parse::<u32>().ok()).flatten().filter(|value| *value <= most)
    };
    let hours = whole(parts.next()?, 23)?;
    let minutes = whole(parts.next()?, 59)?;
    let rest = parts.next()?;
    let split = rest.find(['.', ',', ':']);
    let seconds = whole(split.map_or(rest, |at| &rest[..at]), 60)?;
    let fraction = match split.and_then(|at| rest.get(at + 1..)) {
        None => 0.0,
        Some(digits) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => {
            format!("0.{digits}").parse().ok()?
        }
        // Zephyr writes 01.234,000.
        Some(digits) => match digits.split_once(',') {
            Some((ms, us)) if [ms, us].iter().all(|p| p.bytes().all(|b| b.is_ascii_digit())) => {
                format!("0.{ms}{us}").parse().ok()?
            }
            _ => return None,
        },
    };
    Some(f64::from(hours * 3600 + minutes * 60 + seconds) + fraction)
}

#[cfg(test)]
mod tests {
    use super::{DAY_S, seconds};

    #[test]
    fn dates_and_times() {
        for (text, expected) in [
            ("1970-01-01T00:00:10Z", 10.0),
            ("1970-01-01T01:00:10+01:00", 10.0),
            ("1970-01-01 00:00:10.25", 10.25),
            ("1970-01-01 00:00:10,25", 10.25),
            ("1970/01/01 00:00:10", 10.0),
            ("1970-01-01 00:00:10:250", 10.25),
            ("00:01:02.5", 62.5),
            ("00:01:02:500", 62.5),
            ("23:59:59", 86_399.0),
            ("00:00:01.234,500", 1.2345),
            ("01-Jan-1970 00:00:10.25", 10.25),
            ("1-January-1970 00:00:10", 10.0),
            ("Jan 1, 1970 12:00:10 AM", 10.0),
            ("Thu Jan 1 00:00:10 1970", 10.0),
            ("01/Jan/1970:00:00:10", 10.0),
            ("02.01.1970 00:00:10", 31.0 * DAY_S + 10.0),
            ("13.01.1970 00:00:10", 12.0 * DAY_S + 10.0),
            ("01/13/1970 01:00:10 PM", 12.0 * DAY_S + 13.0 * 3600.0 + 10.0),
            ("01:00:10 PM", 13.0 * 3600.0 + 10.0),
        ] {
            let value = seconds(text.as_bytes()).unwrap_or_else(|| panic!("{text}"));
            assert!((value - expected).abs() < 1e-9, "{text}: {value}");
        }
        for text in [
            "",
            "12",
            "12:34",
            "25:00:00",
            "1.5",
            "hello:wo:rl",
            "12:34:5x",
            "1970-13-41T00:00:00Z",
            "12345678",
            "Mag: 12:00:00",
            "X: 1 Y: 2 Z: 3",
            "01-Foo-1970 00:00:10",
        ] {
            assert_eq!(seconds(text.as_bytes()), None, "{text}");
        }
    }
}
