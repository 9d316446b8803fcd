//! What ArduPilot had done to the field of its compasses, undone.
//!
//! `corrected = M·((raw + offset)·scale) + motor`, all in body axes (libraries/AP_Compass/AP_Compass_Backend.cpp,
//! `correct_field`). A `MAG` message holds the corrected field, the offset and the motor's part as they were used; M (`DIA`,
//! `ODI`) and the scale are parameters.

use crate::failure::{Failure, Outcome};
use crate::input::formats::correction::Correction;
use crate::input::formats::dataflash::collect::Collected;
use crate::input::formats::parameters::Parameters;
use crate::input::formats::rotation;
use crate::input::formats::stream::{Recording, Stream, choose, is_as_dense, without_course};
use ironout_analysis::frame::{Frame, IDENTITY, MAX_REMOVED, Program, Removed, Rows, rows};
use nalgebra::Vector3;

const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
const OFFSET: [&str; 3] = ["offset_x", "offset_y", "offset_z"];
const MOTOR: [&str; 3] = ["motor_x", "motor_y", "motor_z"];
/// Milligauss to microtesla.
const UT: f64 = 0.1;
/// ArduPilot uses a scale within these only (CompassCalibrator.h).
const SCALES: std::ops::RangeInclusive<f64> = 0.85..=1.4;
/// `FRAME_CLASS` of a rover that floats.
const BOAT: f64 = 2.0;
/// Logged offsets are cut to whole milligauss.
const ROUNDING_MG: f64 = 1.0;

/// From all that was collected to a recording.
///
/// # Errors
/// No magnetometer, an instance that is not there, or a matrix that cannot be undone.
pub fn finish(
    mut collected: Collected,
    format: &str,
    instance: Option<usize>,
    notices: Vec<String>,
) -> Outcome<Recording> {
    collected.scaled();
    let compasses: Vec<(usize, String)> = collected
        .streams
        .iter()
        .filter(|((place, _), stream)| *place == 0 && FIELD.iter().all(|name| stream.column(name).is_some()))
        .map(|((_, number), stream)| (usize::from(*number), format!("{} samples", stream.time_s.len())))
        .collect();
    if compasses.is_empty() {
        return Err(collected.inventory.no_magnetometer(
            "MAG, MAG2, MAG3 (MagX, MagY, MagZ)",
            "ArduPilot logs the compass with bit 13 (Compass) of LOG_BITMASK.",
        ));
    }
    let taken = choose(instance, &compasses, "compass")?;
    // "ArduRover V4.5.7", "APM:Rover V2.50"
    let on_wheels = collected.firmware.as_ref().is_some_and(|words| words.to_lowercase().contains("rover"))
        && !collected.parameters.is_ever("FRAME_CLASS", |class| class == BOAT);
    let words = collected.firmware.take().map_or_else(String::new, |words| format!(", {words}"));
    let mut recording = Recording {
        format: format!("{format}{words}"),
        instance: (compasses.len() > 1).then_some((taken, compasses)),
        notices,
        ..Recording::default()
    };
    let mut others = Vec::new();
    for ((place, number), stream) in std::mem::take(&mut collected.streams) {
        if place != 0 {
            recording.others.push(without_zeros(stream));
        } else if usize::from(number) == taken {
            recording.magnetometer = stream;
        } else {
            others.push((usize::from(number), stream));
        }
    }
    for (number, stream) in others {
        // What was removed of it is of no interest: it is not calibrated here.
        let mut other = Recording { magnetometer: stream, ..Recording::default() };
        let fits = undo(number, &collected.parameters, &mut other).is_ok();
        if fits && is_as_dense(&other.magnetometer, &recording.magnetometer) {
            recording.others.push(other.magnetometer.into_other());
            break;
        }
    }
    if !on_wheels {
        without_course(&mut recording.others);
    }
    undo(taken, &collected.parameters, &mut recording)?;
    Ok(recording)
}

/// A position of exactly zero is none.
fn without_zeros(mut stream: Stream) -> Stream {
    for column in
        stream.columns.iter_mut().filter(|column| ["lat_deg", "lon_deg"].contains(&column.name.as_str()))
    {
        column.values.iter_mut().filter(|value| **value == 0.0).for_each(|value| *value = f64::NAN);
    }
    stream
}

/// `COMPASS_DIA_X`, `COMPASS_DIA2_X`, …
fn names(what: &str, k: usize) -> [String; 3] {
    ["X", "Y", "Z"].map(|axis| format!("COMPASS_{what}{}_{axis}", number(k)))
}

fn number(k: usize) -> String {
    if k == 1 { String::new() } else { k.to_string() }
}

/// Whose parameters (1, 2, 3) are those of a compass: messages count by priority, parameters by detection. The offsets in the
/// message tell; else the device ids.
fn owner(taken: usize, parameters: &Parameters, offset_ut: [f64; 3], notices: &mut Vec<String>) -> usize {
    let id = |name: String| parameters.first(&name).filter(|id| *id != 0.0);
    let wanted = id(format!("COMPASS_PRIO{}_ID", taken + 1));
    let by_id = (1..=3).find(|k| wanted.is_some() && id(format!("COMPASS_DEV_ID{}", number(*k))) == wanted);
    let likely = by_id.unwrap_or(taken + 1);
    let same = |k: usize| {
        let own = parameters.three(names("OFS", k), f64::NEG_INFINITY, f64::NAN);
        own.iter().zip(offset_ut).all(|(own, logged)| (own - logged / UT).abs() <= ROUNDING_MG)
    };
    let order = std::iter::once(likely).chain((1..=3).filter(|k| *k != likely));
    let known = parameters.first(&names("OFS", likely)[0]).is_some();
    let mut order = order.filter(|k| same(*k));
    match order.next() {
        Some(k) => k,
        None => {
            if known && offset_ut.iter().all(|value| value.is_finite()) {
                notices.push(format!(
                    "the offsets in MAG match no COMPASS_OFS parameter (learned in flight?). ironout removed the offsets of \
                     the messages and COMPASS_DIA{0},ODI{0}",
                    number(likely)
                ));
            }
            likely
        }
    }
}

/// Whether the offsets of a compass, counted from 0, are known.
pub fn has_offsets(taken: usize, parameters: &Parameters) -> bool {
    (1..=3).any(|k| parameters.first(&names("OFS", k)[0]).is_some())
        && parameters.first(&names("OFS", taken + 1)[0]).is_some()
}

/// Takes the calibration of a compass, counted from 0, out of the magnetometer of a recording.
///
/// # Errors
/// A matrix that cannot be undone.
pub fn undo(taken: usize, parameters: &Parameters, recording: &mut Recording) -> Outcome<()> {
    let stream = &mut recording.magnetometer;
    let three = |stream: &Stream, names: [&str; 3], row: usize| {
        names.map(|name| stream.column(name).and_then(|c| c.values.get(row)).copied().unwrap_or(f64::NAN))
    };
    let first_offset = three(stream, OFFSET, 0);
    let k = owner(taken, parameters, first_offset, &mut recording.notices);
    let logged = stream.column(OFFSET[0]).is_some();
    let starts = parameters.changes(|name| {
        ["OFS", "DIA", "ODI"].iter().any(|what| names(what, k).iter().any(|own| own == name))
            || name == format!("COMPASS_SCALE{}", number(k))
    });
    let mut epochs = Vec::new();
    for since in std::iter::once(f64::NEG_INFINITY).chain(starts) {
        let mut diagonal = parameters.three(names("DIA", k), since, 1.0);
        if diagonal == [0.0; 3] {
            diagonal = [1.0; 3];
        }
        let off = parameters.three(names("ODI", k), since, 0.0);
        let set = parameters.at(&format!("COMPASS_SCALE{}", number(k)), since).unwrap_or(0.0);
        let scale = if SCALES.contains(&set) { set } else { 1.0 };
        let offset = parameters.three(names("OFS", k), since, 0.0);
        let correction =
            Correction { offset: Vector3::zeros(), matrix: Correction::symmetric(diagonal, off) * scale };
        let undo = correction.inverse().ok_or_else(|| {
            Failure::usage(format!(
                "COMPASS_DIA{0},ODI{0} of the log cannot be undone: not invertible",
                number(k)
            ))
        })?;
        let from = if since.is_finite() { format!(" (from {since:.1} s on)") } else { String::new() };
        recording.taken_out.push(format!(
            "removed the autopilot's calibration COMPASS_*{}{from}: offset {} mG, diagonal {}, off-diagonal {}, scale {scale}",
            number(k),
            join(offset, 1),
            join(diagonal, 4),
            join(off, 4)
        ));
        epochs.push((since, undo, offset, correction.matrix));
    }
    let mut frame = Frame::of(Program::Ardupilot, UT, IDENTITY);
    (frame.from_sensor, frame.mounting) = mounting(k, parameters);
    let motors = (0..stream.time_s.len())
        .any(|row| three(stream, MOTOR, row).iter().any(|value| value.is_finite() && *value != 0.0));
    if motors {
        recording
            .taken_out
            .push("removed MOX,MOY,MOZ, the autopilot's compensation of motors or current".into());
    }
    let mut epoch = 0;
    let mut before: Option<f64> = None;
    for row in 0..stream.time_s.len() {
        let time = stream.time_s.get(row).copied().unwrap_or(f64::NAN);
        while epochs.get(epoch + 1).is_some_and(|(since, ..)| *since < time) {
            epoch += 1;
        }
        let Some((_, undo, parameter, matrix)) = epochs.get(epoch) else { break };
        let finite = |values: [f64; 3]| values.map(|value| if value.is_finite() { value } else { 0.0 });
        let motor = Vector3::from(finite(three(stream, MOTOR, row)));
        let in_message = finite(three(stream, OFFSET, row));
        // The parameter has more digits than the message; where they differ, the message says what was used.
        let offset: [f64; 3] = std::array::from_fn(|i| match (in_message.get(i), parameter.get(i)) {
            (Some(own), Some(set)) if !logged || (own / UT - set).abs() <= ROUNDING_MG => set * UT,
            (own, _) => own.copied().unwrap_or(0.0),
        });
        let corrected = Vector3::from(three(stream, FIELD, row));
        let removed = Removed {
            from_s: before,
            offset: offset.map(|value| -value / UT),
            matrix: rows(matrix),
            power: motors,
        };
        before = Some(time);
        let same = |last: &Removed| last.offset == removed.offset && last.matrix == removed.matrix;
        if !frame.removed.last().is_some_and(same) {
            if frame.removed.len() == MAX_REMOVED {
                frame.removed.remove(1);
            }
            frame.removed.push(removed);
        }
        let raw = undo.apply(corrected - motor) - Vector3::from(offset);
        for (name, value) in FIELD.iter().zip(raw.iter()) {
            let column = stream.columns.iter_mut().find(|column| column.name == *name);
            if let Some(cell) = column.and_then(|column| column.values.get_mut(row)) {
                *cell = *value;
            }
        }
    }
    stream.columns.retain(|column| FIELD.contains(&column.name.as_str()));
    let applied = |one: &Removed| one.offset != [0.0; 3] || one.matrix != IDENTITY || one.power;
    if !frame.removed.iter().any(applied) {
        frame.removed.clear();
    }
    recording.frame = frame;
    Ok(())
}

/// From the sensor's axes to the body's, where the parameters tell: `COMPASS_ORIENT` for an external compass, that of the board
/// for one on it (`rotate_field`). Without them the message's own axes are all that is known.
fn mounting(k: usize, parameters: &Parameters) -> (Option<Rows>, Option<Rows>) {
    let external = match k {
        1 => ["COMPASS_EXTERNAL", "COMPASS_EXTERN"],
        2 => ["COMPASS_EXTERN2", "COMPASS_EXTERN2"],
        _ => ["COMPASS_EXTERN3", "COMPASS_EXTERN3"],
    };
    let external = external.iter().find_map(|name| parameters.first(name));
    let name = match external {
        Some(0.0) => "AHRS_ORIENTATION".to_string(),
        Some(_) => format!("COMPASS_ORIENT{}", number(k)),
        None => return (None, Some(IDENTITY)),
    };
    let angles = parameters.first(&name).and_then(|number| rotation::angles_deg(number as i64));
    match angles.map(rotation::matrix) {
        Some(matrix) => (Some(matrix), Some(matrix)),
        None => (None, Some(IDENTITY)),
    }
}

fn join(values: [f64; 3], digits: usize) -> String {
    values.map(|value| format!("{value:.digits$}")).join(" ")
}
