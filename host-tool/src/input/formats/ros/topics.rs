//! The topics of a recording of ROS, whatever file they are from.

use crate::failure::{Failure, Outcome};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::ros::cdr::Encoding;
use crate::input::formats::ros::messages::{Kind, TESLA_UT};
use crate::input::formats::rotation::LEFT_UP;
use crate::input::formats::stream::{Recording, Stream, choose};
use ironout_analysis::frame::{Frame, IDENTITY, Program};
use std::collections::BTreeMap;

/// More topics of these kinds than any robot has.
const MOST_TOPICS: usize = 1024;
/// Longest message that is packed by itself, bytes once unpacked.
const LARGEST_MESSAGE: u64 = 1 << 20;
/// Mark of Zstandard, which rosbag2 packs messages with one by one.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// One topic that is read.
struct Topic {
    kind: Kind,
    frame: Option<String>,
    stream: Stream,
    log_ns: Vec<i64>,
    stamp_ns: Vec<i64>,
}

/// A message as a file holds it.
pub struct Raw<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// The name of its schema.
    pub schema: &'a str,
    /// How it is written: `cdr`, `ros1`.
    pub encoding: &'a str,
    /// When it was recorded.
    pub log_ns: i64,
    /// Its bytes.
    pub data: &'a [u8],
}

/// All topics of a recording.
#[derive(Default)]
pub struct Topics {
    topics: BTreeMap<String, Topic>,
    /// Messages that are not as their schema says.
    pub broken: u64,
    other_encoding: Option<String>,
}

impl Topics {
    /// Takes one message.
    pub fn take(&mut self, raw: &Raw<'_>) {
        let Some(kind) = Kind::of(raw.schema) else { return };
        let encoding = match raw.encoding {
            "cdr" => Encoding::Cdr,
            "ros1" => Encoding::Ros1,
            other => {
                self.other_encoding = Some(other.chars().take(40).collect());
                return;
            }
        };
        let unpacked = raw.data.starts_with(&ZSTD).then(|| unpacked(raw.data)).flatten();
        let Some(decoded) = kind.decode(unpacked.as_deref().unwrap_or(raw.data), encoding) else {
            self.broken += 1;
            return;
        };
        let name = raw.topic;
        if !self.topics.contains_key(name) {
            if self.topics.len() >= MOST_TOPICS {
                return;
            }
            let number = self.topics.values().filter(|topic| topic.kind == kind).count();
            let topic = Topic {
                kind,
                frame: Some(decoded.frame.clone()).filter(|frame| !frame.is_empty()),
                stream: kind.stream(name, number),
                log_ns: Vec::new(),
                stamp_ns: Vec::new(),
            };
            self.topics.insert(name.to_string(), topic);
        }
        if let Some(topic) = self.topics.get_mut(name).filter(|topic| topic.kind == kind) {
            topic.log_ns.push(raw.log_ns);
            topic.stamp_ns.push(decoded.stamp_ns);
            topic.stream.push(0.0, &decoded.values);
        }
    }

    /// The recording of a `format`, with what is to be said of the file.
    ///
    /// # Errors
    /// No magnetometer in it, or not the one asked for.
    pub fn finish(
        self,
        format: &str,
        inventory: Inventory,
        instance: Option<usize>,
        notices: Vec<String>,
    ) -> Outcome<Recording> {
        let mut recording = Recording { format: format.into(), notices, ..Recording::default() };
        if self.broken > 0 {
            recording
                .notices
                .push(format!("skipped {} messages that do not match their schema", self.broken));
        }
        if let Some(encoding) = &self.other_encoding {
            recording.notices.push(format!(
                "skipped messages in the encoding {encoding}; ironout reads cdr (ROS 2) and ros1"
            ));
        }
        finish(self.topics, inventory, instance, recording)
    }
}

fn unpacked(data: &[u8]) -> Option<Vec<u8>> {
    use std::io::Read;
    let mut out = Vec::new();
    let decoder = ruzstd::decoding::StreamingDecoder::new(data).ok()?;
    decoder.take(LARGEST_MESSAGE).read_to_end(&mut out).ok()?;
    Some(out)
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
    recording.format = format!("{}, {clock}", recording.format);
    recording.instance = (magnetometers.len() > 1).then_some((taken, magnetometers));
    for mut topic in topics {
        let turned = turn(&mut topic, &mut recording.taken_out);
        if topic.kind == Kind::Imu && topic.frame != frame {
            let named = |frame: &Option<String>| frame.clone().unwrap_or_else(|| "no frame".into());
            recording.notices.push(format!(
                "{} is in frame {}, the magnetometer in {}. ironout assumes that they are parallel. If not, use --rotate \
                 accel:… gyro:…",
                topic.stream.name,
                named(&topic.frame),
                named(&frame)
            ));
        }
        match topic.kind {
            Kind::MagneticField => {
                recording.magnetometer = topic.stream;
                recording.frame = Frame::of(Program::Ros, TESLA_UT, turned);
            }
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

/// Axes of ROS to those of the log, unless the frame's name says that it has them already. Gives the rotation.
fn turn(topic: &mut Topic, told: &mut Vec<String>) -> [[f64; 3]; 3] {
    let triples: &[[&str; 3]] = match topic.kind {
        Kind::MagneticField => &[["mx_ut", "my_ut", "mz_ut"]],
        Kind::Imu => &[["gx_radps", "gy_radps", "gz_radps"], ["ax_mps2", "ay_mps2", "az_mps2"]],
        _ => return IDENTITY,
    };
    let frame = topic.frame.as_deref().unwrap_or("without a name");
    let down =
        frame.to_lowercase().split(|c: char| !c.is_ascii_alphanumeric()).any(|w| w == "ned" || w == "frd");
    if down {
        told.push(format!("nothing: {}, frame {frame}, has x forward, y right, z down", topic.stream.name));
        return IDENTITY;
    }
    for names in triples {
        topic.stream.turn(*names, &LEFT_UP);
    }
    told.push(format!(
        "{}, frame {frame}: rotated from x forward, y left, z up (REP 103) to x forward, y right, z down",
        topic.stream.name
    ));
    LEFT_UP
}
