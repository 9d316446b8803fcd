//! A DataFlash log as text: a line a message, `FMT` lines that say what the cells are.

use crate::failure::Outcome;
use crate::input::formats::dataflash::collect::{Collected, Plan};
use crate::input::formats::dataflash::compass;
use crate::input::formats::dataflash::definition::Definition;
use crate::input::formats::feed::Feed;
use crate::input::formats::stream::Recording;
use crate::input::number;
use std::collections::HashMap;
use std::io::Read;

/// The longest line; a message has some tens of cells.
const LINE_BYTES: usize = 1 << 14;
/// ArduPilot knows so many kinds of message.
const MOST_KINDS: usize = 256;

/// What FMT lines have defined, what is read of it, and how often it came.
type Definitions = HashMap<String, (Definition, Option<Plan>, u64)>;

/// Reads a `.log` from its first byte.
///
/// # Errors
/// It cannot be read, or has no magnetometer.
pub fn read_text(feed: &mut Feed<impl Read>, instance: Option<usize>) -> Outcome<Recording> {
    let mut definitions = Definitions::new();
    let mut collected = Collected::printed();
    let (mut strange, mut first_strange, mut line) = (0_u64, 0_u64, 0_u64);
    loop {
        let ahead = feed.ahead(LINE_BYTES)?;
        if ahead.is_empty() {
            break;
        }
        line += 1;
        let (end, length) = match memchr::memchr(b'\n', ahead) {
            Some(end) => (end, end + 1),
            None => (ahead.len(), ahead.len()),
        };
        let text = ahead.get(..end).unwrap_or_default();
        if !text.trim_ascii().is_empty() && !message(text, &mut definitions, &mut collected) {
            strange += 1;
            first_strange = if strange == 1 { line } else { first_strange };
        }
        feed.pass(length);
    }
    for (name, (_, _, count)) in &definitions {
        collected.inventory.add(name, *count);
    }
    let mut notices = Vec::new();
    if strange > 0 {
        notices.push(format!(
            "skipped {strange} lines that are not messages defined by FMT lines (first: line {first_strange})"
        ));
    }
    compass::finish(collected, "ArduPilot DataFlash as text", instance, notices)
}

/// Takes one line; false where it is none that was defined, or has not the cells that were.
fn message(text: &[u8], definitions: &mut Definitions, collected: &mut Collected) -> bool {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let cells: Vec<&[u8]> = text.split(|byte| *byte == b',').map(<[u8]>::trim_ascii).collect();
    let Some((name, cells)) = cells.split_first() else { return false };
    let words = |cell: &[u8]| String::from_utf8_lossy(cell).into_owned();
    if *name == b"FMT" {
        let [kind, _, name, letters, labels @ ..] = cells else { return false };
        let kind = std::str::from_utf8(kind).ok().and_then(|text| text.parse().ok()).unwrap_or(0);
        let labels = labels.iter().map(|label| words(label)).collect::<Vec<_>>().join(",");
        // The length is that of the binary form, and of no use here.
        let definition = Definition::new(kind, &words(name), &words(letters), &labels, usize::MAX);
        let known = definitions.len() < MOST_KINDS;
        return match definition {
            Some(definition) if known => {
                let plan = Plan::of(&definition);
                definitions.insert(definition.name.clone(), (definition, plan, 0));
                true
            }
            _ => false,
        };
    }
    let Ok(name) = std::str::from_utf8(name) else { return false };
    let Some((definition, plan, count)) = definitions.get_mut(name) else { return false };
    // A line that was cut off has fewer cells; text of messages may hold commas.
    if cells.len() < definition.labels.len() {
        return false;
    }
    *count += 1;
    if let Some(plan) = plan {
        let number = |field: usize| cells.get(field).and_then(|cell| number::parse(cell)).unwrap_or(f64::NAN);
        collected.take(plan, number, |field| cells.get(field).map_or_else(String::new, |cell| words(cell)));
    }
    true
}
