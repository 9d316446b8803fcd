//! The binary messages of a DataFlash log.

use crate::failure::Outcome;
use crate::input::formats::dataflash::collect::{Collected, Plan};
use crate::input::formats::dataflash::compass;
use crate::input::formats::dataflash::definition::{Definition, FMT, HEADER_BYTES};
use crate::input::formats::feed::Feed;
use crate::input::formats::stream::Recording;
use std::io::Read;

const MARKS: [u8; 2] = [0xa3, 0x95];

/// Reads a `.bin` from its first byte.
///
/// # Errors
/// It cannot be read, or has no magnetometer.
pub fn read_binary(feed: &mut Feed<impl Read>, instance: Option<usize>) -> Outcome<Recording> {
    let mut definitions: Vec<Option<(Definition, Option<Plan>)>> = vec![None; 256];
    let mut counts = vec![0_u64; 256];
    let mut collected = Collected::default();
    let mut notices = Vec::new();
    let (mut skipped, mut places) = (0_u64, 0_u64);
    loop {
        let head = feed.ahead(HEADER_BYTES)?;
        let kind = match head {
            [a, b, kind] if [*a, *b] == MARKS => *kind,
            [] => break,
            [_, _, _] => {
                skipped += pass_to_mark(feed)?;
                places += 1;
                continue;
            }
            _ => {
                notices.push(cut_off(feed.position()));
                break;
            }
        };
        let length = match definitions.get(usize::from(kind)) {
            _ if kind == FMT.0 => FMT.1,
            Some(Some((definition, _))) => definition.length,
            _ => {
                feed.pass(1);
                skipped += 1 + pass_to_mark(feed)?;
                places += 1;
                continue;
            }
        };
        let message = feed.ahead(length)?;
        let Some(body) = message.get(HEADER_BYTES..length) else {
            notices.push(cut_off(feed.position()));
            break;
        };
        if kind == FMT.0 {
            if let Some((kind, definition)) = Definition::from_fmt(body)
                && let Some(slot) = definitions.get_mut(usize::from(kind))
            {
                *slot = definition.map(|definition| {
                    let plan = Plan::of(&definition);
                    (definition, plan)
                });
            }
        } else if let Some(Some((definition, plan))) = definitions.get(usize::from(kind)) {
            if let Some(plan) = plan {
                let number = |field| definition.number(body, field);
                collected.take(plan, number, |field| definition.text(body, field));
            }
            if let Some(count) = counts.get_mut(usize::from(kind)) {
                *count += 1;
            }
        }
        feed.pass(length);
    }
    for (definition, count) in definitions.iter().zip(&counts) {
        if let Some((definition, _)) = definition {
            collected.inventory.add(&definition.name, *count);
        }
    }
    if places > 0 {
        notices.push(format!("skipped {skipped} bytes in {places} places that are not messages"));
    }
    compass::finish(collected, "ArduPilot DataFlash", instance, notices)
}

fn cut_off(position: u64) -> String {
    format!("the file is truncated inside a message (byte {position}). ironout read up to there")
}

/// Passes to the next mark, or the end; gives how many bytes.
fn pass_to_mark(feed: &mut Feed<impl Read>) -> Outcome<u64> {
    const LOOK: usize = 1 << 16;
    let mut passed = 0;
    loop {
        let ahead = feed.ahead(LOOK)?;
        let length = ahead.len();
        let found = memchr::memmem::find(ahead, &MARKS);
        // A first mark at the end of what is seen may have its second behind it.
        let step = found.unwrap_or(if length < LOOK { length } else { length - 1 });
        feed.pass(step);
        passed += step as u64;
        if found.is_some() || length < LOOK {
            return Ok(passed);
        }
    }
}
