//! Headings that the user knows, and the course of a GPS receiver, as an attitude of the log.

use crate::failure::{Failure, Outcome};
use crate::input::{Covariate, Log};
use crate::wrap;
use ironout_analysis::Table;
use ironout_analysis::confined::guided::{KnownHeading, attitude, of_course};
use ironout_analysis::table::ATTITUDE;

/// Columns of a GPS receiver in a CSV: its course, its speed, and the error of its speed.
const COURSE: &str = "course_deg";
const SPEED: &str = "speed_mps";
const SPEED_ERROR: &str = "speed_accuracy_mps";

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
    let has_attitude = ATTITUDE.iter().all(|name| log.covariate(name).is_some());
    if given.is_empty() && has_attitude {
        return Ok(());
    }
    let table = Table::from(&*log);
    let column = |name: &str| log.covariate(name).map(|column| column.values.as_slice());
    let known = match (given.is_empty(), column(COURSE), column(SPEED)) {
        (false, ..) => given.to_vec(),
        (true, Some(course), Some(speed)) => of_course(&table, course, speed, column(SPEED_ERROR)),
        _ => return Ok(()),
    };
    let Some(columns) = attitude(&table, &known) else {
        if given.is_empty() {
            return Ok(());
        }
        return Err(Failure::usage(
            "--heading needs a time inside of the log, an accelerometer and a gyro. Fix: check the time, which is that of the log in s",
        )
        .in_file(&log.path));
    };
    log.covariates.retain(|column| !ATTITUDE.contains(&column.name.as_str()));
    for (name, values) in ATTITUDE.into_iter().zip(columns) {
        let not_finite = 0;
        log.covariates.push(Covariate { name: name.into(), values, empty: 0, not_finite });
    }
    let count = known.len();
    let of = match (given.is_empty(), count) {
        (true, 1) => "stretch of straight driving (course_deg)",
        (true, _) => "stretches of straight driving (course_deg)",
        (false, 1) => "known heading",
        (false, _) => "known headings",
    };
    let notice = format!("note: {}: the yaw comes from {count} {of} and the gyro", log.path.display());
    eprintln!("{}", wrap::message(&notice, wrap::WIDTH));
    Ok(())
}
