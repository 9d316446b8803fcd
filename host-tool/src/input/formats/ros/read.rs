//! The records of an MCAP file as messages of topics.

use crate::failure::Outcome;
use crate::input::formats::feed::Feed;
use crate::input::formats::inventory::Inventory;
use crate::input::formats::ros::records::{self, Channel, op};
use crate::input::formats::ros::topics::{Raw, Topics};
use crate::input::formats::stream::Recording;
use std::collections::BTreeMap;
use std::io::Read;

/// What is known while a file is read.
#[derive(Default)]
struct File {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    counts: BTreeMap<u16, u64>,
    topics: Topics,
}

/// Reads an MCAP file from its first byte; `size_bytes` (0: unknown) bounds what it may ask memory for.
///
/// # Errors
/// Not readable, or no magnetometer in it.
pub fn read(feed: &mut Feed<impl Read>, size_bytes: u64, instance: Option<usize>) -> Outcome<Recording> {
    let mut file = File::default();
    let notices = records::records(feed, size_bytes, &mut |kind, content| file.take(kind, content))?;
    let mut inventory = Inventory::default();
    for (id, count) in &file.counts {
        if let Some(channel) = file.channels.get(id) {
            let schema = file.schemas.get(&channel.schema).map_or("without a schema", String::as_str);
            inventory.add(&format!("{} {schema}", channel.topic), *count);
        }
    }
    file.topics.finish("MCAP", inventory, instance, notices)
}

impl File {
    fn take(&mut self, kind: u8, content: &[u8]) {
        match kind {
            op::SCHEMA => self.schemas.extend(records::schema(content)),
            op::CHANNEL => self.channels.extend(records::channel(content)),
            op::MESSAGE => match records::message(content) {
                Some((channel, log_ns, data)) => self.message(channel, log_ns, data),
                None => self.topics.broken += 1,
            },
            _ => {}
        }
    }

    fn message(&mut self, id: u16, log_ns: i64, data: &[u8]) {
        let Some(channel) = self.channels.get(&id) else {
            self.topics.broken += 1;
            return;
        };
        *self.counts.entry(id).or_default() += 1;
        let Some(schema) = self.schemas.get(&channel.schema) else { return };
        self.topics.take(&Raw { topic: &channel.topic, schema, encoding: &channel.encoding, log_ns, data });
    }
}
