//! Recordings of rosbag2 in SQLite (`.db3`): a table of topics, and one of messages as MCAP has them.

use crate::failure::{Failure, Outcome};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::ros::sqlite::{Database, Table, Value};
use crate::input::formats::ros::topics::{Raw, Topics};
use crate::input::formats::stream::Recording;
use std::collections::BTreeMap;
use std::io::Read;

/// Largest file that is taken into memory, bytes.
const LARGEST_FILE: u64 = 4 << 30;

/// A topic: name, type and form of its messages, and how many there are.
struct Topic {
    name: String,
    schema: String,
    encoding: String,
    count: u64,
}

/// Reads a `.db3` from its first byte.
///
/// # Errors
/// Not readable, another database, or no magnetometer in it.
pub fn read(source: impl Read, instance: Option<usize>) -> Outcome<Recording> {
    let mut data = Vec::new();
    source
        .take(LARGEST_FILE + 1)
        .read_to_end(&mut data)
        .map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    if data.len() as u64 > LARGEST_FILE {
        return Err(Failure::usage(
            "this bag is larger than 4 GB. Fix: convert it to MCAP, which is read piece by piece: ros2 bag convert",
        ));
    }
    let Some(database) = Database::open(&data) else {
        return Err(Failure::usage(
            "the header of this SQLite file is invalid. Fix: copy the file from the recorder again",
        ));
    };
    let (Some(topics), Some(messages)) = (database.table("topics"), database.table("messages")) else {
        return Err(Failure::usage(
            "this SQLite database is not a rosbag2 recording (it has no tables topics and messages). Fix: export its table \
             as CSV",
        ));
    };
    let mut notices = Vec::new();
    let mut known: BTreeMap<i64, Topic> = BTreeMap::new();
    let mut broken = database.each(&topics, &mut |rowid, values| {
        let text = |name: &str| cell(&topics, name, values).and_then(Value::text);
        let id = cell(&topics, "id", values).and_then(Value::int).unwrap_or(rowid);
        if let (Some(name), Some(schema)) = (text("name"), text("type")) {
            let encoding = text("serialization_format").unwrap_or_else(|| "cdr".into());
            known.insert(id, Topic { name, schema, encoding, count: 0 });
        }
    });
    let mut all = Topics::default();
    broken += database.each(&messages, &mut |_, values| {
        let topic =
            cell(&messages, "topic_id", values).and_then(Value::int).and_then(|id| known.get_mut(&id));
        let log_ns = cell(&messages, "timestamp", values).and_then(Value::int);
        let data = cell(&messages, "data", values);
        let (Some(topic), Some(log_ns), Some(Value::Bytes(data))) = (topic, log_ns, data) else {
            all.broken += 1;
            return;
        };
        topic.count += 1;
        all.take(&Raw { topic: &topic.name, schema: &topic.schema, encoding: &topic.encoding, log_ns, data });
    });
    if broken > 0 {
        notices.push(format!("skipped {broken} damaged pages or rows of the database"));
    }
    if database.has_wal {
        notices.push(
            "the last messages may be in a file of the same name with -wal at the end, which ironout does not read. Run \
             ros2 bag info on the bag to include them"
                .into(),
        );
    }
    let mut inventory = Inventory::default();
    known.values().for_each(|topic| inventory.add(&format!("{} {}", topic.name, topic.schema), topic.count));
    all.finish("rosbag2", inventory, instance, notices)
}

/// A value of a row by the name of its column. The column that numbers the rows is not in them.
fn cell<'a>(table: &Table, name: &str, values: &[Value<'a>]) -> Option<Value<'a>> {
    values.get(table.column(name)?).copied().filter(|value| *value != Value::Null)
}
