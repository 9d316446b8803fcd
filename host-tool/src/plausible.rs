//! Whether a log can be what it is read as, before anything is made of it: units, axes and clock.

mod units;

use crate::cal_file::CalFile;
use crate::cli::{LogArgs, quoted, typed_option};
use crate::failure::{Failure, Outcome, Question};
use crate::input::{Log, parse_map};
use crate::plausible::units::{directions, short, unit_question, unit_remedy};
use ironout_analysis::Table;
use ironout_analysis::plausible::causes::heading_is_computed;
use ironout_analysis::plausible::clock::{self, OddClock};
use ironout_analysis::plausible::coarse::{self, Coarse};
use ironout_analysis::plausible::directions::equal_magnitudes;
use ironout_analysis::plausible::field::{self, Evidence, FieldSize};
use ironout_analysis::plausible::gravity::{self, OddGravity};
use ironout_analysis::plausible::turning::{self, OddAxes, OddRate, Whose};
use ironout_analysis::table::is_silent;

/// A field may be this many times another that is known, or this part of it: gains, and another place.
const ALIKE: f64 = 4.0;
/// The true scale of counts is within this factor of the one in the data sheet.
const SCALE_ERROR: f64 = 1.4;
/// Gyro and clock name each other's fault where the gyro's factor is within this of the clock's.
const SAME: f64 = 1.5;

/// What is known of the size of the field, µT as the log should read it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known {
    /// That it is the Earth's.
    Earth,
    /// What `--field` or `--at` says.
    Given(f64),
    /// What the log of a calibration showed.
    Calibrated(f64),
}

impl Known {
    /// From what was said of the field.
    pub fn given(field_ut: Option<f64>) -> Self {
        field_ut.map_or(Known::Earth, Known::Given)
    }

    /// From a calibration: the field before its gains.
    pub fn of(cal: &CalFile) -> Self {
        let Ok(calibration) = cal.calibration() else { return Known::Earth };
        let [[a, b, c], [d, e, f], [g, h, i]] = calibration.matrix;
        let determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
        Known::Calibrated(calibration.field_ut / determinant.abs().cbrt())
    }
}

/// Holds a log against what can be, and leaves out what cannot. What is found goes to the log's notices.
///
/// # Errors
/// A magnetometer or a clock that cannot be in the unit it is read in.
pub fn hold(log: &mut Log, arguments: &LogArgs, known: &Known) -> Outcome<()> {
    for (what, sensor) in [("accelerometer", &mut log.accel_mps2), ("gyro", &mut log.gyro_radps)] {
        if sensor.take_if(|axes| is_silent(axes)).is_some() {
            log.notices.push(format!("ironout ignores the {what}: its columns are always zero"));
        }
    }
    let (clock, size, turning, gravity, computed, coarse) = {
        let table = Table::from(&*log);
        if let Some(magnitude) = equal_magnitudes(&table) {
            return Err(directions(magnitude).in_file(&log.path));
        }
        let computed = heading_is_computed(&table);
        (
            clock::odd(&table),
            field::size(&table),
            turning::judge(&table),
            gravity::odd(&table),
            computed,
            coarse::find(&table),
        )
    };
    if computed {
        log.notices.push(
            "ironout ignores heading_deg: it is computed from this field, so it is not a reference".into(),
        );
        log.heading_deg = None;
    }
    log.notices.extend(coarse.as_ref().map(coarse_words));
    if let Some(size) = size {
        hold_field(log, arguments, known, &size)?;
    }
    let by_clock = match (&clock, &turning.rate) {
        (Some(clock), Some(rate)) => {
            clock.factors.iter().copied().find(|factor| (rate.factor / factor).ln().abs() < SAME.ln())
        }
        _ => None,
    };
    if let Some(clock) = clock {
        hold_clock(log, arguments, &clock, by_clock, turning.rate.as_ref())?;
    }
    if let Some(rate) = turning.rate.filter(|_| by_clock.is_none()) {
        let told = rate_words(log, arguments, &rate);
        log.notices.push(told);
        log.gyro_radps = None;
    }
    if let Some(axes) = turning.axes {
        log.notices.push(axes_words(&axes));
        log.read_as.axes_in_doubt = axes.whose != Whose::Gyro;
        if matches!(axes.whose, Whose::Gyro | Whose::GyroOrAccelerometer | Whose::GyroOrMagnetometer) {
            log.gyro_radps = None;
        }
    }
    if let Some(gravity) = gravity {
        log.notices.push(gravity_words(&gravity));
        if gravity.weightless {
            log.accel_mps2 = None;
        }
    }
    Ok(())
}

fn coarse_words(coarse: &Coarse) -> String {
    format!(
        "the readings change in steps of {} µT, {:.0} % of the field ({} µT): the low byte of the numbers is lost, digits \
         are missing, or the range is far too wide. Fix: log every bit of the sensor, in a range of a few times the field",
        short(coarse.step_ut),
        100.0 * coarse.step_ut / coarse.field_ut,
        short(coarse.field_ut)
    )
}

fn hold_field(log: &mut Log, arguments: &LogArgs, known: &Known, size: &FieldSize) -> Outcome<()> {
    let like = |other: f64| (size.field_ut / other).ln().abs() <= ALIKE.ln();
    let fits = match known {
        _ if !size.contradicts_earth() => true,
        // A scale from a data sheet is nominal.
        _ if log.ut_per_count.is_some()
            && [1.0 / SCALE_ERROR, SCALE_ERROR].into_iter().any(|scale| size.can_be_earth(scale)) =>
        {
            true
        }
        Known::Earth => false,
        Known::Given(field) | Known::Calibrated(field) => like(*field),
    };
    if fits {
        return Ok(());
    }
    let measured = format!(
        "with this unit the field is {}{} µT ({}, {} readings)",
        if size.is_radius() { "" } else { "at least " },
        short(size.field_ut),
        match size.evidence {
            Evidence::Sphere | Evidence::PartOfSphere => "the radius of the sphere that the readings lie on",
            Evidence::Circle => "the radius of the circle that the readings lie on",
            Evidence::Spread => "half their spread",
        },
        size.readings
    );
    let expected = match known {
        Known::Earth => "the Earth's field is 22 to 67 µT everywhere".to_string(),
        Known::Given(field) => format!("--field or --at says {} µT", short(*field)),
        Known::Calibrated(field) => format!("the calibration's log showed {} µT", short(*field)),
    };
    // Counts of an unknown scale, and the field that gives it: this is how a scale is found.
    if let (Known::Given(field), Some(scale)) = (known, log.ut_per_count) {
        let [x, y, z] = scale.map(|scale| short(scale * field / size.field_ut));
        log.notices.push(format!(
            "{measured}, but {expected}. The scale of the counts is probably {x}, {y}, {z} µT per count. The calibration includes this factor"
        ));
        return Ok(());
    }
    let (remedy, question) = match log.ut_per_count {
        Some(scale) => (scale_remedy(&scale, size.field_ut), scale_question()),
        None => (unit_remedy(log, arguments, size), unit_question(log, arguments, size)),
    };
    Err(Failure::usage(format!("{measured}; {expected}. {remedy}")).in_file(&log.path).asking(question))
}

fn scale_question() -> Question {
    Question {
        text: "This scale does not give a field of the Earth. How many µT is one count?".to_string(),
        needs_scale: true,
        ..Question::default()
    }
}

/// For counts: the scale with which the field is one of the Earth's.
fn scale_remedy(scale: &[f64; 3], field_ut: f64) -> String {
    let of = |field: f64| scale.map(|scale| short(scale * field / field_ut)).join(",");
    format!(
        "The scale must be between {} and {} µT per count (see the data sheet and the configured range), for \
         example\n    --ut-per-count {}\nIf the sensor is in an artificial field (a coil), give its strength with --field \
         UT",
        of(22.0),
        of(67.0),
        of(45.0)
    )
}

fn hold_clock(
    log: &mut Log,
    arguments: &LogArgs,
    clock: &OddClock,
    by_gyro: Option<f64>,
    rate: Option<&OddRate>,
) -> Outcome<()> {
    let mut text = format!(
        "with this unit of time the rows are {} s apart, {} s from first to last (median of {} steps)",
        short(clock.step_s),
        short(clock.seconds),
        clock.steps
    );
    if clock.certain {
        text.push_str(", which is implausible for a magnetometer");
    }
    if let (Some(_), Some(rate)) = (by_gyro, rate) {
        text.push_str(&format!(
            ", and in that time the gyro rotates {} times as far as the {}",
            short(1.0 / rate.factor),
            if rate.by_field { "field" } else { "accelerometer" }
        ));
    }
    let units: Vec<String> = by_gyro
        .into_iter()
        .chain(clock.factors.iter().copied().filter(|_| by_gyro.is_none()))
        .filter_map(|factor| Some(format!("   {}", time_option(log, arguments, factor)?)))
        .collect();
    if !units.is_empty() {
        text.push_str(&format!(". If the time is in another unit:\n{}", units.join("\n")));
    }
    if clock.certain && units.is_empty() {
        // Nothing mends it: a log without time can still be fitted.
        log.notices.push(format!("{text}. ironout reads the log without time"));
        log.time_s = None;
        return Ok(());
    }
    if clock.certain || by_gyro.is_some() {
        return Err(Failure::usage(text).in_file(&log.path).at_column("t_s"));
    }
    log.notices.push(text);
    Ok(())
}

/// The option that reads the time in the unit that makes it `factor` times as long.
fn time_option(log: &Log, arguments: &LogArgs, factor: f64) -> Option<String> {
    let given = parse_map(&arguments.map).unwrap_or_default();
    let role = ["t_s", "t_us"];
    let mapped = given.iter().find(|(name, _)| role.contains(&name.as_str())).cloned();
    let read = log.read_as.columns.iter().find(|column| role.contains(&column.name.as_str()));
    let (name, header) = match (mapped, read) {
        (Some((name, header)), _) => (name, header),
        (None, Some(column)) => (column.name.clone(), column.source.clone()),
        (None, None) => ("t_s".to_string(), "t_s".to_string()),
    };
    // What a unit of the column was read as, s.
    let read_s = if name == "t_us" { 1e-6 } else { 1.0 };
    let wanted = read_s * factor;
    let (unit, _) = clock::UNITS.into_iter().find(|(_, size)| (wanted / size - 1.0).abs() < 1e-9)?;
    let others = given.iter().filter(|(name, _)| !role.contains(&name.as_str()));
    let map: Vec<String> = std::iter::once(format!("t_s={header}[{unit}]"))
        .chain(others.map(|(name, header)| format!("{name}={header}")))
        .collect();
    Some(typed_option("--map", &map.join(",")))
}

fn rate_words(log: &Log, arguments: &LogArgs, rate: &OddRate) -> String {
    let what = if rate.by_field { "the field" } else { "gravity" };
    let unit = rate.unit.map_or("an unusual unit (raw counts?)".to_string(), |(unit, _)| unit.to_string());
    let factor = rate.unit.map_or(rate.factor, |(_, size)| size);
    format!(
        "ironout ignores the gyro: its numbers are {} × the rotation of {what} ({:.0} % explained, {} segments), so they \
         are in {unit}, not in rad/s. To use it, add\n   {}",
        short(1.0 / rate.factor),
        100.0 * rate.explained,
        rate.stretches,
        gyro_options(log, arguments, factor)
    )
}

/// The options that multiply the gyro by a factor: other names for its columns, and the sensor's computed from them.
fn gyro_options(log: &Log, arguments: &LogArgs, factor: f64) -> String {
    let given = parse_map(&arguments.map).unwrap_or_default();
    let derived = |name: &str| arguments.derive.iter().any(|text| text.starts_with(&format!("{name}=")));
    let names = ["gx_radps", "gy_radps", "gz_radps"];
    let header = |name: &str| {
        let mapped = given.iter().find(|(own, _)| own == name).map(|(_, header)| header.clone());
        let read =
            log.read_as.columns.iter().find(|column| column.name == name).map(|column| column.source.clone());
        mapped.or(read.filter(|source| !source.is_empty())).unwrap_or_else(|| name.to_string())
    };
    let others = given.iter().filter(|(name, _)| !names.contains(&name.as_str()));
    let mut map: Vec<String> = others.map(|(name, header)| format!("{name}={header}")).collect();
    if !names.iter().any(|name| derived(name)) {
        map.extend(names.map(|name| format!("{}_read={}", &name[..2], header(name))));
    }
    let factor = match factor {
        f if (f - std::f64::consts::PI / 180.0).abs() < 1e-9 => "*pi/180".to_string(),
        f if (f - 180.0 / std::f64::consts::PI).abs() < 1e-6 => "*180/pi".to_string(),
        f => format!("*{f:.6e}"),
    };
    let own =
        names.map(|name| typed_option("--derive", &format!("{name}={}_read{factor}", &name[..2]))).concat();
    format!("{}{own}", if map.is_empty() { String::new() } else { typed_option("--map", &map.join(",")) })
}

fn axes_words(axes: &OddAxes) -> String {
    let figures = format!(
        "{:.0} % of the rotation is explained now, {:.0} % then; {} segments",
        100.0 * axes.explained,
        100.0 * axes.explained_then,
        axes.stretches
    );
    let (sensor, form, left_out, whose) = match axes.whose {
        Whose::Gyro => {
            ("gyro", "gyro", true, "the gyro's axes are not those of accelerometer and magnetometer")
        }
        Whose::Accelerometer => (
            "accelerometer",
            "accel",
            false,
            "the accelerometer's axes are not those of gyro and magnetometer",
        ),
        Whose::Magnetometer => {
            ("magnetometer", "mag", false, "the magnetometer's axes are not those of gyro and accelerometer")
        }
        Whose::GyroOrMagnetometer => ("gyro", "gyro", true, "the gyro's axes are not the magnetometer's"),
        Whose::LikelyMagnetometer => {
            ("magnetometer", "mag", false, "the magnetometer's axes are not the gyro's")
        }
        Whose::GyroOrAccelerometer => ("gyro", "gyro", true, "the gyro's axes are not the accelerometer's"),
    };
    let mirrored = axes.orders.iter().all(|order| order.is_mirrored());
    let mut text = format!("{whose} ({figures})");
    if left_out {
        text.push_str(". ironout ignores the gyro");
    }
    match axes.orders.as_slice() {
        [one] => text.push_str(&format!(
            ". They agree with\n   {}{}",
            typed_option("--rotate", &format!("{form}:{}", one.name())),
            if mirrored {
                format!("\nThis is a mirror image, so it cannot be a mounting: the {sensor}'s driver has a wrong axis or \
                     sign")
            } else {
                String::new()
            }
        )),
        several => {
            let names: Vec<String> = several.iter().take(6).map(|order| quoted(&order.name())).collect();
            text.push_str(&format!(
                ". The sensor was rotated about too few axes to determine the correct order ({}). Rotate it about all three",
                names.join(", ")
            ));
        }
    }
    if let (Whose::LikelyMagnetometer, [one]) = (axes.whose, axes.orders.as_slice()) {
        text.push_str(&format!(
            "\nThe accelerometer cannot show which of the two has other axes. Gyro and accelerometer are usually one chip, \
             so ironout assumes that it is the magnetometer. If it is the gyro, read the log with\n   {}",
            typed_option("--rotate", &format!("gyro:{}", one.back().name()))
        ));
    }
    let other = match axes.whose {
        Whose::GyroOrMagnetometer => "magnetometer",
        Whose::GyroOrAccelerometer => "accelerometer",
        _ => return text,
    };
    text.push_str(&format!("\nOr the {other} has other axes. This log cannot show which of the two"));
    text
}

fn gravity_words(gravity: &OddGravity) -> String {
    let OddGravity { magnitude_mps2, readings, unit, weightless } = gravity;
    let measured = format!("the accelerometer reads {} m/s² (median of {readings})", short(*magnitude_mps2));
    match unit {
        Some((unit, _)) => {
            format!("{measured}, which is gravity in {unit}, not in m/s². ironout uses its direction only")
        }
        None if *weightless => format!(
            "{measured}, so it does not contain gravity (a phone's \"linear acceleration\"). ironout ignores it. Log the \
             accelerometer with gravity"
        ),
        None => format!(
            "{measured}, but at rest it must be 9.8, so its scale is wrong. ironout uses its direction only"
        ),
    }
}
