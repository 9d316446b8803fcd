//! Logs as the command line names them: read, their notices passed on to standard error.

use crate::along;
use crate::cal_file::CalFile;
use crate::cli::{Form, LogArgs};
use crate::derive::{self, Definition};
use crate::failure::{Failure, Outcome};
use crate::input::{self, Log, Mounting, ReadOptions};
use crate::join::join;
use crate::plausible::{self, Known};
use crate::read_block;
use crate::reading::Reading;
use crate::turn;
use crate::wrap;
use ironout_analysis::similar;
use std::path::Path;

/// Reads the logs as one, whatever field is in them. Counts may keep their unit: without a scale they are counts of one. How each was
/// read is said, unless `json`: then the caller gives [`read_block::json`] a place in its object.
pub fn read_raw(arguments: &LogArgs, json: bool) -> Outcome<Log> {
    let log = |path: &std::path::PathBuf| {
        let log = one(arguments, path, Some([1.0; 3]), &[], Voice::from(json))?;
        say(&log, Voice::from(json));
        Ok(log)
    };
    whole(arguments.logs().map(log).collect::<Outcome<Vec<Log>>>()?, Voice::from(json))
}

/// Reads the logs as one for a fit, each held against what is known of the field; on top of an earlier calibration as that
/// one's log was read. Also gives the options that were used.
///
/// # Errors
/// Those of reading, a log that cannot be in the unit it is read in, and one that the calibration cannot be of.
pub fn read_held(
    arguments: &LogArgs,
    prior: Option<&Path>,
    known: &Known,
    voice: impl Into<Voice>,
) -> Outcome<(Log, LogArgs)> {
    let voice = voice.into();
    let cal = prior.map(CalFile::read).transpose()?;
    let known = match (&cal, known) {
        (Some(cal), Known::Earth) => Known::of(cal),
        _ => *known,
    };
    let reading = cal.as_ref().and_then(|cal| cal.reading.as_ref()).zip(prior);
    let mut used = None;
    let mut logs = Vec::new();
    for path in arguments.logs() {
        let (log, filled) = as_kept(&arguments.alone(path), reading, &known, voice)?;
        logs.push(log);
        used.get_or_insert(filled);
    }
    let used = LogArgs {
        log: arguments.log.clone(),
        more: arguments.more.clone(),
        ..used.unwrap_or_else(|| arguments.clone())
    };
    Ok((whole(logs, voice)?, used))
}

/// Reads the logs as one for a calibration, which knows how its own was read.
///
/// # Errors
/// Those of reading, and a log that is read in another scale or mounting than the calibration's.
pub fn read_for(arguments: &LogArgs, cal: &CalFile, file: &Path, json: bool) -> Outcome<Log> {
    whole(read_each_for(arguments, cal, file, json)?, Voice::from(json))
}

/// The same, log by log.
pub fn read_each_for(arguments: &LogArgs, cal: &CalFile, file: &Path, json: bool) -> Outcome<Vec<Log>> {
    let (reading, known) = (cal.reading.as_ref().map(|reading| (reading, file)), Known::of(cal));
    arguments
        .logs()
        .map(|path| Ok(as_kept(&arguments.alone(path), reading, &known, Voice::from(json))?.0))
        .collect()
}

/// One log for a calibration, and nothing is printed: what is to be said is in the log.
///
/// # Errors
/// As [`read_for`].
pub fn read_quietly_for(arguments: &LogArgs, cal: &CalFile, file: &Path) -> Outcome<Log> {
    let kept = cal.reading.as_ref().map(|reading| (reading, file));
    Ok(as_kept(arguments, kept, &Known::of(cal), Voice::Silent)?.0)
}

/// What is said on standard error while a log is read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Voice {
    /// How the log was read, and notes.
    All,
    /// Notes.
    Notes,
    /// Nothing.
    Silent,
}

impl From<bool> for Voice {
    fn from(json: bool) -> Self {
        if json { Voice::Notes } else { Voice::All }
    }
}

impl From<Form> for Voice {
    fn from(form: Form) -> Self {
        match form {
            Form::Json => Voice::Notes,
            Form::Line => Voice::Silent,
            Form::Brief | Form::Full => Voice::All,
        }
    }
}

/// One log, as that of the calibration in a file was read.
fn as_kept(
    arguments: &LogArgs,
    kept: Option<(&Reading, &Path)>,
    known: &Known,
    voice: Voice,
) -> Outcome<(Log, LogArgs)> {
    let path = &arguments.log;
    let Some((reading, file)) = kept else {
        let mut log = held(arguments, None, known, voice)?;
        let mut filled = arguments.clone();
        if arguments.reference.is_some()
            && let Some(turn) = turn::definitions(&log)
        {
            derive::add(&mut log, &turn, &Mounting::default()).map_err(|failure| failure.in_file(path))?;
            filled.derive.extend(turn.iter().map(Definition::typed));
        }
        say(&log, voice);
        return Ok((log, filled));
    };
    let mut filled = reading.fill(file, arguments)?;
    let log = match held(&filled, Some(reading), known, voice) {
        // Kept names that this log has not: its own may do.
        Err(failure) if arguments.map.is_empty() && !reading.map.is_empty() => {
            filled.map.clear();
            let mut log =
                held(&filled, Some(reading), known, voice).map_err(|_| reading.cannot(file, &failure))?;
            let notice = format!(
                "the columns named in the calibration are missing here (--map {}), so ironout uses the file's own column \
                 names",
                reading.map.join(" --map ")
            );
            if voice != Voice::Silent {
                note(path, &notice);
            }
            log.notices.push(notice);
            log
        }
        Err(failure) if !reading.derive.is_empty() && arguments.derive.is_empty() => {
            return Err(reading.cannot(file, &failure));
        }
        read => read?,
    };
    reading.must_fit(file, &log, &filled)?;
    say(&log, voice);
    Ok((log, filled))
}

fn held(arguments: &LogArgs, kept: Option<&Reading>, known: &Known, voice: Voice) -> Outcome<Log> {
    let scale = kept.and_then(|reading| reading.ut_per_count);
    let derived = kept.map_or(&[][..], |reading| &reading.derive);
    let mut log = one(arguments, &arguments.log, scale, derived, voice)?;
    let before = log.notices.len();
    plausible::hold(&mut log, arguments, known)?;
    if voice != Voice::Silent {
        tell(&log, before);
    }
    Ok(log)
}

/// One log with its derived columns, its notices told.
fn one(
    arguments: &LogArgs,
    path: &Path,
    default_ut_per_count: Option<[f64; 3]>,
    kept: &[String],
    voice: Voice,
) -> Outcome<Log> {
    let progress = voice != Voice::Silent;
    let options = ReadOptions { default_ut_per_count, progress, ..arguments.options()? };
    let log = finished(input::read_log(path, &options)?, arguments, path, kept)?;
    if voice != Voice::Silent {
        tell(&log, 0);
    }
    Ok(log)
}

/// The log with its derived columns.
fn finished(mut log: Log, arguments: &LogArgs, path: &Path, kept: &[String]) -> Outcome<Log> {
    let there = |one: &Definition| {
        // A log that was written with the column has no need to compute it again.
        kept.contains(&one.typed()) && log.covariate(&one.name).is_some()
    };
    let mut definitions =
        arguments.derive.iter().map(|text| Definition::parse(text)).collect::<Outcome<Vec<_>>>()?;
    definitions.retain(|one| !there(one));
    derive::add(&mut log, &definitions, &Mounting::parse(&arguments.rotate)?)
        .map_err(|failure| failure.in_file(path))?;
    match &arguments.reference {
        Some(columns) => along::reference(&mut log, columns).map_err(|failure| failure.in_file(path))?,
        None => along::know(&mut log, arguments.date.as_deref())?,
    }
    ignore(&mut log, &arguments.ignore).map_err(|failure| failure.in_file(path))?;
    Ok(log)
}

/// Leaves columns out, by name. A column that a derived one was computed from may be left out next to it.
fn ignore(log: &mut Log, names: &[String]) -> Outcome<()> {
    for name in names {
        if log.covariate(name).is_none() {
            let known: Vec<&str> = log.covariates.iter().map(|column| column.name.as_str()).collect();
            let has = if known.is_empty() { "none".into() } else { known.join(", ") };
            let meant = similar::did_you_mean(name, known.iter().copied());
            let meant = meant.map_or(String::new(), |meant| format!(" {meant}"));
            return Err(Failure::usage(format!(
                "--ignore {name}: the log has no such column.{meant} It has {has}"
            )));
        }
        log.covariates.retain(|column| column.name != *name);
    }
    Ok(())
}

/// Reads a log that is in memory already, under the name that `arguments` give it, and holds it against what is known of the
/// field. Nothing is printed: what is to be said is in the log.
///
/// # Errors
/// As [`read_held`].
pub fn read_bytes(arguments: &LogArgs, bytes: &[u8], known: &Known) -> Outcome<Log> {
    let path = &arguments.log;
    let options = ReadOptions { progress: false, ..arguments.options()? };
    let in_file = |failure: Failure| if failure.file.is_none() { failure.in_file(path) } else { failure };
    let mut log = input::read_stream(bytes, bytes.len() as u64, &options).map_err(in_file)?;
    log.path.clone_from(path);
    finish_quietly(log, arguments, known)
}

/// Reads one log as [`read_held`] does and prints nothing.
///
/// # Errors
/// As [`read_held`].
pub fn read_quietly(arguments: &LogArgs, known: &Known) -> Outcome<Log> {
    let options = ReadOptions { progress: false, ..arguments.options()? };
    finish_quietly(input::read_log(&arguments.log, &options)?, arguments, known)
}

/// Derives, leaves out and checks the columns of a log that has been read, and prints nothing.
///
/// # Errors
/// As [`read_held`].
pub fn finish_quietly(log: Log, arguments: &LogArgs, known: &Known) -> Outcome<Log> {
    let mut log = finished(log, arguments, &arguments.log, &[])?;
    plausible::hold(&mut log, arguments, known)?;
    Ok(log)
}

fn whole(logs: Vec<Log>, voice: Voice) -> Outcome<Log> {
    // Told already, each under its own name.
    let logs: Vec<Log> = logs.into_iter().map(|log| Log { notices: Vec::new(), ..log }).collect();
    let several = logs.len() > 1;
    // Each may have been in one place, and the places far apart.
    let logs_apart = !logs.iter().any(|log| along::travels(log, "").is_some());
    let mut log = join(logs)?;
    if several {
        let apart = logs_apart.then(|| along::travels(&log, "each log by its own places")).flatten();
        log.notices.extend(apart);
        if voice != Voice::Silent {
            tell(&log, 0);
        }
    }
    Ok(log)
}

/// How a log was read, for people.
fn say(log: &Log, voice: Voice) {
    if voice == Voice::All {
        eprint!("{}", read_block::text(log));
    }
}

fn tell(log: &Log, from: usize) {
    log.notices.iter().skip(from).for_each(|notice| note(&log.path, notice));
}

fn note(path: &Path, notice: &str) {
    eprintln!("{}", wrap::message(&format!("note: {}: {notice}", path.display()), wrap::WIDTH));
}
