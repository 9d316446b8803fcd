//! The frames of a blackbox log.
//!
//! Betaflight and INAV keep their sensors in axes x forward, y left, z up (sensors and attitude of imu.c agree in it); the log here
//! has x forward, y right, z down, so y and z change their sign.

use crate::failure::{Failure, Outcome};
use crate::input::formats::blackbox::averages::Averages;
use crate::input::formats::blackbox::firmware::Firmware;
use crate::input::formats::blackbox::header::{MARK, generalise, lines};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::rotation::LEFT_UP;
use crate::input::formats::stream::{Between, Recording, Stream, choose};
use blackbox_log::Headers;
use blackbox_log::frame::{Frame, FrameDef, GpsValue};
use blackbox_log::prelude::ParserEvent;
use blackbox_log::units::si::length::meter;
use ironout_analysis::frame::{self, Program};
use std::collections::HashMap;
use std::io::Read;

/// Standard gravity, m/s².
const G: f64 = 9.806_65;
/// The clock of the log has 32 bits of microseconds.
const CLOCK_US: f64 = 4_294_967_296.0;

/// Reads a blackbox file; `--instance` is the session, as a file may hold several flights.
///
/// # Errors
/// Not readable, no session that can be decoded, or no magnetometer in it.
pub fn read(mut source: impl Read, instance: Option<usize>) -> Outcome<Recording> {
    let mut data = Vec::new();
    source.read_to_end(&mut data).map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    let starts: Vec<usize> = memchr::memmem::find_iter(&data, MARK).collect();
    let ends = starts.iter().skip(1).copied().chain([data.len()]);
    let sessions: Vec<(usize, usize)> = starts.iter().copied().zip(ends).collect();
    let there: Vec<(usize, String)> = sessions
        .iter()
        .enumerate()
        .map(|(number, (from, to))| (number, format!("{} kB", (to - from).div_ceil(1000))))
        .collect();
    let longest =
        sessions.iter().enumerate().max_by_key(|(index, (from, to))| (to - from, usize::MAX - index));
    let taken = choose(instance.or(longest.map(|(index, _)| index)), &there, "session")?;
    let (from, to) = sessions.get(taken).copied().unwrap_or_default();
    data.truncate(to);
    data.drain(..from);
    let other = generalise(&mut data);
    let headers = lines(&data);
    let firmware = other.clone().or_else(|| headers.get("Firmware revision").map(|name| name.to_string()));
    let named = firmware.unwrap_or_else(|| "unnamed firmware".into());
    let mut recording = Recording {
        format: format!("blackbox, {}", named.chars().take(60).collect::<String>()),
        instance: (there.len() > 1).then_some((taken, there)),
        ..Recording::default()
    };
    if other.is_some() {
        recording.notices.push(format!("{named}: ironout reads the frames as the header defines them"));
    }
    let file = blackbox_log::File::new(&data);
    let parsed = match file.parse(0) {
        Some(Ok(parsed)) => parsed,
        Some(Err(error)) => {
            return Err(Failure::usage(format!(
                "the header of this blackbox log ({named}) cannot be read: {error}. If the file was cut or edited, \
                 download it from the flight controller again"
            )));
        }
        None => return Err(Failure::usage("this blackbox log has no session")),
    };
    let firmware = Firmware::of(&named);
    frames(&parsed, &headers, &firmware, &mut recording)?;
    Ok(recording)
}

/// Where a field of the main frames goes.
struct Place {
    field: usize,
    column: usize,
    scale: f64,
}

fn frames(
    parsed: &Headers<'_>,
    headers: &HashMap<&str, &str>,
    firmware: &Firmware,
    recording: &mut Recording,
) -> Outcome<()> {
    let mut parser = parsed.data_parser();
    let names: Vec<(String, bool)> =
        parser.main_frame_def().iter().map(|field| (field.name.to_string(), field.signed)).collect();
    let gps_names: Vec<String> = parser
        .gps_frame_def()
        .map(|def| def.iter().map(|field| field.name.to_string()).collect())
        .unwrap_or_default();
    let mut averages = Averages::new(&names, headers);
    let unreadable = averages.as_ref().err().cloned().unwrap_or_default();
    if !unreadable.is_empty() {
        recording.notices.push(format!(
            "skipped, because the header does not state the interval of I frames: {}",
            unreadable.join(", ")
        ));
    }
    let (mut main, mut places) = main_stream(&names, headers, firmware);
    places.retain(|place| names.get(place.field).is_none_or(|(name, _)| !unreadable.contains(name)));
    let mut gps = Stream::new("GPS frames")
        .with("lat_deg", "GPS_coord[0]", "°", Between::Line)
        .with("lon_deg", "GPS_coord[1]", "°", Between::Circle)
        .with("gps_height_m", "GPS_altitude", "m", Between::Line);
    let mut row = vec![f64::NAN; main.columns.len()];
    let mut values: Vec<i64> = Vec::new();
    let (mut wraps, mut last) = (0.0, 0.0);
    let mut ended = false;
    while let Some(event) = parser.next() {
        match event {
            ParserEvent::Main(frame) => {
                let mut time = frame.time_raw() as f64 + wraps;
                if last - time > CLOCK_US / 2.0 {
                    wraps += CLOCK_US;
                    time += CLOCK_US;
                }
                last = time;
                values.clear();
                values.extend(frame.iter_raw().zip(&names).map(|(raw, (_, signed))| {
                    if *signed { i64::from(raw.cast_signed()) } else { i64::from(raw) }
                }));
                if let Ok(averages) = &mut averages {
                    averages.repair(&mut values);
                }
                for place in &places {
                    let value = values.get(place.field).map_or(f64::NAN, |value| *value as f64);
                    if let Some(cell) = row.get_mut(place.column) {
                        *cell = value * place.scale;
                    }
                }
                main.push(time / 1e6, &row);
            }
            ParserEvent::Gps(frame) => {
                let value = |name: &str| {
                    let at = gps_names.iter().position(|known| known == name)?;
                    Some(match frame.get(at)? {
                        GpsValue::Coordinate(degrees) if degrees != 0.0 => degrees,
                        GpsValue::Altitude(height) => height.get::<meter>(),
                        _ => f64::NAN,
                    })
                };
                let cells = ["GPS_coord[0]", "GPS_coord[1]", "GPS_altitude"]
                    .map(|name| value(name).unwrap_or(f64::NAN));
                gps.push((frame.time_raw() as f64 + wraps) / 1e6, &cells);
            }
            ParserEvent::Event(event) => ended |= matches!(event, blackbox_log::Event::End { .. }),
            ParserEvent::Slow(_) => {}
        }
    }
    if !ended {
        recording.notices.push(
            "the log has no end mark, so the recorder was interrupted. ironout read up to the last complete frame".into(),
        );
    }
    let program = if firmware.inav { Program::Inav } else { Program::Betaflight };
    finish(main, gps, parsed, program, recording)
}

/// The stream of the main frames, and where each field of them goes.
fn main_stream(
    names: &[(String, bool)],
    headers: &HashMap<&str, &str>,
    firmware: &Firmware,
) -> (Stream, Vec<Place>) {
    let acceleration =
        headers.get("acc_1G").and_then(|text| text.parse::<f64>().ok()).filter(|one| *one > 0.0);
    // Gyroscope, sticks and setpoints are logged ten times as large then (blackbox.c, blackboxHighResolutionScale).
    let high_resolution = headers
        .get("blackbox_high_resolution")
        .and_then(|text| text.parse::<i64>().ok())
        .is_some_and(|on| on > 0);
    let finer = if high_resolution { 0.1 } else { 1.0 };
    let rotation = headers.get("gyro_scale").or(headers.get("gyro.scale")).and_then(|text| {
        let bits = match text.strip_prefix("0x") {
            Some(hex) => u32::from_str_radix(hex, 16).ok()?,
            None => text.parse().ok()?,
        };
        Some(f64::from(f32::from_bits(bits))).filter(|scale| scale.is_finite() && *scale > 0.0)
    });
    let (mut stream, mut places) = (Stream::new("main frames"), Vec::new());
    for (field, (name, _)) in names.iter().enumerate() {
        let (base, index) = match name.split_once('[') {
            Some((base, rest)) => (base, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (name.as_str(), None),
        };
        let axis = index.and_then(|index| ["x", "y", "z"].get(index).copied());
        // To x forward, y right, z down.
        let sign = if axis == Some("x") { 1.0 } else { -1.0 };
        let (column, unit, scale) = match (base, axis, index) {
            ("magADC", Some(axis), _) => (format!("m{axis}_counts"), "counts", sign),
            ("gyroADC", Some(axis), _) => match rotation {
                Some(scale) => {
                    let unit = if high_resolution { "0.1 °/s" } else { "°/s" };
                    (format!("g{axis}_radps"), unit, sign * finer * scale.to_radians())
                }
                None => continue,
            },
            ("accSmooth", Some(axis), _) => match acceleration {
                Some(one) => (format!("a{axis}_mps2"), "counts of acc_1G", sign * G / one),
                None => continue,
            },
            ("motor", _, Some(index)) => (format!("motor_{}", index + 1), "", 1.0),
            ("amperageLatest" | "amperage", _, None) => match firmware.current(headers) {
                Some((unit, scale)) => ("current_a".into(), unit, scale),
                None => continue,
            },
            ("vbatLatest" | "vbat", _, None) => match firmware.voltage(headers) {
                Some((unit, scale)) => ("voltage_v".into(), unit, scale),
                None => continue,
            },
            ("baroAlt" | "BaroAlt", _, None) => ("height_m".into(), "cm", 0.01),
            ("rcCommand", _, Some(3)) => ("throttle".into(), "", finer),
            ("escTemperature", _, None) => ("esc_c".into(), "°C", 1.0),
            _ => continue,
        };
        if stream.column(&column).is_none() {
            places.push(Place { field, column: stream.columns.len(), scale });
            stream = stream.scaled(&column, name, unit, scale.abs(), Between::Line);
        }
    }
    (stream, places)
}

fn finish(
    mut main: Stream,
    gps: Stream,
    parsed: &Headers<'_>,
    program: Program,
    recording: &mut Recording,
) -> Outcome<()> {
    let field = ["mx_counts", "my_counts", "mz_counts"];
    let measured = field
        .iter()
        .all(|name| main.column(name).is_some_and(|column| column.values.iter().any(|value| *value != 0.0)));
    if !measured {
        let mut inventory = Inventory::default();
        let frames = main.time_s.len() as u64;
        parsed.main_frame_def().iter().for_each(|field| inventory.add(field.name, frames));
        let zero = if main.column("mx_counts").is_some() { " with a value in it (all are zero)" } else { "" };
        return Err(inventory.no_magnetometer(
            &format!("magADC[0], magADC[1], magADC[2]{zero}"),
            "Betaflight: set mag_hardware, and fields_disabled_mask without MAG; INAV: blackbox MAG.",
        ));
    }
    recording.taken_out.push("rotated from x forward, y left, z up to x forward, y right, z down".into());
    recording.notices.push(
        "magADC is already aligned to the vehicle and corrected by the firmware (mag_calibration; INAV: maggain too). The \
         log does not contain these parameters, so add the exported numbers to the present ones"
            .into(),
    );
    // Rows of the magnetometer and of the rest are the same frames: nothing has to be joined.
    main.columns
        .sort_by_key(|column| field.iter().position(|name| *name == column.name).unwrap_or(field.len()));
    recording.magnetometer = main;
    recording.frame = frame::Frame::of(program, 1.0, LEFT_UP);
    recording.others = vec![gps];
    Ok(())
}
