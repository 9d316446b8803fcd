//! The records of a ULog file.

use crate::failure::{Failure, Outcome};
use crate::input::formats::feed::{Feed, bytes_at, u16_at, u64_at};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::parameters::Parameters;
use crate::input::formats::rotation;
use crate::input::formats::stream::{Recording, Stream, without_course};
use crate::input::formats::ulog::collector::Collector;
use crate::input::formats::ulog::layout::Formats;
use crate::input::formats::ulog::magnetometer;
use crate::input::formats::ulog::topics::{place, wants};
use std::io::Read;

const HEADER_BYTES: usize = 16;
const RECORD_BYTES: usize = 3;
const KINDS: &[u8] = b"BFIMPQARDLCSO";
/// The content of a synchronisation record.
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// `MAV_TYPE` of a rover, and the airframes (`SYS_AUTOSTART`) that are rovers.
const GROUND_ROVER: f64 = 10.0;
const ROVER_FRAMES: std::ops::Range<f64> = 50_000.0..60_000.0;
/// More topics with instances than any vehicle has.
const MOST_TOPICS: usize = 4096;

/// What is known of one topic of the log.
struct Topic {
    message: u16,
    name: String,
    instance: u8,
    messages: u64,
    collector: Option<usize>,
}

/// The state of reading.
#[derive(Default)]
struct Log {
    start_us: u64,
    now_s: Option<f64>,
    formats: Formats,
    topics: Vec<Topic>,
    /// Index into `topics` by message id.
    by_message: Vec<Option<u32>>,
    collectors: Vec<Collector>,
    parameters: Parameters,
    system: [Option<String>; 2],
    vehicle: Option<String>,
    release: Option<[u8; 2]>,
    dropouts: u64,
    dropout_ms: u64,
    broken: u64,
    appended_at: Option<u64>,
}

/// Reads a ULog from its first byte.
///
/// # Errors
/// It cannot be read, is of a kind that only a newer reader understands, or has no magnetometer.
pub fn read(feed: &mut Feed<impl Read>, instance: Option<usize>) -> Outcome<Recording> {
    let header = feed.ahead(HEADER_BYTES)?;
    let Some(start_us) = u64_at(header, 8) else {
        return Err(Failure::usage("this ULog ends in its header: the recording was never written"));
    };
    feed.pass(HEADER_BYTES);
    let mut log = Log { start_us, ..Log::default() };
    let mut notices = Vec::new();
    loop {
        if let Some(at) = log.appended_at
            && feed.position() < at
            && record_crosses(feed, at)?
        {
            // What was appended after a crash begins here; the record before it was never finished.
            let rest = usize::try_from(at - feed.position()).unwrap_or(usize::MAX);
            feed.pass(rest);
        }
        let head = feed.ahead(RECORD_BYTES)?;
        let (Some(size), Some(kind)) = (u16_at(head, 0), head.get(2).copied()) else {
            if !head.is_empty() {
                notices.push(cut_off(feed.position()));
            }
            break;
        };
        if !KINDS.contains(&kind) {
            let from = feed.position();
            let found = resynchronise(feed)?;
            let until = if found { "the next synchronisation" } else { "the end" };
            notices.push(format!("byte {from}: not a ULog record; skipped everything up to {until}"));
            continue;
        }
        let whole = RECORD_BYTES + usize::from(size);
        let record = feed.ahead(whole)?;
        let Some(data) = record.get(RECORD_BYTES..whole) else {
            notices.push(cut_off(feed.position()));
            break;
        };
        log.take(kind, data)?;
        feed.pass(whole);
    }
    log.finish(instance, notices)
}

fn cut_off(position: u64) -> String {
    format!("the file is truncated inside a record (byte {position}). ironout read up to there")
}

fn record_crosses(feed: &mut Feed<impl Read>, at: u64) -> Outcome<bool> {
    let position = feed.position();
    let size = u16_at(feed.ahead(RECORD_BYTES)?, 0).map_or(0, u64::from);
    Ok(position + RECORD_BYTES as u64 + size > at)
}

/// Passes to the next synchronisation record; false at the end of the file.
fn resynchronise(feed: &mut Feed<impl Read>) -> Outcome<bool> {
    const LOOK: usize = 1 << 16;
    loop {
        let ahead = feed.ahead(LOOK)?;
        let length = ahead.len();
        match memchr::memmem::find(ahead, &SYNC) {
            Some(at) => {
                feed.pass(at + SYNC.len());
                return Ok(true);
            }
            None if length < LOOK => {
                feed.pass(length);
                return Ok(false);
            }
            None => feed.pass(length - SYNC.len()),
        }
    }
}

impl Log {
    fn take(&mut self, kind: u8, data: &[u8]) -> Outcome<()> {
        match kind {
            b'D' => self.data(data),
            b'F' => self.broken += u64::from(!self.formats.define(data)),
            b'A' => self.subscribe(data),
            b'P' => self.parameter(data),
            b'B' => self.flags(data)?,
            b'I' => self.information(data),
            b'O' => {
                self.dropouts += 1;
                self.dropout_ms += u64::from(u16_at(data, 0).unwrap_or(0));
            }
            _ => {}
        }
        Ok(())
    }

    fn data(&mut self, data: &[u8]) {
        let topic = u16_at(data, 0)
            .and_then(|message| self.by_message.get(usize::from(message)).copied().flatten())
            .and_then(|index| self.topics.get_mut(index as usize));
        let Some(topic) = topic else {
            self.broken += 1;
            return;
        };
        topic.messages += 1;
        let body = data.get(2..).unwrap_or_default();
        if let Some(collector) = topic.collector.and_then(|index| self.collectors.get_mut(index)) {
            match collector.push(body, self.start_us) {
                Some(time) => self.now_s = Some(time),
                None => self.broken += 1,
            }
        }
    }

    fn subscribe(&mut self, data: &[u8]) {
        let (Some(&instance), Some(message), Some(name)) = (data.first(), u16_at(data, 1), data.get(3..))
        else {
            self.broken += 1;
            return;
        };
        let name = String::from_utf8_lossy(name).into_owned();
        let known = self.topics.iter().position(|topic| topic.name == name && topic.instance == instance);
        if known.is_none() && self.topics.len() >= MOST_TOPICS {
            self.broken += 1;
            return;
        }
        let index = known.unwrap_or(self.topics.len());
        if known.is_none() {
            let wanted = if place(&name).is_some() { wants(&name, instance) } else { Vec::new() };
            let collector = (!wanted.is_empty())
                .then(|| self.formats.layout(&name))
                .flatten()
                .and_then(|layout| Collector::new(&name, instance, &layout, &wanted));
            let collector = collector.map(|collector| {
                self.collectors.push(collector);
                self.collectors.len() - 1
            });
            self.topics.push(Topic { message, name, instance, messages: 0, collector });
        } else if let Some(topic) = self.topics.get_mut(index) {
            topic.message = message;
        }
        let slot = usize::from(message);
        if self.by_message.len() <= slot {
            self.by_message.resize(slot + 1, None);
        }
        if let Some(entry) = self.by_message.get_mut(slot) {
            *entry = u32::try_from(index).ok();
        }
    }

    /// `type name` and the value, as in information and parameter records.
    fn key(data: &[u8]) -> Option<(&str, &str, &[u8])> {
        let length = usize::from(*data.first()?);
        let key = std::str::from_utf8(data.get(1..1 + length)?).ok()?;
        let (kind, name) = key.split_once(' ')?;
        Some((kind, name, data.get(1 + length..)?))
    }

    fn parameter(&mut self, data: &[u8]) {
        let value = Self::key(data).and_then(|(kind, name, value)| {
            let bits = bytes_at(value, 0)?;
            match kind {
                "int32_t" => Some((name, f64::from(i32::from_le_bytes(bits)))),
                "float" => Some((name, f64::from(f32::from_le_bytes(bits)))),
                _ => None,
            }
        });
        match value {
            Some((name, value)) => self.parameters.set(name, self.now_s.unwrap_or(f64::NEG_INFINITY), value),
            None => self.broken += 1,
        }
    }

    fn information(&mut self, data: &[u8]) {
        let Some((_, name, value)) = Self::key(data) else { return };
        let slot = match name {
            "sys_name" => 0,
            "ver_hw" => 1,
            "sys_uuid" => {
                self.vehicle = Some(printable(value)).filter(|id| !id.is_empty());
                return;
            }
            "ver_sw_release" => {
                // Patch and type of the release in the lower bytes.
                self.release = bytes_at::<4>(value, 0).map(|[_, _, minor, major]| [major, minor]);
                return;
            }
            _ => return,
        };
        let text = printable(value);
        if let Some(slot) = self.system.get_mut(slot) {
            *slot = Some(text);
        }
    }

    fn flags(&mut self, data: &[u8]) -> Outcome<()> {
        let incompatible = data.get(8..16).unwrap_or_default();
        let unknown = incompatible.iter().enumerate().any(|(index, flags)| match index {
            0 => flags & !1 != 0,
            _ => *flags != 0,
        });
        if unknown {
            return Err(Failure::usage(
                "this ULog needs a newer reader (incompatible flags). Convert it to CSV with the tool of its autopilot",
            ));
        }
        self.appended_at = u64_at(data, 16).filter(|at| *at > 0);
        Ok(())
    }

    fn finish(mut self, instance: Option<usize>, mut notices: Vec<String>) -> Outcome<Recording> {
        let mut inventory = Inventory::default();
        for topic in &self.topics {
            inventory.add(&format!("{}[{}]", topic.name, topic.instance), topic.messages);
        }
        let Some(mut recording) =
            magnetometer::take(&mut self.collectors, &self.parameters, self.release, instance)?
        else {
            return Err(inventory.no_magnetometer(
                "sensor_mag, vehicle_magnetometer, sensor_combined.magnetometer_ga",
                "PX4 logs the magnetometer with SDLOG_PROFILE bit 0 (default) or 5 (high rate sensors).",
            ));
        };
        if self.dropouts > 0 {
            notices.push(format!(
                "the logger lost data {}, {:.1} s in all",
                if self.dropouts == 1 { "once".into() } else { format!("{} times", self.dropouts) },
                self.dropout_ms as f64 / 1e3
            ));
        }
        if self.broken > 0 {
            notices.push(format!("skipped {} unreadable records", self.broken));
        }
        let release = self.release.map(|[major, minor]| format!("release {major}.{minor}"));
        recording.format = ["PX4 ULog".to_string()]
            .into_iter()
            .chain(self.system.into_iter().flatten())
            .chain(release)
            .collect::<Vec<_>>()
            .join(", ");
        self.collectors.sort_by_key(|one| (place(&one.topic), one.instance));
        let others = self
            .collectors
            .into_iter()
            .filter(|one| one.stream.column("armed").is_none())
            .map(|one| turned(one, &self.parameters, &mut recording.taken_out))
            .collect::<Vec<_>>();
        recording.others.splice(..0, others);
        let on_wheels = self.parameters.first("MAV_TYPE") == Some(GROUND_ROVER)
            || self.parameters.first("SYS_AUTOSTART").is_some_and(|frame| ROVER_FRAMES.contains(&frame));
        if !on_wheels {
            without_course(&mut recording.others);
        }
        recording.notices.extend(notices);
        recording.vehicle = self.vehicle;
        Ok(recording)
    }
}

fn printable(value: &[u8]) -> String {
    String::from_utf8_lossy(value).chars().filter(|c| !c.is_control()).take(40).collect()
}

/// Raw accelerometers and gyroscopes of the board stand in the board's mounting.
fn turned(collector: Collector, parameters: &Parameters, told: &mut Vec<String>) -> Stream {
    let mut stream = collector.stream;
    let names = match collector.topic.as_str() {
        "sensor_accel" => ["ax_mps2", "ay_mps2", "az_mps2"],
        "sensor_gyro" => ["gx_radps", "gy_radps", "gz_radps"],
        _ => return stream,
    };
    let board = parameters.first("SENS_BOARD_ROT").unwrap_or(0.0) as i64;
    let angles = rotation::angles_deg(board).unwrap_or_default();
    if angles != [0.0; 3] && !stream.time_s.is_empty() {
        stream.turn(names, &rotation::matrix(angles));
        told.push(format!(
            "{}: rotated by SENS_BOARD_ROT = {board}: {}",
            stream.name,
            rotation::words(angles)
        ));
    }
    stream
}
