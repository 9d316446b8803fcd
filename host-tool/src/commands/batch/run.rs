//! All logs by several threads; each row is kept as soon as it is there.

use crate::cli::BatchArgs;
use crate::commands::batch::files::{Found, find};
use crate::commands::batch::origin::Pattern;
use crate::commands::batch::page;
#[cfg(feature = "parquet")]
use crate::commands::batch::parquet::write_parquet;
use crate::commands::batch::row::{Row, write_csv, write_json_lines};
use crate::commands::batch::state::{self, Stamp, State};
use crate::commands::batch::study::{Asked, study};
use crate::commands::batch::words;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::output;
use crate::{atomic, progress::Progress};
use ironout_analysis::fleet::summary::ERROR;
use ironout_analysis::fleet::{FleetLog, summarize};
use serde_json::json;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// How long a row is waited for before Ctrl-C is looked at again.
const PATIENCE: Duration = Duration::from_millis(100);

/// A log that a thread is to study.
struct Task {
    /// Its place in the table.
    place: usize,
    found: Found,
    stamp: Option<Stamp>,
}

/// Studies all logs, writes the table, and says what they have in common.
pub fn run(arguments: &BatchArgs, as_json: bool) -> Outcome<u8> {
    let began = Instant::now();
    if output::is_standard(&arguments.output) {
        return Err(Failure::usage("-o -: the table is updated as logs are done. Fix: name a file with -o"));
    }
    let write = writer(&arguments.output)?;
    let asked = Asked {
        reading: arguments.log.clone(),
        expected: arguments.field.expected()?,
        method: arguments.field.method_with(&[], None)?,
        pattern: arguments.vehicle_from.as_deref().map(Pattern::parse).transpose()?,
    };
    // Wrong options are an error of the command, not one row per log.
    asked.reading.options()?;
    let named: Vec<PathBuf> = arguments.log.logs().cloned().collect();
    let logs = find(&named, &[arguments.output.clone(), state::path(&arguments.output)])?;
    for target in std::iter::once(&arguments.output).chain(&arguments.page) {
        logs.iter().try_for_each(|log| atomic::not_over(&log.path, target))?;
    }
    if logs.is_empty() {
        return Err(Failure::usage("no log found. Fix: name a folder with logs, a quoted pattern, or logs"));
    }
    let mut state = State::open(arguments)?;
    let interrupt = Interrupt::noted()?;
    let mut rows: Vec<Option<Row>> = Vec::new();
    let mut tasks = Vec::new();
    for (place, found) in logs.into_iter().enumerate() {
        let row = state.done(&found.path);
        if row.is_none() {
            tasks.push(Task { place, stamp: state.stamp(&found.path), found });
        }
        rows.push(row);
    }
    let known = rows.len() - tasks.len();
    if known > 0 {
        eprintln!("{known} of {} logs were studied before and have not changed", rows.len());
    }
    let interrupted = work(tasks, asked, arguments.jobs, &interrupt, |task, row| {
        state.keep(&task.found.path, task.stamp.clone(), &row)?;
        rows[task.place] = Some(row);
        Ok(())
    })?;
    let done: Vec<&Row> = rows.iter().flatten().collect();
    atomic::write(&arguments.output, |out| write(out, &done))?;
    let fleet_logs: Vec<FleetLog> = done.iter().map(|row| row.fleet_log()).collect();
    let fleet = summarize(&fleet_logs);
    if let Some(path) = &arguments.page {
        atomic::write(path, |out| out.write_all(page::html(&fleet).as_bytes()))?;
    }
    let failed = done.iter().filter(|row| row.verdict == ERROR).count();
    if as_json {
        let mut object = json!({
            "output": arguments.output.display().to_string(), "logs": rows.len(), "done": done.len(),
            "studied": done.len() - known, "failed": failed, "interrupted": interrupted,
            "took_s": began.elapsed().as_secs_f64(),
        });
        let summary = serde_json::to_value(&fleet).map_err(|error| Failure::usage(error.to_string()))?;
        if let Some(map) = object.as_object_mut() {
            map.insert("summary".into(), summary);
        }
        output::line(&object.to_string());
    } else {
        output::text(&words::text(&fleet));
        output::line(&format!("\nwrote {} ({} rows)", arguments.output.display(), done.len()));
        if let Some(path) = &arguments.page {
            output::line(&format!("wrote {}", path.display()));
        }
    }
    if interrupted {
        eprintln!(
            "interrupted: {} of {} logs are done and kept. Fix: run the same command again to study the rest",
            done.len(),
            rows.len()
        );
    }
    Ok(if interrupted || failed == done.len() { EXIT_REFUSED } else { EXIT_OK })
}

/// Writes rows as a table.
type Writer = fn(&mut dyn Write, &[&Row]) -> io::Result<()>;

/// What writes a table into a file of that name.
fn writer(output: &Path) -> Outcome<Writer> {
    let extension = output.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("jsonl" | "ndjson") => Ok(write_json_lines),
        #[cfg(feature = "parquet")]
        Some("parquet" | "pq") => Ok(write_parquet),
        #[cfg(not(feature = "parquet"))]
        Some("parquet" | "pq") => Err(Failure::usage(
            "this build of ironout cannot write Parquet. Fix: install it with cargo install --path host-tool --features \
             parquet, or name a .csv or .jsonl file",
        )
        .in_file(output)),
        _ => Ok(write_csv),
    }
}

/// Studies the tasks on `jobs` threads and hands each row on; true if Ctrl-C came first.
fn work(
    tasks: Vec<Task>,
    asked: Asked,
    jobs: Option<u16>,
    interrupt: &Interrupt,
    mut take: impl FnMut(&Task, Row) -> Outcome<()>,
) -> Outcome<bool> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = jobs.map_or(cores, usize::from).min(tasks.len());
    let mut progress = Progress::new("studying", tasks.len() as u64, true);
    let (tasks, asked, next) = (Arc::new(tasks), Arc::new(asked), Arc::new(AtomicUsize::new(0)));
    let (sender, rows) = channel();
    for _ in 0..jobs {
        let worker = Worker {
            tasks: Arc::clone(&tasks),
            asked: Arc::clone(&asked),
            next: Arc::clone(&next),
            interrupt: interrupt.clone(),
            rows: sender.clone(),
        };
        // Not joined: after Ctrl-C nobody waits for the log that a thread is at.
        std::thread::spawn(move || worker.run());
    }
    drop(sender);
    let mut done = 0;
    loop {
        match rows.recv_timeout(PATIENCE) {
            Ok((place, row)) => {
                take(&tasks[place], row)?;
                done += 1;
                progress.at(done);
            }
            Err(RecvTimeoutError::Timeout) if interrupt.is_asked() => return Ok(true),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(done < tasks.len() as u64),
        }
    }
}

struct Worker {
    tasks: Arc<Vec<Task>>,
    asked: Arc<Asked>,
    next: Arc<AtomicUsize>,
    interrupt: Interrupt,
    /// Place among the tasks, and the row.
    rows: Sender<(usize, Row)>,
}

impl Worker {
    fn run(self) {
        while !self.interrupt.is_asked() {
            let place = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(task) = self.tasks.get(place) else { return };
            let row = study(&task.found, &self.asked);
            if self.rows.send((place, row)).is_err() {
                return;
            }
        }
    }
}
