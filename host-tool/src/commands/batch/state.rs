//! What is done already: a file next to the table, one line per log as soon as it is done.

use crate::atomic;
use crate::cli::BatchArgs;
use crate::commands::batch::row::Row;
use crate::failure::{Failure, Outcome};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// A log as it was when it was studied, and by which program with which options.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Stamp {
    bytes: u64,
    changed_ns: String,
    program: String,
    options: String,
}

#[derive(Serialize, Deserialize)]
struct Line {
    path: String,
    stamp: Stamp,
    row: Row,
}

/// The logs that are done, in a file that grows by one line per log.
pub(super) struct State {
    done: BTreeMap<String, (Stamp, Row)>,
    file: File,
    path: PathBuf,
    options: String,
}

/// The file of the state of a table.
pub(super) fn path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_os_string();
    name.push(".state");
    PathBuf::from(name)
}

impl State {
    /// Opens the state of a table; `again` forgets it. A last line that was cut off counts as not written.
    pub fn open(arguments: &BatchArgs) -> Outcome<State> {
        let path = path(&arguments.output);
        let fail = |error: std::io::Error| Failure::io("write", &path, &error);
        let mut done = BTreeMap::new();
        if !arguments.again
            && let Ok(text) = std::fs::read_to_string(&path)
        {
            let lines = text.lines().filter_map(|line| serde_json::from_str::<Line>(line).ok());
            done.extend(lines.map(|line| (line.path, (line.stamp, line.row))));
        }
        // Written again, without what was cut off and each log once; until that is whole the old file stands.
        let options = options(arguments);
        atomic::write(&path, |out| {
            done.iter().try_for_each(|(log, (stamp, row))| {
                write_line(out, &Line { path: log.clone(), stamp: stamp.clone(), row: row.clone() })
            })
        })?;
        let file = File::options().append(true).open(&path).map_err(fail)?;
        Ok(State { done, file, path, options })
    }

    /// The stamp of a log as it is now; `None` if it cannot be seen.
    pub fn stamp(&self, log: &Path) -> Option<Stamp> {
        let data = std::fs::metadata(log).ok()?;
        let changed = data.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(Stamp {
            bytes: data.len(),
            changed_ns: changed.as_nanos().to_string(),
            program: env!("CARGO_PKG_VERSION").to_string(),
            options: self.options.clone(),
        })
    }

    /// The row of a log, if it was studied as it is now.
    pub fn done(&self, log: &Path) -> Option<Row> {
        let (stamp, row) = self.done.get(&key(log))?;
        (self.stamp(log).as_ref() == Some(stamp)).then(|| row.clone())
    }

    /// Keeps a row. `stamp` is that of before the study: a log that changed meanwhile is studied again.
    pub fn keep(&mut self, log: &Path, stamp: Option<Stamp>, row: &Row) -> Outcome<()> {
        let Some(stamp) = stamp else { return Ok(()) };
        write_line(&mut self.file, &Line { path: key(log), stamp, row: row.clone() })
            .map_err(|error| Failure::io("write", &self.path, &error))
    }
}

fn write_line(file: &mut dyn Write, line: &Line) -> std::io::Result<()> {
    let mut text = serde_json::to_string(line)?;
    text.push('\n');
    // In one write: another process that reads sees whole lines.
    file.write_all(text.as_bytes())
}

fn key(log: &Path) -> String {
    log.canonicalize().unwrap_or_else(|_| log.to_path_buf()).to_string_lossy().into_owned()
}

/// The options that change rows.
fn options(arguments: &BatchArgs) -> String {
    let log = &arguments.log;
    format!(
        "{:?}",
        (
            (
                &log.ut_per_count,
                &log.map,
                &log.rotate,
                log.instance,
                &log.derive,
                &log.ignore,
                &log.repair,
                &log.date
            ),
            (arguments.field.field, &arguments.field.at, arguments.field.method),
            &arguments.vehicle_from,
        )
    )
}
