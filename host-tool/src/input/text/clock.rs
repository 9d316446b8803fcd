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
    if !(8..=40).contains(&text.len()) || !text.first().is_some_and(u8::is_ascii_digit) {
        return None;
    }
    let text = std::str::from_utf8(text).ok()?;
    if let Some(time) = of_day(text) {
        return Some(time);
    }
    if !text.contains('-') && !text.contains('/') || !text.contains(':') {
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
    use super::seconds;

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
        ] {
            assert_eq!(seconds(text.as_bytes()), None, "{text}");
        }
    }
}
