//! Headings that the user knows, and the course of a GPS receiver, as an attitude of the log.

use crate::failure::{Failure, Outcome};
use crate::input::formats::GROUND;
use crate::input::{Covariate, Log};
use crate::wrap;
use ironout_analysis::Table;
use ironout_analysis::confined::guided::{Deviation, KnownHeading, attitude, deviation, of_course};
use ironout_analysis::table::ATTITUDE;

/// Columns of a GPS receiver in a CSV: its course, its speed, and the error of its speed.
const COLUMNS: [&str; 3] = ["speed_mps", "course_deg", "speed_accuracy_mps"];

/// Reads the `T=DEG` of `--heading`.
///
/// # Errors
/// What is expected, in words.
pub fn known_heading(text: &str) -> Result<KnownHeading, String> {
    let numbers = text.split_once('=').and_then(|(t, deg)| Some((number(t)?, number(deg)?)));
    match numbers {
        Some((time_s, heading_deg)) if (-360.0..=360.0).contains(&heading_deg) => {
            Ok(KnownHeading { time_s, heading_deg })
        }
        _ => {
            Err("expected T=DEG: a time of the log in s, and the true heading then in degrees, as in 12.5=90"
                .into())
        }
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}

/// Gives the log an attitude from these headings, or from the course of its receiver if it has no attitude of its own.
///
/// # Errors
/// Headings that cannot be used.
pub fn guide(log: &mut Log, given: &[KnownHeading]) -> Outcome<()> {
    let table = Table::from(&*log);
    let column = |name: &str| log.covariate(name).map(|column| column.values.as_slice());
    let course = |[speed, course, error]: [&str; 3]| {
        Some(of_course(&table, column(course)?, column(speed)?, column(error)))
    };
    let known = if !given.is_empty() {
        given.to_vec()
    } else if table.attitude.is_none() {
        match course(GROUND).or_else(|| course(COLUMNS)) {
            Some(known) => known,
            None => return Ok(()),
        }
    } else {
        // The autopilot's own attitude, unless the course of its wheels contradicts it.
        let Some(mut known) = course(GROUND) else { return Ok(()) };
        let Some(Deviation { amplitude_deg, error_deg }) = deviation(&table, &mut known) else {
            return Ok(());
        };
        tell(
            log,
            &format!(
                "the logged yaw differs from the GPS course by up to {amplitude_deg:.0}° ± {error_deg:.1}°, depending on the heading, as a \
             compass error does"
            ),
        );
        known
    };
    let Some(columns) = attitude(&table, &known) else {
        if given.is_empty() {
            return Ok(());
        }
        return Err(Failure::usage(
            "--heading needs a time within the log, an accelerometer and a gyro. Fix: give the time in seconds of the log",
        )
        .in_file(&log.path));
    };
    log.covariates.retain(|column| !ATTITUDE.contains(&column.name.as_str()));
    log.read_as.columns.retain(|column| !ATTITUDE.contains(&column.name.as_str()));
    for (name, values) in ATTITUDE.into_iter().zip(columns) {
        let not_finite = 0;
        log.covariates.push(Covariate { name: name.into(), values, empty: 0, not_finite });
    }
    let count = known.len();
    let of = match (given.is_empty(), count) {
        (true, 1) => "stretch of straight driving (GPS course)",
        (true, _) => "stretches of straight driving (GPS course)",
        (false, 1) => "known heading",
        (false, _) => "known headings",
    };
    tell(log, &format!("the yaw comes from {count} {of} and the gyro"));
    Ok(())
}

fn tell(log: &Log, what: &str) {
    let notice = format!("note: {}: {what}", log.path.display());
    eprintln!("{}", wrap::message(&notice, wrap::WIDTH));
}
