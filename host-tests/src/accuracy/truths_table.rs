//! The table of harder truths as a whole: measured, as text, as JSON, and kept beside its snapshot.

use crate::accuracy::injected::Source;
use crate::accuracy::truths::{MEASURED_ON, Outcome, json, rates, run, text, times};
use crate::measured;
use ironout_simulation::truths::Kind;
use serde_json::Value;
use std::io;
use std::path::PathBuf;

/// Logs of each kind behind the snapshot.
pub const LOGS: u64 = 40;

/// A figure may differ from its snapshot by so many logs: another host's last digits decide some of them otherwise.
const SLACK: u64 = 3;

/// Every kind with its logs.
pub struct Truths {
    kinds: Vec<(Kind, Vec<Outcome>)>,
    recordings: Vec<(Source, Vec<Outcome>)>,
}

impl Truths {
    /// Runs `logs` logs of each kind, none of those that thresholds were tuned on.
    pub fn measure(logs: u64) -> Self {
        let kinds = Kind::ALL.iter().map(|kind| (*kind, run(*kind, MEASURED_ON, 0..logs, |_| {})));
        let recordings = Source::ALL.iter().map(|source| (*source, source.run(logs, |_| {})));
        Truths { kinds: kinds.collect(), recordings: recordings.collect() }
    }

    /// What the snapshot holds.
    pub fn text(&self) -> String {
        let made = self.kinds.iter().map(|(kind, list)| text(*kind, list));
        made.chain(self.recordings.iter().map(|(source, list)| source.text(list))).collect()
    }

    /// Median, 90 % and worst time of a diagnosis, in words: no snapshot holds them.
    pub fn times(&self) -> String {
        let lists =
            self.kinds.iter().map(|(_, list)| list).chain(self.recordings.iter().map(|(_, list)| list));
        let all: Vec<Outcome> = lists.flatten().cloned().collect();
        let [median, most, worst] = times(&all);
        format!(
            "time of a diagnosis: median {median:.2} s, 90 % {most:.1} s, worst {worst:.1} s of {} logs",
            all.len()
        )
    }

    /// One object a figure.
    pub fn json(&self) -> Value {
        let made = self.kinds.iter().map(|(kind, list)| json(kind.name(), rates(*kind, list)));
        let recorded = self.recordings.iter().filter(|(_, list)| !list.is_empty());
        made.chain(recorded.map(|(source, list)| json(source.name(), source.rates(list)))).collect()
    }

    /// Where the snapshot lies.
    pub fn snapshot_path() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/truths.txt"))
    }

    /// Holds the figures to the snapshot's, but for a few logs.
    ///
    /// # Errors
    /// The snapshot cannot be read, or figures differ: then the message has them.
    pub fn hold(&self) -> io::Result<()> {
        let path = Self::snapshot_path();
        let at = |error: String| io::Error::other(format!("{}: {error}", path.display()));
        let stored = std::fs::read_to_string(&path).map_err(|error| at(error.to_string()))?;
        let is_here = self.recordings.iter().any(|(_, list)| !list.is_empty());
        if !is_here {
            eprintln!("SKIPPED: the recordings are not here, and so are no effects put into them");
        }
        let stored: String =
            stored.split_inclusive('\n').filter(|line| is_here || !line.starts_with("real-")).collect();
        let found = differences(&stored, &self.text());
        if found.is_empty() { Ok(()) } else { Err(at(found.join("\n"))) }
    }

    /// Writes the snapshot, and the table of the document of measurements.
    ///
    /// # Errors
    /// A file that cannot be written, or a document without the table's markers.
    pub fn store(&self) -> io::Result<()> {
        let text = self.text();
        std::fs::write(Self::snapshot_path(), &text)?;
        measured::write(&[("accuracy-truths", text)])
    }
}

/// What a line says of how many: its words, `count` and `of`.
fn figure(line: &str) -> Option<(String, u64, u64)> {
    let (words, _) = line.split_once(" (")?;
    let (rest, of) = words.rsplit_once(" of ")?;
    let (what, count) = rest.trim_end().rsplit_once(' ')?;
    Some((what.trim().to_string(), count.parse().ok()?, of.trim().parse().ok()?))
}

/// The figures that differ by more than a few logs.
fn differences(stored: &str, text: &str) -> Vec<String> {
    let figures = |text: &str| -> Vec<Option<(String, u64, u64)>> { text.lines().map(figure).collect() };
    let (old, new) = (figures(stored), figures(text));
    if old.len() != new.len() {
        return vec![format!("{} figures instead of {}", new.len(), old.len())];
    }
    let pairs = old.iter().zip(&new).zip(stored.lines().zip(text.lines()));
    let differ = pairs.filter(|((old, new), _)| match (old, new) {
        (Some(old), Some(new)) => old.0 != new.0 || old.2 != new.2 || old.1.abs_diff(new.1) > SLACK,
        _ => true,
    });
    differ.map(|(_, (old, new))| format!("- {old}\n+ {new}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_logs_are_chance_and_more_are_a_difference() {
        let stored = "one   named first   19 of 20 (76.4 to 99.1 %)\n";
        for (text, differ) in [
            ("one   named first   17 of 20 (60.0 to 99.1 %)\n", 0),
            ("one   named first   15 of 20 (60.0 to 99.1 %)\n", 1),
            ("one   exactly   19 of 20 (76.4 to 99.1 %)\n", 1),
            ("", 1),
        ] {
            assert_eq!(differences(stored, text).len(), differ, "{text}");
        }
    }
}
