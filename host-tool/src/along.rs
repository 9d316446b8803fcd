//! The field of the Earth along the way of a log, which tells where it was: from the world magnetic model.

use crate::failure::{Failure, Outcome};
use crate::geomag::{Day, EarthField, YEARS, day, day_of_epoch};
use crate::input::Log;
use ironout_analysis::samples::samples::filled;
use ironout_analysis::track::Track;

/// Names of a height, m.
const HEIGHTS: [&str; 4] = ["height_m", "gps_height_m", "alt_m", "altitude_m"];
/// The model is asked again after this many degrees …
const STEP_DEG: f64 = 1e-3;
/// … or this many metres of height: either is half a nanotesla.
const STEP_M: f64 = 20.0;
/// A log that tells where it was in a smaller share of its rows does not tell it.
const KNOWN: f64 = 0.5;
/// The day that is asked for where a log tells none.
const ASSUMED: &str = "2026-01-01";

/// Gives the log the field of each row's place, if it has `lat_deg` and `lon_deg`; says so where that changes along the way. `date` is
/// `--date`.
///
/// # Errors
/// A date that is none, or that the model does not cover.
pub fn know(log: &mut Log, date: Option<&str>) -> Outcome<()> {
    let asked = date.map(given).transpose()?;
    let column = |name: &str| {
        let column = log.covariate(name).filter(|column| column.not_finite == 0)?;
        Some((column.name.clone(), column.values.as_slice()))
    };
    let (Some((_, latitude)), Some((_, longitude))) = (column("lat_deg"), column("lon_deg")) else {
        return Ok(());
    };
    let height = HEIGHTS.into_iter().find_map(column);
    let by_clock = || log.time_s.as_ref().and_then(|time| day_of_epoch(*time.first()?));
    let (on, words) = match (asked, by_clock()) {
        (Some(on), _) => (on, "as given".to_string()),
        (None, Some(on)) => (on, "by its times".to_string()),
        (None, None) => {
            (given(ASSUMED)?, "assumed, for the log tells no date: --date YYYY-MM-DD gives it".to_string())
        }
    };
    let mut field = vec![f64::NAN; log.rows];
    let mut dip = vec![f64::NAN; log.rows];
    let mut last: Option<([f64; 3], EarthField)> = None;
    let mut known = 0;
    for row in 0..log.rows {
        let (north, east) = (latitude[row], longitude[row]);
        // Receivers write zeros as long as they do not know.
        let nowhere = north == 0.0 && east == 0.0;
        if nowhere || !(north.abs() <= 90.0 && east.abs() <= 360.0) {
            continue;
        }
        let up = height.as_ref().map_or(0.0, |(_, height)| height[row]);
        let at = [north, east, if up.is_finite() { up.clamp(-900.0, 800_000.0) } else { 0.0 }];
        let near = |before: &[f64; 3]| {
            (before[0] - at[0]).abs() < STEP_DEG
                && (before[1] - at[1]).abs() < STEP_DEG
                && (before[2] - at[2]).abs() < STEP_M
        };
        let earth = match &last {
            Some((before, earth)) if near(before) => *earth,
            _ => match EarthField::over(at[0], at[1], at[2], on) {
                Ok(earth) => earth,
                Err(_) => continue,
            },
        };
        if !last.as_ref().is_some_and(|(before, _)| near(before)) {
            last = Some((at, earth));
        }
        (field[row], dip[row]) = (earth.field_ut, earth.dip_deg);
        known += 1;
    }
    if (known as f64) < KNOWN * log.rows as f64 {
        if known > 0 {
            log.notices.push(format!(
                "lat_deg and lon_deg tell a place in {known} of {} rows only: the field is taken as one along the way",
                log.rows
            ));
        }
        return Ok(());
    }
    let (Some(field), Some(dip)) = (filled(&field), filled(&dip)) else { return Ok(()) };
    let of = match &height {
        Some((name, _)) => format!("lat_deg, lon_deg and {name}"),
        None => "lat_deg and lon_deg (at height 0)".to_string(),
    };
    log.earth = Some([field, dip]);
    if let Some(words) = travels(log, &format!("by {of} and the world magnetic model of {on}, {words}")) {
        log.read_as.reasons.push(words.clone());
        log.notices.push(words);
    }
    Ok(())
}

fn given(text: &str) -> Outcome<Day> {
    let form = || {
        Failure::usage(format!("--date {text}: expected YYYY-MM-DD, from {YEARS}, as in --date 2026-03-01"))
    };
    day(text).filter(|on| EarthField::over(0.0, 0.0, 0.0, *on).is_ok()).ok_or_else(form)
}

/// What is said of a log along whose way the field changes.
pub fn travels(log: &Log, source: &str) -> Option<String> {
    let [field, dip] = log.earth.as_ref()?;
    let [least, most] = Track::of(field, dip)?.range_ut;
    Some(format!(
        "the field of the Earth is {least:.2} to {most:.2} µT along the way ({source}); each place is held against its own, so that \
         travelling is no effect"
    ))
}
