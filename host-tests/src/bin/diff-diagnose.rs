//! `cargo diff-diagnose`: what a change does to the diagnoses of some 600 logs, against a snapshot.
//!
//! It prints, per set of logs and log by log, what became better or worse by the truth where that is known, and fails when anything
//! changed. A word runs only the sets whose name contains it, `--every N` one log of N. `--accept` writes the snapshot of what is run,
//! `--rows` prints it, `--csv SET LOG` prints one log.

use ironout_host_tests::frozen::compare::compare;
use ironout_host_tests::frozen::entry::Entry;
use ironout_host_tests::frozen::row::Row;
use ironout_host_tests::frozen::{run, snapshot};
use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    match command(std::env::args().skip(1).collect()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(changed) => {
            println!("{changed} rows changed. If the change is meant: cargo diff-diagnose --accept");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn command(mut words: Vec<String>) -> Result<usize, Box<dyn std::error::Error>> {
    let every = match words.iter().position(|word| word == "--every") {
        None => 1,
        Some(place) => {
            let number = words.drain(place..words.len().min(place + 2)).nth(1);
            let number = number.and_then(|word| word.parse().ok()).filter(|number| *number > 0);
            number.ok_or("--every needs a number from 1 on")?
        }
    };
    let accept = words.iter().any(|word| word == "--accept");
    let chosen: Vec<&String> = words.iter().filter(|word| !word.starts_with("--")).collect();
    if let Some(unknown) = words
        .iter()
        .find(|word| word.starts_with("--") && !["--accept", "--csv", "--rows"].contains(&word.as_str()))
    {
        return Err(format!(
            "no option {unknown}: --accept, --every N, --rows, --csv SET LOG, or words that sets contain"
        )
        .into());
    }
    let mut entries = run::entries();
    if words.iter().any(|word| word == "--csv") {
        let [set, log] = chosen[..] else { return Err("--csv needs a set and a log".into()) };
        return print_log(&entries, set, log).map(|()| 0);
    }
    entries.retain(|entry| chosen.is_empty() || chosen.iter().any(|word| entry.set.contains(word.as_str())));
    let entries: Vec<_> = entries.into_iter().step_by(every).collect();
    let (start, of) = (Instant::now(), entries.len());
    let rows = run::rows(&entries, |done| {
        if done % 20 == 0 || done == of {
            eprint!("\r{done} of {of} logs, {:.0} s", start.elapsed().as_secs_f64());
            let _ = std::io::stderr().flush();
        }
    });
    eprintln!();
    let text = snapshot::text(&rows)?;
    if words.iter().any(|word| word == "--rows") {
        print!("{text}");
        return Ok(0);
    }
    if accept {
        // The rows of logs that are not run stay as they are.
        let mut all = match chosen.is_empty() && every == 1 {
            true => Vec::new(),
            false => snapshot::rows(&std::fs::read_to_string(snapshot::path())?)?,
        };
        for row in rows {
            match all.iter_mut().find(|own| own.key() == row.key()) {
                Some(own) => *own = row,
                None => all.push(row),
            }
        }
        std::fs::write(snapshot::path(), snapshot::text(&all)?)?;
    }
    let mut stored: Vec<Row> = match std::fs::read_to_string(snapshot::path()) {
        Ok(text) => snapshot::rows(&text)?,
        Err(error) => return Err(format!("{}: {error}", snapshot::path().display()).into()),
    };
    let is_run = |row: &Row| {
        let (set, log) = row.key();
        entries.iter().any(|entry| entry.set == set && (every == 1 || entry.log == log))
    };
    stored.retain(is_run);
    let comparison = compare(&stored, &snapshot::rows(&text)?);
    print!("{}", comparison.text);
    Ok(comparison.changed)
}

/// Prints the rows of one generated log as CSV.
fn print_log(entries: &[Entry], set: &str, log: &str) -> Result<(), Box<dyn std::error::Error>> {
    let entry = entries.iter().find(|entry| entry.set == set && entry.log == log);
    let made = (entry.ok_or_else(|| format!("no log {log} in the set {set}"))?.make)()?;
    made.rows.print()
}
