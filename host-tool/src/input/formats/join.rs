//! A recording of several streams becomes one log: the magnetometer gives the rows, the rest is read at their times.

use crate::failure::{Choice, Failure, Outcome, Question};
use crate::input::columns::Role;
use crate::input::formats::interpolate::{GAP_PERIODS, at_times, gap_s};
use crate::input::formats::order::ordered;
use crate::input::formats::stream::{Column, Recording, Stream};
use crate::input::log::{Covariate, Log, ReadOptions};
use crate::input::map::{no_unit, resolve};
use crate::input::read_as::{Instance, LeftOut, Origin, ReadAs, ReadColumn};
use crate::input::repair;
use crate::input::repair_words;
use crate::input::unit::{Quantity, Unit};
use ironout_analysis::frame::IDENTITY;

const FIELD_UT: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
const FIELD_COUNTS: [&str; 3] = ["mx_counts", "my_counts", "mz_counts"];
const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];
/// A stream that has no value in more than this share of the rows is told of.
const TOLD_SHARE: f64 = 0.05;

/// Joins a recording into a log, in body axes as the recording has them, turned further by `--rotate`.
///
/// # Errors
/// No row is usable, the magnetometer is in counts and no scale is given, or `--map` names what is not there.
pub fn join(mut recording: Recording, options: &ReadOptions) -> Outcome<Log> {
    let stated = rename(&mut recording, options)?;
    let counts = recording.magnetometer.column(FIELD_COUNTS[0]).is_some();
    let field_names = if counts { FIELD_COUNTS } else { FIELD_UT };
    let mut notices = std::mem::take(&mut recording.notices);
    let given = options.ut_per_count.or(stated);
    let scale = match (counts, given, options.default_ut_per_count) {
        (true, Some(scale), _) | (true, None, Some(scale)) => Some(scale),
        (true, None, None) => return Err(no_scale(&recording.magnetometer, &recording.format)),
        (false, Some(_), _) if options.ut_per_count.is_some() => {
            notices.push("--ut-per-count is not used: this log states its unit".into());
            None
        }
        (false, ..) => None,
    };
    let mut left_out = std::mem::take(&mut recording.left_out);
    let rows = usable(&mut recording.magnetometer, field_names, &mut left_out);
    if rows == 0 {
        return Err(Failure::usage(format!(
            "no usable row in {}: {}",
            recording.magnetometer.name,
            left_out.iter().map(|(rows, why)| format!("{rows} with {why}")).collect::<Vec<_>>().join(", ")
        )));
    }
    let (made, repairs) = repaired(&mut recording.magnetometer, field_names, options, &mut left_out)?;
    recording.taken_out.extend(made);
    let rows = recording.magnetometer.time_s.len();
    if let (true, Some(matrix)) = (rows > 0, options.mounting.magnetometer) {
        recording.magnetometer.turn(field_names, &matrix);
    }
    let mut frame = std::mem::take(&mut recording.frame);
    frame.ut_per_number = scale.unwrap_or(frame.ut_per_number);
    let frame = frame.turned(&options.mounting.magnetometer.unwrap_or(IDENTITY));
    let joined = others(&mut recording, options, &mut notices);
    let mut columns = vec![ReadColumn {
        name: "t_s".into(),
        source: format!("time of {}", recording.magnetometer.name),
        unit: String::new(),
    }];
    let mut own: Vec<Column> = std::mem::take(&mut recording.magnetometer.columns);
    own.extend(joined);
    own.retain(|column| column.values.iter().any(|value| value.is_finite()));
    silent(&mut own, &mut notices);
    columns.extend(own.iter().map(|column| ReadColumn {
        name: column.name.clone(),
        source: column.source.clone(),
        unit: column.unit.clone(),
    }));
    let raw = take(&mut own, field_names).unwrap_or_default();
    let whole = scale.filter(|_| options.mounting.magnetometer.is_none()).and_then(|_| integers(&raw));
    let mut field_ut = raw;
    for (column, scale) in field_ut.iter_mut().zip(scale.unwrap_or([1.0; 3])) {
        column.iter_mut().for_each(|value| *value *= scale);
    }
    let accel_mps2 = take(&mut own, ACCEL);
    let gyro_radps = take(&mut own, GYRO);
    notices.extend(options.mounting.notices(accel_mps2.is_some(), gyro_radps.is_some()));
    let time_s = std::mem::take(&mut recording.magnetometer.time_s);
    Ok(Log {
        path: Default::default(),
        rows,
        time_s: Some(time_s),
        field_ut,
        frame,
        ut_per_count: scale,
        counts: whole,
        accel_mps2,
        gyro_radps,
        heading_deg: None,
        earth: None,
        declination_deg: None,
        recordings: Vec::new(),
        covariates: own.into_iter().map(covariate).collect(),
        read_as: ReadAs {
            format: recording.format,
            origin: Origin { vehicle: recording.vehicle, sensor: recording.sensor, start: None },
            columns,
            taken_out: recording.taken_out,
            repairs,
            pins: pins(&recording.instance, options, scale),
            instance: recording.instance.map(|(taken, there)| Instance { taken, there }),
            left_out: left_out
                .into_iter()
                .map(|(rows, why)| LeftOut { rows, first_line: None, why })
                .collect(),
            ..ReadAs::default()
        },
        notices,
    })
}

fn pins(
    instance: &Option<(usize, Vec<(usize, String)>)>,
    options: &ReadOptions,
    scale: Option<[f64; 3]>,
) -> Vec<(String, String)> {
    let mut pins = Vec::new();
    if let Some((taken, _)) = instance {
        pins.push(("--instance".to_string(), taken.to_string()));
    }
    for (name, source) in &options.map {
        pins.push(("--map".to_string(), format!("{name}={source}")));
    }
    if let Some([x, y, z]) = scale {
        let value = if x == y && y == z { x.to_string() } else { format!("{x},{y},{z}") };
        pins.push(("--ut-per-count".to_string(), value));
    }
    pins
}

/// `--map NAME=SOURCE[UNIT]` gives a column another name, another unit, or both; the magnetometer itself is chosen by `--instance`.
/// Gives the scale of counts, where their unit is stated so.
fn rename(recording: &mut Recording, options: &ReadOptions) -> Outcome<Option<[f64; 3]>> {
    let all = || {
        std::iter::once(&recording.magnetometer).chain(&recording.others).flat_map(|stream| &stream.columns)
    };
    let sources: Vec<String> = all().map(|column| column.source.clone()).collect();
    let names: Vec<String> = all().map(|column| column.name.clone()).collect();
    let mut field: [Option<Unit>; 3] = Default::default();
    for (name, from) in &options.map {
        let entry = format!("--map {name}={from}");
        if name.starts_with("t_") {
            return Err(Failure::usage(format!(
                "{entry}: this format has its own time. Fix: remove this entry"
            )));
        }
        let Some((index, unit)) = resolve(from, &sources).or_else(|| resolve(from, &names)) else {
            return Err(Failure::usage(format!(
                "{entry}: there is no column {from}. Available columns:\n {}",
                sources.join("\n ")
            )));
        };
        let axis = axis_of(name);
        let (name, quantity) = match Role::of(name) {
            (own, role, _) if role.quantity().is_some() => (own, role.quantity()),
            (own, Role::FieldCounts(_), _) => (own, Some(Quantity::Field)),
            (own, ..) => (own, None),
        };
        let unit = match unit {
            Some(unit) => Some(Unit::stated(unit, quantity).ok_or_else(|| no_unit(&name, unit))?),
            None => None,
        };
        if let Some(axis) = axis {
            let known = |column: &Column| axis_of(&column.name) == Some(axis);
            let own = recording.magnetometer.columns.get(index).filter(|column| known(column));
            if own.is_none() {
                return Err(Failure::usage(format!(
                    "{entry}: {} is not the {} axis of the magnetometer that is read. Fix: choose another magnetometer of \
                     the log \
                     with --instance, turn its axes with --rotate",
                    sources.get(index).map_or("it", String::as_str),
                    ["x", "y", "z"].get(axis).copied().unwrap_or_default()
                )));
            }
            if let Some(slot) = field.get_mut(axis) {
                *slot = unit;
            }
            continue;
        }
        let streams = std::iter::once(&mut recording.magnetometer).chain(&mut recording.others);
        if let Some(column) = streams.flat_map(|stream| &mut stream.columns).nth(index) {
            column.name.clone_from(&name);
            if let Some(unit) = unit {
                column.values.iter_mut().for_each(|value| *value = unit.convert(*value / column.scale));
                column.unit = unit.name.to_string();
            }
        }
    }
    restated(recording, field)
}

/// Which axis of the magnetometer a name stands for.
fn axis_of(name: &str) -> Option<usize> {
    match Role::of(name).1 {
        Role::FieldUt(axis) | Role::FieldCounts(axis) => Some(axis),
        _ => None,
    }
}

/// The magnetometer in another unit than its format has. Counts stay counts: gives their scale.
fn restated(recording: &mut Recording, units: [Option<Unit>; 3]) -> Outcome<Option<[f64; 3]>> {
    let [Some(x), Some(y), Some(z)] = &units else {
        return match units.iter().any(Option::is_some) {
            true => Err(Failure::usage(
                "--map states the unit of one axis of the magnetometer. Fix: state it for all three",
            )),
            false => Ok(None),
        };
    };
    let factors = [x.factor(), y.factor(), z.factor()];
    if recording.magnetometer.column(FIELD_COUNTS[0]).is_some() {
        return Ok(Some(factors));
    }
    if factors != [x.factor(); 3] {
        return Err(Failure::usage(
            "--map states different units for the axes of the magnetometer, whose axes may have been turned. Fix: state one \
             unit",
        ));
    }
    for column in recording.magnetometer.columns.iter_mut().filter(|column| axis_of(&column.name).is_some()) {
        let ratio = x.factor() / column.scale;
        column.values.iter_mut().for_each(|value| *value *= ratio);
        column.unit = x.name.to_string();
    }
    recording.frame.ut_per_number = factors;
    Ok(None)
}

/// Leaves out rows without a number in the field, and rows out of the order of time. Gives how many stay.
fn usable(stream: &mut Stream, field: [&str; 3], left_out: &mut Vec<(usize, String)>) -> usize {
    let columns = field.map(|name| stream.column(name).map(|column| column.values.as_slice()));
    let [Some(x), Some(y), Some(z)] = columns else { return 0 };
    let numbers: Vec<bool> = stream
        .time_s
        .iter()
        .zip(x)
        .zip(y.iter().zip(z))
        .map(|((t, x), (y, z))| [t, x, y, z].iter().all(|value| value.is_finite()))
        .collect();
    let without = numbers.iter().filter(|number| !**number).count();
    keep(stream, &numbers);
    let in_order = ordered(&stream.time_s);
    let disordered = in_order.iter().filter(|stays| !**stays).count();
    keep(stream, &in_order);
    for (rows, why) in
        [(without, "no number in the magnetometer's columns"), (disordered, "a time out of order")]
    {
        if rows > 0 {
            left_out.push((rows, why.to_string()));
        }
    }
    stream.time_s.len()
}

/// Mends the magnetometer's numbers, and takes the rows out that are not readings: what was mended, and what another log needs too.
fn repaired(
    stream: &mut Stream,
    field: [&str; 3],
    options: &ReadOptions,
    left_out: &mut Vec<(usize, String)>,
) -> Outcome<(Vec<String>, Vec<String>)> {
    let rows = stream.time_s.len();
    let numbers =
        field.map(|name| stream.column(name).map(|column| column.values.clone()).unwrap_or_default());
    let mended = repair::mend(numbers, &options.repair)?;
    let mut stays = vec![false; rows];
    for row in &mended.kept {
        if let Some(stays) = stays.get_mut(*row) {
            *stays = true;
        }
    }
    keep(stream, &stays);
    for (name, values) in field.iter().zip(mended.numbers) {
        if let Some(column) = stream.columns.iter_mut().find(|column| column.name == *name) {
            column.values = values;
        }
    }
    left_out.extend(mended.left_out);
    let asked = options.repair.iter().map(repair_words::asked);
    Ok((mended.made, asked.chain(mended.codes).collect()))
}

fn keep(stream: &mut Stream, stays: &[bool]) {
    if stays.iter().all(|stays| *stays) {
        return;
    }
    let thin = |values: &mut Vec<f64>| {
        let mut flags = stays.iter();
        values.retain(|_| flags.next().copied().unwrap_or(false));
    };
    thin(&mut stream.time_s);
    stream.columns.iter_mut().for_each(|column| thin(&mut column.values));
}

/// The columns of all other streams at the magnetometer's times; the first of a name that has values wins.
fn others(recording: &mut Recording, options: &ReadOptions, notices: &mut Vec<String>) -> Vec<Column> {
    let mut joined: Vec<Column> = Vec::new();
    let mut taken: Vec<String> =
        recording.magnetometer.columns.iter().map(|column| column.name.clone()).collect();
    let at_s = recording.magnetometer.time_s.as_slice();
    for mut stream in std::mem::take(&mut recording.others) {
        stream.columns.retain(|column| {
            !taken.contains(&column.name) && column.values.iter().any(|value| value.is_finite())
        });
        if stream.columns.is_empty() {
            continue;
        }
        let finite: Vec<bool> = stream.time_s.iter().map(|time| time.is_finite()).collect();
        keep(&mut stream, &finite);
        let in_order = ordered(&stream.time_s);
        keep(&mut stream, &in_order);
        stream.continuous_attitude();
        for (names, matrix) in [(ACCEL, options.mounting.accelerometer), (GYRO, options.mounting.gyroscope)] {
            if let Some(matrix) = matrix {
                stream.turn(names, &matrix);
            }
        }
        let gap = gap_s(&stream.time_s);
        let (mut most_empty, mut names) = (0, Vec::new());
        for column in stream.columns {
            let values = at_times(&stream.time_s, &column.values, column.between, gap, at_s);
            let empty = values.iter().filter(|value| !value.is_finite()).count();
            if empty < values.len() {
                most_empty = most_empty.max(empty);
                taken.push(column.name.clone());
                names.push(column.name.clone());
                joined.push(Column { values, ..column });
            }
        }
        if most_empty as f64 > TOLD_SHARE * at_s.len() as f64 {
            notices.push(format!(
                "{} ({}): empty in {most_empty} of {} rows, before its first or after its last sample, or in a gap of more \
                 than {GAP_PERIODS} periods ({gap:.3} s)",
                names.join(", "),
                stream.name,
                at_s.len()
            ));
        }
    }
    joined
}

/// Outputs that are not connected, currents that nothing measures: zero from beginning to end, and no cause of anything.
fn silent(columns: &mut Vec<Column>, notices: &mut Vec<String>) {
    let sensor = |name: &str| [FIELD_UT, FIELD_COUNTS, ACCEL, GYRO].as_flattened().contains(&name);
    let is = |column: &mut Column| {
        !sensor(&column.name) && column.values.iter().all(|value| *value == 0.0 || !value.is_finite())
    };
    let names: Vec<String> = columns.extract_if(.., is).map(|column| column.name).collect();
    if !names.is_empty() {
        notices.push(format!("ignored columns that are always zero: {}", names.join(", ")));
    }
}

fn take(columns: &mut Vec<Column>, names: [&str; 3]) -> Option<[Vec<f64>; 3]> {
    if !names.iter().all(|name| columns.iter().any(|column| column.name == *name)) {
        columns.retain(|column| !names.contains(&column.name.as_str()));
        return None;
    }
    Some(names.map(|name| {
        let at = columns.iter().position(|column| column.name == name);
        at.map(|at| columns.remove(at).values).unwrap_or_default()
    }))
}

fn covariate(column: Column) -> Covariate {
    let values: Vec<f64> = column.values.iter().map(|v| if v.is_finite() { *v } else { f64::NAN }).collect();
    let empty = values.iter().filter(|value| value.is_nan()).count();
    Covariate { name: column.name, values, empty, not_finite: 0 }
}

fn integers(raw: &[Vec<f64>; 3]) -> Option<Vec<[i16; 3]>> {
    let exact = |value: f64| {
        let count = value as i16;
        (f64::from(count) == value).then_some(count)
    };
    let [x, y, z] = raw;
    x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Some([exact(x)?, exact(y)?, exact(z)?])).collect()
}

/// Scales of chips that flight controllers carry, µT a count, at the range their firmware sets.
const CHIPS: [(&str, f64); 6] = [
    ("HMC5883L at ±1.3 G", 0.0917),
    ("QMC5883L at ±8 G", 0.0333),
    ("IST8310", 0.3),
    ("LIS3MDL at ±4 G", 0.0146),
    ("AK8963/MPU9250", 0.15),
    ("AK8975", 0.3),
];

/// The magnetometer is in counts: which scales give a field that the Earth has.
fn no_scale(stream: &Stream, format: &str) -> Failure {
    let mut squares = 0.0;
    for name in FIELD_COUNTS {
        let mut values: Vec<f64> =
            stream.column(name).map(|column| column.values.clone()).unwrap_or_default();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        // Half the range from the 2nd to the 98th hundredth: nearly the field where all attitudes were seen, less otherwise.
        let at = |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or(0.0);
        squares = f64::max(squares, (at(0.98) - at(0.02)) / 2.0);
    }
    let mut message = format!(
        "{format} stores raw counts of an unknown magnetometer chip. Give the scale with --ut-per-count, in µT per \
         count.\nThe counts span ±{squares:.0}, and the Earth's field is 22 to 67 µT:"
    );
    let mut choices = Vec::new();
    for (chip, scale) in CHIPS {
        let field = squares * scale;
        let fits = if (11.0..=100.0).contains(&field) { "" } else { ", implausible" };
        message.push_str(&format!("\n  --ut-per-count {scale}   {chip} (gives ±{field:.0} µT{fits})"));
        if fits.is_empty() {
            let options = vec![("--ut-per-count".to_string(), scale.to_string())];
            choices.push(Choice {
                label: format!("{chip}: {scale} µT per count (gives ±{field:.0} µT)"),
                options,
            });
        }
    }
    let text = "The magnetometer is in counts of its chip. Which chip is it?".to_string();
    let question = Question { text, choices, needs_scale: true, ..Question::default() };
    Failure::usage(message).at_column("magADC").asking(question)
}
