//! Messages of ROS in CDR of both byte orders and in the packed form of ROS 1, and MCAP files of them.

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::Cursor;

/// How messages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Little,
    Big,
    Ros1,
}

/// Writes one message.
pub struct Message {
    form: Form,
    bytes: Vec<u8>,
}

impl Message {
    /// Its header.
    pub fn new(form: Form, stamp_ns: u64, frame: &str) -> Self {
        let mut message = Message { form, bytes: Vec::new() };
        if form == Form::Ros1 {
            message.number(77_u32.to_le_bytes());
        }
        message.number(((stamp_ns / 1_000_000_000) as u32).to_le_bytes());
        message.number(((stamp_ns % 1_000_000_000) as u32).to_le_bytes());
        let zero = usize::from(form != Form::Ros1);
        message.number(((frame.len() + zero) as u32).to_le_bytes());
        message.bytes.extend(frame.bytes());
        message.bytes.extend(&[0][..zero]);
        message
    }

    /// A number in little-endian bytes.
    pub fn number<const N: usize>(&mut self, mut bytes: [u8; N]) {
        if self.form != Form::Ros1 {
            while !self.bytes.len().is_multiple_of(N) {
                self.bytes.push(0);
            }
        }
        if self.form == Form::Big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    #[must_use]
    pub fn doubles(mut self, values: &[f64]) -> Self {
        values.iter().for_each(|value| self.number(value.to_le_bytes()));
        self
    }

    #[must_use]
    pub fn floats(mut self, values: &[f32]) -> Self {
        values.iter().for_each(|value| self.number(value.to_le_bytes()));
        self
    }

    pub fn finish(self) -> Vec<u8> {
        let mut bytes = match self.form {
            Form::Little => vec![0, 1, 0, 0],
            Form::Big => vec![0, 0, 0, 0],
            Form::Ros1 => Vec::new(),
        };
        bytes.extend(self.bytes);
        bytes
    }
}

/// An MCAP file that is written by the library of the format.
pub struct File {
    writer: Writer<Cursor<Vec<u8>>>,
    form: Form,
    channels: BTreeMap<String, u16>,
    sequence: u32,
}

impl File {
    pub fn new(form: Form, compression: Option<Compression>) -> Self {
        let writer = WriteOptions::new()
            .compression(compression)
            .chunk_size(Some(1 << 14))
            .profile("ros2")
            .create(Cursor::new(Vec::new()))
            .expect("memory can be written");
        File { writer, form, channels: BTreeMap::new(), sequence: 0 }
    }

    #[cfg(feature = "emulated")]
    pub fn form(&self) -> Form {
        self.form
    }

    pub fn write(&mut self, topic: &str, kind: &str, log_ns: u64, data: &[u8]) {
        let (package, encoding, schema_encoding) = match self.form {
            Form::Ros1 => ("sensor_msgs", "ros1", "ros1msg"),
            _ => ("sensor_msgs/msg", "cdr", "ros2msg"),
        };
        if !self.channels.contains_key(topic) {
            let schema =
                self.writer.add_schema(&format!("{package}/{kind}"), schema_encoding, b"").expect("a schema");
            let channel =
                self.writer.add_channel(schema, topic, encoding, &BTreeMap::new()).expect("a channel");
            self.channels.insert(topic.into(), channel);
        }
        self.sequence += 1;
        let header = MessageHeader {
            channel_id: self.channels[topic],
            sequence: self.sequence,
            log_time: log_ns,
            publish_time: log_ns,
        };
        self.writer.write_to_known_channel(&header, data).expect("memory can be written");
    }

    pub fn finish(mut self) -> Vec<u8> {
        self.writer.finish().expect("memory can be written");
        self.writer.into_inner().into_inner()
    }
}
