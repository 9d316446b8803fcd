//! The topics of an MCAP file.

use crate::failure::{Failure, Outcome};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::mcap::cdr::Encoding;
use crate::input::formats::mcap::messages::Kind;
use crate::input::formats::stream::{Recording, Stream, choose};
use crate::progress::Progress;
use mcap::McapError;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use std::collections::BTreeMap;
use std::io::Read;

/// The largest record, bytes: a picture of a camera beside the sensors, and no more than memory bears.
const LARGEST_RECORD: usize = 1 << 28;
/// More topics of these kinds than any robot has.
const MOST_TOPICS: usize = 1024;
/// From x forward, y left, z up (ROS REP 103) to x forward, y right, z down.
const TURN: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];

/// One topic that is read.
struct Topic {
    kind: Kind,
    frame: Option<String>,
    stream: Stream,
    log_ns: Vec<i64>,
    stamp_ns: Vec<i64>,
}

/// Reads an MCAP file from its first byte.
///
/// # Errors
/// Not readable, or no magnetometer in it.
pub fn read(source: impl Read, progress: Progress, instance: Option<usize>) -> Outcome<Recording> {
    let options = LinearReaderOptions::default().with_record_length_limit(LARGEST_RECORD);
    let source = Counted { source, progress, read: 0 };
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut inventory = Inventory::default();
    let (mut broken, mut other_encoding) = (0_u64, None);
    let mut recording = Recording { format: "MCAP".into(), ..Recording::default() };
    for message in MessageReader::new_with_options(source, options) {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                recording.notices.push(stopped(&error));
                break;
            }
        };
        let schema = message.channel.schema.as_ref().map_or("no schema", |schema| schema.name.as_str());
        let name = &message.channel.topic;
        inventory.add(&format!("{name} {schema}"), 1);
        let Some(kind) = Kind::of(schema) else { continue };
        let encoding = match message.channel.message_encoding.as_str() {
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            other => {
                other_encoding = Some(other.to_string());
                continue;
            }
        };
        let Some(decoded) = kind.decode(&message.data, encoding) else {
            broken += 1;
            continue;
        };
        if !topics.contains_key(name) {
            if topics.len() >= MOST_TOPICS {
                continue;
            }
            let number = topics.values().filter(|topic| topic.kind == kind).count();
            let topic = Topic {
                kind,
                frame: Some(decoded.frame.clone()).filter(|frame| !frame.is_empty()),
                stream: kind.stream(name, number),
                log_ns: Vec::new(),
                stamp_ns: Vec::new(),
            };
            topics.insert(name.clone(), topic);
        }
        let Some(topic) = topics.get_mut(name).filter(|topic| topic.kind == kind) else { continue };
        topic.log_ns.push(message.log_time.cast_signed());
        topic.stamp_ns.push(decoded.stamp_ns);
        topic.stream.push(0.0, &decoded.values);
    }
    if broken > 0 {
        recording.notices.push(format!("{broken} messages are not as their schema says and are left out"));
    }
    if let Some(encoding) = other_encoding {
        recording
            .notices
            .push(format!("messages in the encoding {encoding} are left out: cdr (ROS 2) and ros1 are read"));
    }
    finish(topics, inventory, instance, recording)
}

/// Why reading ended before the end.
fn stopped(error: &McapError) -> String {
    match error {
        McapError::UnexpectedEof | McapError::UnexpectedEoc => {
            "the file is cut off inside a record: read up to there".into()
        }
        error => format!("the file is broken ({error}): read up to there"),
    }
}

fn finish(
    topics: BTreeMap<String, Topic>,
    inventory: Inventory,
    instance: Option<usize>,
    mut recording: Recording,
) -> Outcome<Recording> {
    let mut topics: Vec<Topic> = topics.into_values().collect();
    let magnetometers: Vec<(usize, String)> = topics
        .iter()
        .filter(|topic| topic.kind == Kind::MagneticField)
        .map(|topic| format!("{}, {} messages", topic.stream.name, topic.log_ns.len()))
        .enumerate()
        .collect();
    if magnetometers.is_empty() {
        let failure = inventory.no_magnetometer(
            "topics of sensor_msgs/msg/MagneticField (ROS 2, CDR) or sensor_msgs/MagneticField (ROS 1)",
            "Record the topic of the magnetometer too: ros2 bag record -s mcap TOPIC …",
        );
        let told =
            recording.notices.iter().fold(failure.message, |message, notice| format!("{message}\n{notice}"));
        return Err(Failure::usage(told));
    }
    let taken = choose(instance, &magnetometers, "MagneticField topic")?;
    let mut number = 0;
    let mut chosen = None;
    topics.retain(|topic| {
        topic.kind != Kind::MagneticField || {
            number += 1;
            let own = number - 1 == taken;
            if own {
                chosen = Some(topic.stream.name.clone());
            }
            own
        }
    });
    let frame =
        topics.iter().find(|topic| topic.kind == Kind::MagneticField).and_then(|topic| topic.frame.clone());
    one_imu(&mut topics, frame.as_deref(), &mut recording.notices);
    let clock = times(&mut topics);
    recording.format = format!("MCAP, {clock}");
    recording.instance = (magnetometers.len() > 1).then_some((taken, magnetometers));
    for mut topic in topics {
        turn(&mut topic, &mut recording.taken_out);
        if topic.kind == Kind::Imu && topic.frame != frame {
            let named = |frame: &Option<String>| frame.clone().unwrap_or_else(|| "no frame".into());
            recording.notices.push(format!(
                "{} is in frame {}, the magnetometer in {}: taken as parallel; if they are not, say --rotate accel:… gyro:…",
                topic.stream.name,
                named(&topic.frame),
                named(&frame)
            ));
        }
        match topic.kind {
            Kind::MagneticField => recording.magnetometer = topic.stream,
            _ => recording.others.push(topic.stream),
        }
    }
    Ok(recording)
}

/// Of several IMUs that in the magnetometer's frame, else the one with the most messages.
fn one_imu(topics: &mut Vec<Topic>, frame: Option<&str>, notices: &mut Vec<String>) {
    let imus = || topics.iter().filter(|topic| topic.kind == Kind::Imu);
    let best = imus()
        .max_by_key(|topic| (topic.frame.is_some() && topic.frame.as_deref() == frame, topic.log_ns.len()))
        .map(|topic| topic.stream.name.clone());
    let others: Vec<String> =
        imus().map(|topic| topic.stream.name.clone()).filter(|name| Some(name) != best.as_ref()).collect();
    let Some(best) = best else { return };
    if !others.is_empty() {
        notices.push(format!("of several IMUs {best} is read; not {}", others.join(", ")));
    }
    topics.retain(|topic| topic.kind != Kind::Imu || topic.stream.name == best);
}

/// Sets the times: `header.stamp` where every message has one, else the time at which messages were recorded. In words.
fn times(topics: &mut [Topic]) -> &'static str {
    let stamped = topics.iter().all(|topic| topic.stamp_ns.iter().all(|stamp| *stamp != 0));
    let clock = |topic: &Topic| if stamped { topic.stamp_ns.clone() } else { topic.log_ns.clone() };
    let first = topics.iter().filter_map(|topic| clock(topic).iter().min().copied()).min().unwrap_or(0);
    for topic in topics {
        topic.stream.time_s = clock(topic).iter().map(|time| time.wrapping_sub(first) as f64 / 1e9).collect();
    }
    if stamped { "times of header.stamp" } else { "times of recording (not every message has a stamp)" }
}

/// Axes of ROS to those of the log, unless the frame's name says that it has them already.
fn turn(topic: &mut Topic, told: &mut Vec<String>) {
    let triples: &[[&str; 3]] = match topic.kind {
        Kind::MagneticField => &[["mx_ut", "my_ut", "mz_ut"]],
        Kind::Imu => &[["gx_radps", "gy_radps", "gz_radps"], ["ax_mps2", "ay_mps2", "az_mps2"]],
        _ => return,
    };
    let frame = topic.frame.as_deref().unwrap_or("without a name");
    let down =
        frame.to_lowercase().split(|c: char| !c.is_ascii_alphanumeric()).any(|w| w == "ned" || w == "frd");
    if down {
        told.push(format!("nothing: {}, frame {frame}, has x forward, y right, z down", topic.stream.name));
        return;
    }
    for names in triples {
        topic.stream.turn(*names, &TURN);
    }
    told.push(format!(
        "{}, frame {frame}: turned from x forward, y left, z up (REP 103) to x forward, y right, z down",
        topic.stream.name
    ));
}

/// Follows how much was read.
struct Counted<R> {
    source: R,
    progress: Progress,
    read: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.source.read(buffer)?;
        self.read += count as u64;
        self.progress.at(self.read);
        Ok(count)
    }
}
