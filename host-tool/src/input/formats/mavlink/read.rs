//! The messages of a telemetry log that are read (mavlink common.xml), and whose compasses they are of.
//!
//! What an autopilot sends is its own corrected field in body axes. ArduPilot's parameters, which ground stations ask for at each
//! connection, say what it had applied, and that is taken out.

use crate::failure::Outcome;
use crate::input::formats::dataflash;
use crate::input::formats::feed::{Feed, bytes_at};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::mavlink::packet::{MOST_BYTES, Packet};
use crate::input::formats::parameters::Parameters;
use crate::input::formats::stream::{Between, Recording, Stream, choose};
use ironout_analysis::frame::{Frame, IDENTITY, Program};
use std::collections::BTreeMap;
use std::io::Read;

/// Standard gravity, m/s².
const G: f64 = 9.806_65;
/// Microtesla in a milligauss and in a gauss.
const MILLIGAUSS_UT: f64 = 0.1;
const GAUSS_UT: f64 = 100.0;
/// Times since boot are shorter; a time in µs beyond it is one since 1970.
const MAX_BOOT_S: f64 = 1e9;
/// More vehicles and sensors than any log has.
const MOST_STREAMS: usize = 256;
/// `MAV_AUTOPILOT_ARDUPILOTMEGA` and `MAV_AUTOPILOT_PX4`.
const ARDUPILOT: u8 = 3;
const PX4: u8 = 12;

const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];
const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];

/// A kind of message: number, name, the number of its definition in the checksum, and bytes of its payload with all extensions.
struct Kind {
    id: u32,
    name: &'static str,
    extra: u8,
    bytes: usize,
}

const KINDS: [Kind; 12] = [
    Kind { id: 0, name: "HEARTBEAT", extra: 50, bytes: 9 },
    Kind { id: 1, name: "SYS_STATUS", extra: 124, bytes: 43 },
    Kind { id: 22, name: "PARAM_VALUE", extra: 220, bytes: 25 },
    Kind { id: 26, name: "SCALED_IMU", extra: 170, bytes: 24 },
    Kind { id: 27, name: "RAW_IMU", extra: 144, bytes: 29 },
    Kind { id: 30, name: "ATTITUDE", extra: 39, bytes: 28 },
    Kind { id: 33, name: "GLOBAL_POSITION_INT", extra: 104, bytes: 28 },
    Kind { id: 74, name: "VFR_HUD", extra: 20, bytes: 20 },
    Kind { id: 105, name: "HIGHRES_IMU", extra: 93, bytes: 63 },
    Kind { id: 116, name: "SCALED_IMU2", extra: 76, bytes: 24 },
    Kind { id: 129, name: "SCALED_IMU3", extra: 46, bytes: 24 },
    Kind { id: 147, name: "BATTERY_STATUS", extra: 154, bytes: 54 },
];

/// Whose stream it is: vehicle and part of it, number of the message, number of the sensor in it.
type Key = ([u8; 2], u32, u8);

/// What was collected.
#[derive(Default)]
struct Collected {
    streams: BTreeMap<Key, Stream>,
    /// Times at which streams without a time of their own were received.
    autopilots: BTreeMap<[u8; 2], u8>,
    parameters: BTreeMap<[u8; 2], Parameters>,
    inventory: Inventory,
    /// By how much the ground station's clock is ahead of each vehicle's, s: the least that was seen, as packets only come late.
    ahead_s: BTreeMap<[u8; 2], f64>,
    received: Vec<Key>,
    first_us: Option<u64>,
}

/// Reads a telemetry log from its first byte.
///
/// # Errors
/// Not readable, or no magnetometer in it.
pub fn read(feed: &mut Feed<impl Read>, instance: Option<usize>) -> Outcome<Recording> {
    let mut all = Collected::default();
    let (mut skipped, mut spoilt) = (0_u64, 0_u64);
    loop {
        let ahead = feed.ahead(MOST_BYTES)?;
        if ahead.is_empty() {
            break;
        }
        let Some(packet) = Packet::at(ahead) else {
            skipped += 1;
            feed.pass(1);
            continue;
        };
        let length = packet.length;
        match KINDS.iter().find(|kind| kind.id == packet.id) {
            Some(kind) if packet.is_whole(kind.extra) => all.take(kind, &packet),
            Some(_) => {
                // What follows may be a packet that begins inside this one.
                spoilt += 1;
                feed.pass(1);
                continue;
            }
            None => all.inventory.add(&format!("message {}", packet.id), 1),
        }
        feed.pass(length);
    }
    let mut notices = Vec::new();
    if skipped + spoilt > 0 {
        notices.push(format!(
            "skipped {} bytes outside complete packets ({spoilt} wrong checksums)",
            skipped + spoilt
        ));
    }
    finish(all, instance, notices)
}

/// Little-endian numbers of a payload, whose zeros at the end may be missing.
struct Payload([u8; 64]);

impl Payload {
    fn i16(&self, at: usize) -> f64 {
        bytes_at(&self.0, at).map_or(f64::NAN, |bytes| f64::from(i16::from_le_bytes(bytes)))
    }

    fn u16(&self, at: usize) -> f64 {
        bytes_at(&self.0, at).map_or(f64::NAN, |bytes| f64::from(u16::from_le_bytes(bytes)))
    }

    fn i32(&self, at: usize) -> f64 {
        bytes_at(&self.0, at).map_or(f64::NAN, |bytes| f64::from(i32::from_le_bytes(bytes)))
    }

    fn f32(&self, at: usize) -> f64 {
        bytes_at(&self.0, at).map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(bytes)))
    }

    fn ms(&self) -> Option<f64> {
        Some(f64::from(u32::from_le_bytes(bytes_at(&self.0, 0)?)) / 1e3)
    }

    fn us(&self) -> Option<f64> {
        Some(u64::from_le_bytes(bytes_at(&self.0, 0)?) as f64 / 1e6)
    }

    fn u8(&self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }
}

impl Collected {
    fn take(&mut self, kind: &Kind, packet: &Packet<'_>) {
        self.inventory.add(kind.name, 1);
        let mut payload = Payload([0; 64]);
        let sent = packet.payload.len().min(kind.bytes);
        if let (Some(into), Some(from)) = (payload.0.get_mut(..sent), packet.payload.get(..sent)) {
            into.copy_from_slice(from);
        }
        let p = &payload;
        let first_us = *self.first_us.get_or_insert(packet.stamp_us);
        let stamp_s = packet.stamp_us.wrapping_sub(first_us).cast_signed() as f64 / 1e6;
        // The part of a vehicle that flies it numbers its sensors; what others of it say is apart.
        let system = packet.system;
        match kind.name {
            "HEARTBEAT" => {
                self.autopilots.entry(system).or_insert(p.u8(5));
            }
            "PARAM_VALUE" => {
                let name = packet.payload.get(8..24.min(packet.payload.len())).unwrap_or_default();
                let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
                if let (Ok(name), value) = (std::str::from_utf8(name), p.f32(0))
                    && value.is_finite()
                {
                    self.parameters.entry(system).or_default().set(name, stamp_s, value);
                }
            }
            "RAW_IMU" | "SCALED_IMU" | "SCALED_IMU2" | "SCALED_IMU3" => {
                let raw = kind.name == "RAW_IMU";
                let (time, at) = if raw { (p.us(), 8) } else { (p.ms(), 4) };
                let three = |from: usize, scale: f64| [0, 2, 4].map(|axis| p.i16(at + from + axis) * scale);
                // A compass that is not there reads zero.
                let [x, y, z] = three(12, MILLIGAUSS_UT);
                let field = if [x, y, z] == [0.0; 3] { [f64::NAN; 3] } else { [x, y, z] };
                let warm = p.i16(if raw { 27 } else { 22 });
                let warm = if warm == 0.0 { f64::NAN } else { warm / 100.0 };
                let id = if raw { p.u8(26) } else { 0 };
                let values: Vec<f64> =
                    field.into_iter().chain(three(0, G / 1e3)).chain(three(6, 1e-3)).chain([warm]).collect();
                self.push((system, kind.id, id), time, stamp_s, &values, || {
                    imu(kind.name, id, ["mG", "mg", "mrad/s"], MILLIGAUSS_UT)
                });
            }
            "HIGHRES_IMU" => {
                let three = |from: usize, scale: f64| [0, 4, 8].map(|axis| p.f32(from + axis) * scale);
                let [x, y, z] = three(32, GAUSS_UT);
                let field = if [x, y, z] == [0.0; 3] { [f64::NAN; 3] } else { [x, y, z] };
                let id = p.u8(62);
                let values: Vec<f64> =
                    field.into_iter().chain(three(8, 1.0)).chain(three(20, 1.0)).chain([p.f32(56)]).collect();
                self.push((system, kind.id, id), p.us(), stamp_s, &values, || {
                    imu(kind.name, id, ["G", "m/s²", "rad/s"], GAUSS_UT)
                });
            }
            "ATTITUDE" => {
                let values = [16, 20, 24].map(|at| p.f32(at));
                self.push((system, kind.id, 0), p.ms(), stamp_s, &values, || {
                    GYRO.iter().zip(["rollspeed", "pitchspeed", "yawspeed"]).fold(
                        Stream::new("ATTITUDE"),
                        |stream, (name, field)| {
                            stream.with(name, &format!("ATTITUDE.{field}"), "rad/s", Between::Line)
                        },
                    )
                });
            }
            "GLOBAL_POSITION_INT" => {
                let place = |at: usize| if p.i32(at) == 0.0 { f64::NAN } else { p.i32(at) * 1e-7 };
                let values = [place(4), place(8), p.i32(12) / 1e3];
                self.push((system, kind.id, 0), p.ms(), stamp_s, &values, || {
                    Stream::new("GLOBAL_POSITION_INT")
                        .scaled("lat_deg", "GLOBAL_POSITION_INT.lat", "1e-7 °", 1e-7, Between::Line)
                        .scaled("lon_deg", "GLOBAL_POSITION_INT.lon", "1e-7 °", 1e-7, Between::Circle)
                        .scaled("gps_height_m", "GLOBAL_POSITION_INT.alt", "mm", 1e-3, Between::Line)
                });
            }
            "VFR_HUD" => {
                let values = [p.f32(8), p.u16(18) / 100.0];
                self.push((system, kind.id, 0), None, stamp_s, &values, || {
                    Stream::new("VFR_HUD").with("height_m", "VFR_HUD.alt", "m", Between::Line).scaled(
                        "throttle",
                        "VFR_HUD.throttle",
                        "%",
                        0.01,
                        Between::Line,
                    )
                });
            }
            "BATTERY_STATUS" => {
                let known =
                    |value: f64, none: f64, scale: f64| if value == none { f64::NAN } else { value * scale };
                let id = p.u8(32);
                let values = [known(p.i16(30), -1.0, 0.01), known(p.i16(8), 32767.0, 0.01)];
                self.push((system, kind.id, id), None, stamp_s, &values, || {
                    let more = if id == 0 { String::new() } else { format!("_{}", u16::from(id) + 1) };
                    let name = format!("BATTERY_STATUS[{id}]");
                    Stream::new(name.as_str())
                        .scaled(
                            &format!("current{more}_a"),
                            &format!("{name}.current_battery"),
                            "0.01 A",
                            0.01,
                            Between::Line,
                        )
                        .scaled(
                            &format!("battery{more}_c"),
                            &format!("{name}.temperature"),
                            "0.01 °C",
                            0.01,
                            Between::Line,
                        )
                });
            }
            "SYS_STATUS" => {
                let values = [
                    if p.u16(14) == 65535.0 { f64::NAN } else { p.u16(14) / 1e3 },
                    if p.i16(16) == -1.0 { f64::NAN } else { p.i16(16) / 100.0 },
                ];
                self.push((system, kind.id, 0), None, stamp_s, &values, || {
                    Stream::new("SYS_STATUS")
                        .scaled("voltage_v", "SYS_STATUS.voltage_battery", "mV", 1e-3, Between::Line)
                        .scaled("current_a", "SYS_STATUS.current_battery", "0.01 A", 0.01, Between::Line)
                });
            }
            _ => {}
        }
    }

    /// One sample at its own time, or at the one at which it was received.
    fn push(
        &mut self,
        key: Key,
        own_s: Option<f64>,
        stamp_s: f64,
        values: &[f64],
        new: impl FnOnce() -> Stream,
    ) {
        if !self.streams.contains_key(&key) && self.streams.len() >= MOST_STREAMS {
            return;
        }
        let boot_s = own_s.filter(|time| *time > 0.0 && *time < MAX_BOOT_S);
        match boot_s {
            Some(boot_s) => {
                let ahead = self.ahead_s.entry(key.0).or_insert(f64::INFINITY);
                *ahead = ahead.min(stamp_s - boot_s);
            }
            None if !self.received.contains(&key) => self.received.push(key),
            None => {}
        }
        self.streams.entry(key).or_insert_with(new).push(boot_s.unwrap_or(stamp_s), values);
    }
}

fn imu(message: &str, id: u8, units: [&str; 3], scale_ut: f64) -> Stream {
    let name = if id == 0 { message.to_string() } else { format!("{message}[{id}]") };
    let triples =
        [(FIELD, "mag", units[0], scale_ut), (ACCEL, "acc", units[1], 1.0), (GYRO, "gyro", units[2], 1.0)];
    let scale = |what: &str, scale: f64| match (what, units[1]) {
        ("acc", "mg") => G / 1e3,
        ("gyro", "mg") => 1e-3,
        _ => scale,
    };
    triples
        .iter()
        .flat_map(|(names, what, unit, own)| {
            names.iter().zip(["x", "y", "z"]).map(move |(column, axis)| (column, axis, what, unit, own))
        })
        .fold(Stream::new(name.as_str()), |stream, (column, axis, what, unit, own)| {
            stream.scaled(column, &format!("{name}.{axis}{what}"), unit, scale(what, *own), Between::Line)
        })
        .with("imu_c", &format!("{name}.temperature"), "°C", Between::Line)
}

fn finish(mut all: Collected, instance: Option<usize>, notices: Vec<String>) -> Outcome<Recording> {
    // What was received without a time goes on the clock of its vehicle.
    for key in &all.received {
        let ahead = all.ahead_s.get(&key.0).copied().filter(|ahead| ahead.is_finite()).unwrap_or(0.0);
        if let Some(stream) = all.streams.get_mut(key) {
            stream.time_s.iter_mut().for_each(|time| *time -= ahead);
        }
    }
    let measures = |stream: &Stream| {
        stream.column(FIELD[0]).is_some_and(|column| column.values.iter().any(|value| value.is_finite()))
    };
    let keys: Vec<Key> =
        all.streams.iter().filter(|(_, stream)| measures(stream)).map(|(key, _)| *key).collect();
    let several = keys.iter().any(|key| Some(key.0) != keys.first().map(|first| first.0));
    let there: Vec<(usize, String)> = keys
        .iter()
        .map(|key| {
            let stream = all.streams.get(key);
            let (name, samples) =
                stream.map_or(("", 0), |stream| (stream.name.as_str(), stream.time_s.len()));
            let of = if several { format!(" of vehicle {}", key.0[0]) } else { String::new() };
            format!("{name}{of}, {samples} samples")
        })
        .enumerate()
        .collect();
    let most = keys.iter().enumerate().max_by_key(|(index, key)| {
        (all.streams.get(*key).map_or(0, |stream| stream.time_s.len()), usize::MAX - index)
    });
    if keys.is_empty() {
        return Err(all.inventory.no_magnetometer(
            "RAW_IMU, SCALED_IMU, SCALED_IMU2, SCALED_IMU3, HIGHRES_IMU with a compass",
            "ArduPilot sends them with SR0_RAW_SENS (SR1_…) above 0; the vehicle's own log (.bin, .ulg) has more samples.",
        ));
    }
    let taken = choose(instance.or(most.map(|(index, _)| index)), &there, "magnetometer")?;
    let Some(key) = keys.get(taken).copied() else { return Ok(Recording::default()) };
    let autopilot = all.autopilots.get(&key.0).copied();
    let (program, name) = match autopilot {
        Some(ARDUPILOT) => (Program::Ardupilot, "ArduPilot"),
        Some(PX4) => (Program::Px4, "PX4"),
        _ => (Program::Other, "unnamed autopilot"),
    };
    let mut recording = Recording {
        format: format!("MAVLink telemetry, {name}"),
        instance: (there.len() > 1).then_some((taken, there)),
        notices,
        ..Recording::default()
    };
    let vehicle = key.0[0];
    for (own, mut stream) in std::mem::take(&mut all.streams) {
        if own == key {
            recording.magnetometer = stream;
            continue;
        }
        // Another compass is none of the columns, and another vehicle none of the log.
        stream.columns.retain(|column| !FIELD.contains(&column.name.as_str()));
        if own.0[0] == vehicle && !stream.columns.is_empty() {
            recording.others.push(stream);
        }
    }
    let unit = recording.magnetometer.column(FIELD[0]).map_or(1.0, |column| column.scale);
    recording.frame = Frame::of(program, unit, IDENTITY);
    let number = match key.1 {
        116 => 1,
        129 => 2,
        _ => usize::from(key.2),
    };
    let parameters = all.parameters.remove(&key.0).unwrap_or_default();
    if program == Program::Ardupilot && dataflash::has_offsets(number, &parameters) {
        dataflash::undo(number, &parameters, &mut recording)?;
        recording.notices.push(
            "telemetry does not contain ArduPilot's motor compensation. Record with COMPASS_MOTCT 0, or use the vehicle's \
             own log (.bin)"
                .into(),
        );
    } else {
        recording.notices.push(format!(
            "{} is already corrected by the autopilot, and the log does not contain its calibration parameters, so a \
             calibration of this log applies on top of them. Fix: use the vehicle's own log (.bin, .ulg)",
            recording.magnetometer.name
        ));
    }
    Ok(recording)
}
