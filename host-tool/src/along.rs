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
/// A log that does not tell where it was in a larger share of its rows on end does not tell it.
const UNKNOWN: f64 = 0.2;
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
        Some(column.values.as_slice())
    };
    let (Some(latitude), Some(longitude)) = (column("lat_deg"), column("lon_deg")) else {
        return Ok(());
    };
    let height = HEIGHTS.into_iter().find_map(|name| Some((name, filled(column(name)?)?)));
    let by_clock = || log.time_s.as_ref().and_then(|time| day_of_epoch(*time.first()?));
    let (on, words) = match (asked, by_clock()) {
        (Some(on), _) => (on, "as given".to_string()),
        (None, Some(on)) => (on, "by its times".to_string()),
        (None, None) => {
            (given(ASSUMED)?, "assumed, because the log has no date. Use --date YYYY-MM-DD".to_string())
        }
    };
    let mut field = vec![f64::NAN; log.rows];
    let mut dip = vec![f64::NAN; log.rows];
    let mut last: Option<([f64; 3], EarthField)> = None;
    // The last row with a place, and the longest stretch without one.
    let (mut known, mut unknown) = (None, 0);
    for (row, (&north, &east)) in latitude.iter().zip(longitude).enumerate() {
        // Receivers write zeros as long as they do not know.
        let nowhere = north == 0.0 && east == 0.0;
        if nowhere || !(north.abs() <= 90.0 && east.abs() <= 360.0) {
            continue;
        }
        let up = height.as_ref().and_then(|(_, height)| height.get(row)).map_or(0.0, |up| *up);
        let at = [north, east, up.clamp(-900.0, 800_000.0)];
        let near = |before: &[f64; 3]| {
            (before[0] - at[0]).abs() < STEP_DEG
                && (before[1] - at[1]).abs() < STEP_DEG
                && (before[2] - at[2]).abs() < STEP_M
        };
        if !last.as_ref().is_some_and(|(before, _)| near(before)) {
            let Ok(earth) = EarthField::over(at[0], at[1], at[2], on) else { continue };
            last = Some((at, earth));
        }
        let Some((_, earth)) = &last else { continue };
        (field[row], dip[row]) = (earth.field_ut, earth.dip_deg);
        unknown = unknown.max(row - known.map_or(0, |known: usize| known + 1));
        known = Some(row);
    }
    let Some(known) = known else { return Ok(()) };
    unknown = unknown.max(log.rows - 1 - known);
    if unknown as f64 > UNKNOWN * log.rows as f64 {
        log.notices.push(format!(
            "lat_deg and lon_deg are invalid in {unknown} consecutive rows, so ironout assumes a uniform field"
        ));
        return Ok(());
    }
    let (Some(field), Some(dip)) = (filled(&field), filled(&dip)) else { return Ok(()) };
    let of = match &height {
        Some((name, _)) => format!("lat_deg, lon_deg and {name}"),
        None => "lat_deg and lon_deg (at height 0)".to_string(),
    };
    log.earth = Some([field.into_owned(), dip.into_owned()]);
    log.declination_deg = last.map(|(_, earth)| earth.declination_deg);
    if let Some(words) = travels(log, &format!("by {of} and the world magnetic model of {on}, {words}")) {
        // Of the program's own format no reasons are printed.
        if log.read_as.own_csv {
            log.notices.push(words.clone());
        }
        log.read_as.reasons.push(words);
    }
    Ok(())
}

/// Gives the log the field of each row that a reference measured: one column with its magnitude, or three whose norm it is. The columns
/// are no candidates then.
///
/// # Errors
/// A column that is not there or has no value in most rows, another number of columns, a size that is not a field.
pub fn reference(log: &mut Log, columns: &str) -> Outcome<()> {
    let names: Vec<&str> = columns.split(',').map(str::trim).collect();
    let fail = |what: String| Failure::usage(format!("--reference {columns}: {what}"));
    if !matches!(names.len(), 1 | 3) {
        return Err(fail("name one column with the magnitude, or three with a vector".into()));
    }
    let mut squares = vec![0.0; log.rows];
    for name in &names {
        let column = log.covariate(name).ok_or_else(|| {
            let known: Vec<&str> = log.covariates.iter().map(|column| column.name.as_str()).collect();
            fail(format!(
                "the log has no such column; it has {}",
                if known.is_empty() { "none".into() } else { known.join(", ") }
            ))
        })?;
        let values = filled(&column.values).filter(|_| column.not_finite == 0);
        let values = values.ok_or_else(|| fail(format!("{name} does not contain numbers")))?;
        squares.iter_mut().zip(values.iter()).for_each(|(sum, value)| *sum += value * value);
    }
    let field: Vec<f64> = squares.into_iter().map(f64::sqrt).collect();
    let mut sorted = field.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
    let named = |end: &str| names.iter().all(|name| name.to_ascii_lowercase().ends_with(end));
    // Fields that the Earth has, and coils make, in each unit: they are a factor of ten apart at least.
    let (unit, ut) = match median {
        _ if named("_nt") => ("nT", 1e-3),
        _ if named("_ut") => ("µT", 1.0),
        _ if named("_g") || named("_gauss") => ("G", 100.0),
        m if (0.1..1.5).contains(&m) => ("G", 100.0),
        m if (10.0..150.0).contains(&m) => ("µT", 1.0),
        m if (10_000.0..150_000.0).contains(&m) => ("nT", 1e-3),
        m => {
            return Err(fail(format!(
                "its median {m} does not fit the Earth's field in nT, µT or G. Use a name that ends in _nt, _ut or _g, as in --derive 'ref_nt = 1000 * {}'",
                names[0]
            )));
        }
    };
    let field: Vec<f64> = field.iter().map(|value| value * ut).collect();
    let spread = field.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], f| [a.min(*f), b.max(*f)]);
    if !(spread[0] > 0.0) {
        return Err(fail("its magnitude is zero in some rows".into()));
    }
    log.notices.push(format!(
        "{columns} is the true field, {:.3} to {:.3} µT (read as {unit}). ironout compares each row with it, so the scale is absolute",
        spread[0], spread[1]
    ));
    let dip = vec![0.0; log.rows];
    log.earth = Some([field, dip]);
    log.covariates.retain(|column| !names.contains(&column.name.as_str()));
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
        "the Earth's field is {least:.2} to {most:.2} µT along the path ({source}). ironout compares each place with its \
         own field, so travelling is not reported as an effect"
    ))
}
