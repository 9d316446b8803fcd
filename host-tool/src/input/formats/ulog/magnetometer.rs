//! Which topic of a PX4 log is the magnetometer, and what PX4 had done to its values.
//!
//! PX4 corrects as `R·(S·((raw + power·comp) − offset))` with R the mounting (src/lib/sensor_calibration/Magnetometer.hpp):
//! `sensor_mag` is `raw`, `vehicle_magnetometer` is corrected. Before 1.12 drivers corrected `sensor_mag` themselves, without R,
//! and `sensor_combined` carried the corrected field. Here everything becomes `R·raw`: the sensor's own field in body axes.

use crate::failure::{Failure, Outcome};
use crate::input::formats::correction::{Correction, Undo};
use crate::input::formats::interpolate::{at_times, gap_s};
use crate::input::formats::parameters::Parameters;
use crate::input::formats::rotation;
use crate::input::formats::stream::{Between, Recording, Stream, choose, is_as_dense};
use crate::input::formats::ulog::collector::Collector;
use ironout_analysis::frame::{Frame, IDENTITY, MAX_REMOVED, Program, Removed, rows};
use nalgebra::{Matrix3, Vector3};

const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
/// PX4 knows so many magnetometers.
const SENSORS: usize = 4;
/// A corrected stream is taken instead of the raw one of the same sensor where it has so many times more samples: by default
/// PX4 logs `sensor_mag` once a second.
const DENSER: usize = 3;
/// From this release on (major, minor) drivers leave `sensor_mag` alone.
const DRIVERS_STOPPED: [u8; 2] = [1, 12];
/// From this release on the fine adjustment of the board is applied to external sensors too.
const ALL_LEVELLED: [u8; 2] = [1, 13];
/// Gauss to microtesla.
const UT: f64 = 100.0;
/// Current compensation is in gauss a kiloampere.
const KILO: f64 = 1000.0;

/// What has been done to the values of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing.
    Raw,
    /// Offset and scale by the driver, in the sensor's axes.
    ByDriver,
    /// Everything, and turned to the body's axes.
    Corrected,
}

struct Candidate {
    number: usize,
    device_id: u32,
    state: State,
    collector: Collector,
}

/// Takes the magnetometer out of what was collected; `release` is the major and minor version of PX4, where the log names it.
///
/// # Errors
/// The instance asked for is not there. `Ok(None)`: there is no magnetometer at all.
pub fn take(
    collectors: &mut Vec<Collector>,
    parameters: &Parameters,
    release: Option<[u8; 2]>,
    wanted: Option<usize>,
) -> Outcome<Option<Recording>> {
    let in_use = in_use(collectors);
    let candidates = candidates(collectors, parameters, release);
    if candidates.is_empty() {
        return Ok(None);
    }
    let most = candidates.iter().map(|one| one.collector.stream.time_s.len()).max();
    let there: Vec<(usize, String)> =
        candidates.iter().map(|candidate| (candidate.number, describe(candidate))).collect();
    // Without a wish the compass that PX4 flew with, else the one with the most samples: a second sensor is often logged once a
    // second only.
    let flown = candidates.iter().find(|one| in_use.is_some() && Some(one.device_id) == in_use);
    let fullest = candidates.iter().find(|one| Some(one.collector.stream.time_s.len()) == most);
    let taken = choose(wanted.or(flown.or(fullest).map(|one| one.number)), &there, "magnetometer")?;
    let (mut own, mut others): (Vec<_>, Vec<_>) = candidates.into_iter().partition(|one| one.number == taken);
    let Some(candidate) = own.pop() else { return Ok(None) };
    let mut recording =
        Recording { instance: (there.len() > 1).then_some((taken, there)), ..Recording::default() };
    recording.sensor = (candidate.device_id != 0).then(|| candidate.device_id.to_string());
    let stream = undo(candidate, collectors, parameters, release, &mut recording)?;
    recording.magnetometer = stream;
    others.sort_by_key(|one| std::cmp::Reverse(one.collector.stream.time_s.len()));
    if let Some(other) = others.into_iter().next() {
        // What was removed of it is of no interest: it is not calibrated here.
        let other = undo(other, collectors, parameters, release, &mut Recording::default());
        let other = other.ok().filter(|stream| is_as_dense(stream, &recording.magnetometer));
        recording.others.extend(other.map(Stream::into_other));
    }
    Ok(Some(recording))
}

/// The device whose field PX4 used the longest: that of `vehicle_magnetometer`.
fn in_use(collectors: &[Collector]) -> Option<u32> {
    let used = collectors.iter().filter(|one| one.topic == "vehicle_magnetometer" && finite(&one.stream));
    let first = used.min_by_key(|one| one.instance)?.clone();
    let apart = first.by_device();
    apart.iter().max_by_key(|one| one.stream.time_s.len()).map(|one| one.device_id).filter(|id| *id != 0)
}

fn describe(candidate: &Candidate) -> String {
    let samples = candidate.collector.stream.time_s.len();
    let device = if candidate.device_id == 0 {
        "device unknown".to_string()
    } else {
        format!("device {}", candidate.device_id)
    };
    format!("{}, {device}, {samples} samples", candidate.collector.stream.name)
}

fn candidates(
    collectors: &mut Vec<Collector>,
    parameters: &Parameters,
    release: Option<[u8; 2]>,
) -> Vec<Candidate> {
    let by_driver = release.is_some_and(|release| release < DRIVERS_STOPPED);
    let mut of = |topic: &str| -> Vec<Collector> {
        let is = |one: &mut Collector| one.topic == topic && finite(&one.stream);
        let mut found: Vec<Collector> =
            collectors.extract_if(.., is).flat_map(Collector::by_device).collect();
        found.sort_by_key(|one| one.instance);
        found
    };
    let (raw, corrected) = (of("sensor_mag"), of("vehicle_magnetometer"));
    let prime = parameters.first("CAL_MAG_PRIME").map_or(0, |id| id as i64 as u32);
    let mut found: Vec<Candidate> = raw
        .into_iter()
        .map(|collector| Candidate {
            number: collector.instance.into(),
            device_id: collector.device_id,
            state: if by_driver || collector.with_counts { State::ByDriver } else { State::Raw },
            collector,
        })
        .collect();
    for mut collector in corrected {
        let device_id = if collector.device_id != 0 { collector.device_id } else { prime };
        let own = found
            .iter()
            .position(|one| one.device_id == device_id && device_id != 0 && one.state != State::Corrected);
        let next = found.iter().map(|one| one.number + 1).max().unwrap_or(0);
        let number = match own.and_then(|at| found.get(at)) {
            Some(raw) if collector.stream.time_s.len() < DENSER * raw.collector.stream.time_s.len() => {
                continue;
            }
            Some(raw) => raw.number,
            None => next.max(collector.instance.into()),
        };
        if let Some(raw) = own.map(|at| found.remove(at)) {
            // Its temperature comes along, joined at the times of the denser stream.
            collector.external = raw.collector.external;
            let mut rest = raw.collector;
            rest.stream.columns.retain(|column| !FIELD.contains(&column.name.as_str()));
            collectors.push(rest);
        }
        found.push(Candidate { number, device_id, state: State::Corrected, collector });
    }
    if found.is_empty() {
        let combined =
            collectors.iter_mut().find(|one| one.topic == "sensor_combined" && finite(&one.stream));
        if let Some(combined) = combined {
            let mut collector = combined.clone();
            collector.stream.columns.retain(|column| FIELD.contains(&column.name.as_str()));
            combined.stream.columns.retain(|column| !FIELD.contains(&column.name.as_str()));
            found.push(Candidate { number: 0, device_id: prime, state: State::Corrected, collector });
        }
    }
    found.sort_by_key(|one| one.number);
    found
}

fn finite(stream: &Stream) -> bool {
    FIELD.iter().all(|name| {
        stream.column(name).is_some_and(|column| column.values.iter().any(|value| value.is_finite()))
    })
}

/// The numbers n of CAL_MAGn_* that are of a device at any time.
fn slots(parameters: &Parameters, device_id: u32) -> Vec<usize> {
    // A parameter is a signed number of 32 bits, a device id an unsigned one.
    let own = |n: &usize| parameters.is_ever(&format!("CAL_MAG{n}_ID"), |id| id as i64 as u32 == device_id);
    (0..SENSORS).filter(|n| device_id != 0 && own(n)).collect()
}

/// The mounting: the sensor's own where it is external, and the board's fine adjustment. With words.
fn mounting(
    parameters: &Parameters,
    n: Option<usize>,
    external: Option<bool>,
    release: Option<[u8; 2]>,
) -> (Matrix3<f64>, String) {
    let first = |name: &str| parameters.first(name);
    let board = first("SENS_BOARD_ROT").unwrap_or(0.0) as i64;
    let own = n.and_then(|n| first(&format!("CAL_MAG{n}_ROT"))).map(|number| number as i64);
    let (angles, name) = match (own, n) {
        (Some(100), Some(n)) => {
            let names = ["ROLL", "PITCH", "YAW"].map(|axis| format!("CAL_MAG{n}_{axis}"));
            (parameters.three(names, f64::NEG_INFINITY, 0.0), format!("CAL_MAG{n}_ROLL,PITCH,YAW"))
        }
        (Some(number), Some(n)) if number >= 0 => {
            (rotation::angles_deg(number).unwrap_or_default(), format!("CAL_MAG{n}_ROT = {number}"))
        }
        _ if external == Some(true) => ([0.0; 3], "external sensor without a CAL_MAGn_ROT".into()),
        _ => (rotation::angles_deg(board).unwrap_or_default(), format!("SENS_BOARD_ROT = {board}")),
    };
    // Before that release the fine adjustment was of the board, and of no external sensor.
    let outside = external == Some(true) || own.is_some_and(|number| number >= 0);
    let level = match release {
        Some(release) if outside && release < ALL_LEVELLED => [0.0; 3],
        _ => ["X", "Y", "Z"].map(|axis| first(&format!("SENS_BOARD_{axis}_OFF")).unwrap_or(0.0)),
    };
    let matrix = |angles| {
        let m = rotation::matrix(angles);
        Matrix3::from_fn(|i, j| m.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0))
    };
    let mut text = format!("{name}: {}", rotation::words(angles));
    if level != [0.0; 3] {
        text.push_str(&format!("; SENS_BOARD_X,Y,Z_OFF: {:.2}, {:.2}, {:.2}°", level[0], level[1], level[2]));
    }
    (matrix(level) * matrix(angles), text)
}

fn undo(
    candidate: Candidate,
    collectors: &mut [Collector],
    parameters: &Parameters,
    release: Option<[u8; 2]>,
    recording: &mut Recording,
) -> Outcome<Stream> {
    let Candidate { state, device_id, collector, .. } = candidate;
    let slots = slots(parameters, device_id);
    let n = slots.first().copied();
    let (turn, turn_words) = mounting(parameters, n, collector.external, release);
    let own = rows(&turn);
    let mut frame = match (state, n) {
        // What no calibration is known of has been turned already, and by what is not known.
        (State::Corrected, None) => Frame::of(Program::Px4, UT, IDENTITY),
        (State::Corrected, Some(_)) => {
            Frame { from_sensor: Some(own), mounting: Some(own), ..Frame::of(Program::Px4, UT, IDENTITY) }
        }
        _ => Frame { mounting: Some(own), ..Frame::of(Program::Px4, UT, own) },
    };
    let mut stream = collector.stream;
    let told = &mut recording.taken_out;
    match (state, n) {
        (State::Raw, _) => told.push(format!("nothing: {} is not corrected by the autopilot", stream.name)),
        (_, None) => recording.notices.push(format!(
            "{}: no CAL_MAGn_ID of the log matches its sensor (device {device_id}). ironout assumes that it is not \
             corrected",
            stream.name
        )),
        (_, Some(n)) => {
            let back = if state == State::Corrected { turn } else { Matrix3::identity() };
            let power = power(&stream, state, n, collectors, parameters, told);
            let device = Device { id: device_id, slots: &slots };
            frame.removed = remove(&mut stream, device, back, parameters, power.as_deref(), told)?;
        }
    }
    recording.frame = frame;
    if turn != Matrix3::identity() {
        told.push(format!("rotated from sensor to body axes by {turn_words}"));
        // A corrected stream that no calibration is known of stays as it is: it has been turned already.
        if state != State::Corrected || n.is_some() {
            stream.turn(FIELD, &[0, 1, 2].map(|i| [turn[(i, 0)], turn[(i, 1)], turn[(i, 2)]]));
        }
    }
    Ok(stream)
}

/// A sensor, and the numbers n of CAL_MAGn_* that are its own at some time.
#[derive(Clone, Copy)]
struct Device<'a> {
    id: u32,
    slots: &'a [usize],
}

impl Device<'_> {
    /// The number at a time.
    fn slot_at(&self, parameters: &Parameters, since: f64) -> Option<usize> {
        let own = |n: &&usize| {
            parameters.at(&format!("CAL_MAG{n}_ID"), since).is_some_and(|id| id as i64 as u32 == self.id)
        };
        self.slots.iter().find(own).copied()
    }
}

/// Takes `CAL_MAGn_*` out of the values, with the parameters as they were at each time. Gives what was taken out.
fn remove(
    stream: &mut Stream,
    device: Device<'_>,
    back: Matrix3<f64>,
    parameters: &Parameters,
    power: Option<&[[f64; 3]]>,
    told: &mut Vec<String>,
) -> Outcome<Vec<Removed>> {
    let starts = parameters.changes(|name| {
        device.slots.iter().any(|n| {
            let part = name.strip_prefix(&format!("CAL_MAG{n}_")).unwrap_or_default();
            ["OFF", "SCALE", "ODIAG", "ID"].iter().any(|end| part.ends_with(end))
        })
    });
    let mut epochs: Vec<(f64, Undo)> = Vec::new();
    let mut removed = Vec::new();
    for since in std::iter::once(f64::NEG_INFINITY).chain(starts) {
        let from = if since.is_finite() { format!(" (from {since:.1} s on)") } else { String::new() };
        let Some(n) = device.slot_at(parameters, since) else {
            told.push(format!("nothing: no CAL_MAGn_ID matches the sensor{from}"));
            let none = Correction { offset: Vector3::zeros(), matrix: Matrix3::identity() };
            epochs.extend(none.inverse().map(|undo| (since, undo)));
            removed.push(Removed {
                from_s: since.is_finite().then_some(since),
                offset: [0.0; 3],
                matrix: IDENTITY,
                power: false,
            });
            continue;
        };
        let three = |what: &str, unset: f64| {
            parameters.three(["X", "Y", "Z"].map(|axis| format!("CAL_MAG{n}_{axis}{what}")), since, unset)
        };
        let (offset, scale, off) = (three("OFF", 0.0), three("SCALE", 1.0), three("ODIAG", 0.0));
        let correction =
            Correction { offset: Vector3::from(offset) * UT, matrix: Correction::symmetric(scale, off) };
        let undo = correction.inverse().ok_or_else(|| {
            Failure::usage(format!("CAL_MAG{n}_* of the log cannot be undone: its scale is not invertible"))
        })?;
        removed.push(Removed {
            from_s: since.is_finite().then_some(since),
            offset: (back * Vector3::from(offset)).into(),
            matrix: rows(&(back * correction.matrix * back.transpose())),
            power: power.is_some(),
        });
        if correction.is_identity() {
            told.push(format!("nothing: CAL_MAG{n}_* corrects nothing{from}"));
        } else {
            let gauss = |values: [f64; 3]| values.map(|v| format!("{v:.4}")).join(" ");
            told.push(format!(
                "removed the autopilot's calibration CAL_MAG{n}_*{from}: offset {} G, scale {}, off-diagonal {}",
                gauss(offset),
                gauss(scale),
                gauss(off)
            ));
        }
        epochs.push((since, undo));
    }
    let turned_back = back.transpose();
    let mut epoch = 0;
    for row in 0..stream.time_s.len() {
        let time = stream.time_s.get(row).copied().unwrap_or(f64::NAN);
        // A change is told behind the sample that it comes after.
        while epochs.get(epoch + 1).is_some_and(|(since, _)| *since < time) {
            epoch += 1;
        }
        let Some((_, undo)) = epochs.get(epoch) else { break };
        let cell = |axis: usize| stream.columns.get(axis).and_then(|c| c.values.get(row)).copied();
        let (Some(x), Some(y), Some(z)) = (cell(0), cell(1), cell(2)) else { break };
        let added = power.and_then(|power| power.get(row)).copied().unwrap_or_default();
        let raw = undo.apply(turned_back * Vector3::new(x, y, z)) - Vector3::from(added);
        for (column, value) in stream.columns.iter_mut().zip(raw.iter()) {
            if let Some(cell) = column.values.get_mut(row) {
                *cell = *value;
            }
        }
    }
    let applied = |one: &Removed| one.offset != [0.0; 3] || one.matrix != IDENTITY || one.power;
    if !removed.iter().any(applied) {
        removed.clear();
    }
    if removed.len() > MAX_REMOVED {
        removed.drain(1..=removed.len() - MAX_REMOVED);
    }
    Ok(removed)
}

/// What the compensation of throttle or current had added, µT a row; `None` where there was none.
fn power(
    stream: &Stream,
    state: State,
    n: usize,
    collectors: &[Collector],
    parameters: &Parameters,
    told: &mut Vec<String>,
) -> Option<Vec<[f64; 3]>> {
    if state != State::Corrected {
        return None;
    }
    let comp =
        parameters.three(["X", "Y", "Z"].map(|a| format!("CAL_MAG{n}_{a}COMP")), f64::NEG_INFINITY, 0.0);
    let column = |topic: &str, instance: u8, name: &str| {
        let found = collectors.iter().find(|one| one.topic == topic && one.instance == instance)?;
        let column = found.stream.column(name)?;
        let gap = gap_s(&found.stream.time_s);
        Some(at_times(&found.stream.time_s, &column.values, Between::Hold, gap, &stream.time_s))
    };
    let (signal, unit, words) = match parameters.first("CAL_MAG_COMP_TYP")? as i64 {
        1 => {
            let throttle = column("actuator_controls_0", 0, "throttle");
            (throttle.or_else(|| column("vehicle_thrust_setpoint", 0, "throttle")), 1.0, "throttle")
        }
        2 => (column("battery_status", 0, "current_a"), 1.0 / KILO, "current of battery 0"),
        3 => (column("battery_status", 1, "current_2_a"), 1.0 / KILO, "current of battery 1"),
        _ => return None,
    };
    if comp == [0.0; 3] {
        return None;
    }
    let of_power = |name: &str| {
        name == "CAL_MAG_COMP_TYP" || ["X", "Y", "Z"].iter().any(|a| name == format!("CAL_MAG{n}_{a}COMP"))
    };
    if let Some(at) = parameters.changes(of_power).first() {
        told.push(format!(
            "not the change of CAL_MAG{n}_XCOMP,… at {at:.1} s: ironout removes the first value throughout"
        ));
    }
    let Some(signal) = signal else {
        told.push(format!("not CAL_MAG{n}_XCOMP,…: its {words} is not in the log"));
        return None;
    };
    // PX4 compensates while armed only.
    let armed = column("actuator_armed", 0, "armed").or_else(|| column("vehicle_control_mode", 0, "armed"));
    told.push(format!("CAL_MAG{n}_XCOMP,…: {comp:?} G per unit of {words}, while armed"));
    let rows = signal.iter().enumerate().map(|(row, value)| {
        let on = armed.as_ref().is_none_or(|armed| armed.get(row).is_some_and(|armed| *armed > 0.0));
        let value = if on && value.is_finite() { value * unit } else { 0.0 };
        comp.map(|comp| comp * value * UT)
    });
    Some(rows.collect())
}
