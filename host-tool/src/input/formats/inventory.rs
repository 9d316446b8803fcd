//! What a file holds, for the error where it has no magnetometer.

use crate::failure::Failure;

/// At most so many names are listed.
const LISTED: usize = 40;
/// Width of the lines of a message.
const WIDTH: usize = 100;

/// Messages by name, counted.
#[derive(Debug, Clone, Default)]
pub struct Inventory {
    counts: Vec<(String, u64)>,
}

impl Inventory {
    /// Adds `count` messages of a name.
    pub fn add(&mut self, name: &str, count: u64) {
        match self.counts.iter_mut().find(|(known, _)| known == name) {
            Some((_, known)) => *known += count,
            None => self.counts.push((name.to_string(), count)),
        }
    }

    /// The error for a log without a magnetometer: what was looked for, what is there.
    pub fn no_magnetometer(mut self, looked_for: &str, remedy: &str) -> Failure {
        self.counts.retain(|(_, count)| *count > 0);
        self.counts.sort();
        let mut message = format!("no magnetometer in the log. Looked for: {looked_for}.\n");
        if self.counts.is_empty() {
            message.push_str("It contains no data.");
        } else {
            message.push_str("It contains (messages in brackets):");
            let mut width = WIDTH;
            for (name, count) in self.counts.iter().take(LISTED) {
                let item = format!(" {name} ({count})");
                if width + item.len() > WIDTH {
                    message.push_str("\n ");
                    width = 1;
                }
                width += item.len();
                message.push_str(&item);
            }
            if self.counts.len() > LISTED {
                message.push_str(&format!(" and {} more", self.counts.len() - LISTED));
            }
        }
        message.push('\n');
        message.push_str(remedy);
        Failure::usage(message)
    }
}
