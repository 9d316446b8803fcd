//! `gate`: how well the diagnosis does on logs that nothing was tuned on, as a table; and what it is made of.
//!
//! Frozen logs stand beside their snapshot. `--unseen N` takes N logs of each kind of both generators and of each recording instead,
//! from seeds that nothing was tuned on; `--seeds-from K` leaves out the first K seeds. `--from K` begins at the K-th log, `--every N`
//! takes each N-th, `--only S` sets whose name contains S, `--log S` one log, `--rows` prints each log, `--csv` the
//! columns of the first one. `--count` counts lines and
//! constants. `--beyond N` tries N causes beyond plain columns of each generator, after those that `--seeds-from` leaves out (put `--only own` or `--only second` before it for one of them). `--false-alarms N` simulates N logs without effects in white noise and counts those in which somebody is named.

use ironout_analysis::{Options, diagnose};
use ironout_host_tests::accuracy::beyond;
use ironout_host_tests::accuracy::simulated::table_of;
use ironout_host_tests::frozen::compare::merit;
use ironout_host_tests::frozen::entry::Entry;
use ironout_host_tests::frozen::row::Row;
use ironout_host_tests::frozen::{generated, run, snapshot};
use ironout_host_tests::rate::Rate;
use ironout_simulation::{Decoy, World, WorldOptions};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    match command(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Processor time of all threads, s; the time of day where the system does not tell it.
fn processor_s() -> f64 {
    let told = std::fs::read_to_string("/proc/self/stat").ok();
    // User and system time, in hundredths of a second, are the 12th and 13th word behind the name.
    let ticks = told.and_then(|text| {
        let mut words = text.rsplit(')').next()?.split_whitespace().skip(11);
        let mut word = || words.next()?.parse::<f64>().ok();
        Some(word()? + word()?)
    });
    ticks.map_or_else(
        || std::time::UNIX_EPOCH.elapsed().map_or(0.0, |elapsed| elapsed.as_secs_f64()),
        |ticks| 0.01 * ticks,
    )
}

/// Lines of code (no tests, comments or blanks) and named constants of a file, or of all below a folder.
fn counted(path: &Path) -> (usize, usize) {
    if let Ok(entries) = std::fs::read_dir(path) {
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        return paths.map(|path| counted(&path)).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    }
    if path.extension().is_none_or(|end| end != "rs") || path.ends_with("tests.rs") {
        return (0, 0);
    }
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let code = code.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
    let is_constant = |line: &&str| line.starts_with("const ") || line.starts_with("pub const ");
    (code.clone().count(), code.filter(is_constant).count())
}

fn count() {
    let room =
        |name: &str| counted(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../analysis/src")).join(name));
    for rooms in [&["evidence", "noise", "bounds.rs"][..], &["search", "residual", "base", "outcome"]] {
        let (lines, constants) =
            rooms.iter().map(|name| room(name)).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        println!("{lines} lines of code, {constants} constants in {}", rooms.join(", "));
    }
}

/// Logs without effects in white noise, with columns that cause nothing: in how many somebody is named.
fn false_alarms(logs: u64) {
    let made = (0..logs).map(|seed| {
        let log = World::new(WorldOptions {
            seed: 0x40_fa00 + seed,
            seconds: 60.0,
            rate_hz: 25.0,
            decoys: vec![
                ("baro".into(), Decoy::Walk),
                ("mode".into(), Decoy::Mode),
                ("switch".into(), Decoy::Switch),
                ("battery_v".into(), Decoy::Battery),
                ("humidity".into(), Decoy::Walk),
                ("satellites".into(), Decoy::Mode),
                ("charger".into(), Decoy::Switch),
                ("board_c".into(), Decoy::Alike { column: "temp_c".into(), correlation: 0.98 }),
            ],
            ..WorldOptions::default()
        })
        .run();
        let table = table_of(&log);
        let options = Options { search: true, ..Options::default() };
        diagnose(&table, &options).is_ok_and(|found| !found.effects.is_empty())
    });
    let count = made.filter(|named| *named).count() as u64;
    println!("somebody named in white noise without effects: {}", Rate { count, of: logs });
}

/// Root mean square, and how many.
#[derive(Default, Clone, Copy)]
struct Ratios {
    squares: f64,
    count: usize,
}

impl Ratios {
    fn take(&mut self, row: &Row) {
        let number = |cell: &str| row.cell(cell).parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
        if let Some((error, predicted)) = number("true_error_ut").zip(number("predicted_error_ut")) {
            // One log with a prediction that is far off must not hide all others.
            self.squares += (error / predicted).min(10.0).powi(2);
            self.count += 1;
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

/// How many logs of a set came out how.
#[derive(Default, Clone, Copy)]
struct Tally {
    logs: usize,
    hidden: usize,
    first: usize,
    exact_of: usize,
    exact: usize,
    false_names: usize,
    claims: usize,
    ratios: Ratios,
}

impl Tally {
    fn take(&mut self, row: &Row) {
        let hidden = row.list("hidden");
        let named = row.list("named");
        self.logs += 1;
        self.ratios.take(row);
        let merit = merit(row);
        match hidden.as_slice() {
            ["?"] => return,
            ["column missing"] => {
                self.claims += usize::from(["complete", "missing"].contains(&row.cell("verdict")));
                self.false_names += usize::from(named.iter().any(|id| !["drift", "step"].contains(id)));
                return;
            }
            _ => self.false_names += usize::from(merit == Some(0)),
        }
        let own: Vec<&str> = hidden.iter().copied().filter(|id| *id != "injected").collect();
        if !own.is_empty() {
            self.hidden += 1;
            self.first += usize::from(named.first().is_some_and(|id| own.contains(id)));
        }
        if hidden.first() != Some(&"injected") {
            let sorted = |list: &[&str]| {
                let mut list: Vec<String> = list.iter().map(|id| (*id).to_owned()).collect();
                list.sort();
                list
            };
            self.exact_of += 1;
            self.exact += usize::from(sorted(&own) == sorted(&named));
        }
    }

    fn cells(&self) -> String {
        format!(
            "{:>3}/{:<3} {:>3}/{:<3} {:>5} {:>5} {:>5.2}",
            self.first,
            self.hidden,
            self.exact,
            self.exact_of,
            self.false_names,
            self.claims,
            self.ratios.rms()
        )
    }
}

fn command(words: impl Iterator<Item = String>) -> Result<(), Box<dyn std::error::Error>> {
    let (mut from, mut every, mut only, mut rows, mut print) = (0usize, 1usize, Vec::new(), false, false);
    let (mut log, mut unseen) = (None, None);
    let mut seeds = 0;
    let mut words = words;
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--from" => from = value()?.parse()?,
            "--every" => every = value()?.parse()?,
            "--only" => only.push(value()?),
            "--log" => log = Some(value()?),
            "--unseen" => unseen = Some(value()?.parse::<u64>()?),
            "--seeds-from" => seeds = value()?.parse()?,
            "--rows" => rows = true,
            "--csv" => print = true,
            "--count" => {
                count();
                return Ok(());
            }
            "--beyond" => {
                beyond::print(seeds, value()?.parse()?, &only);
                return Ok(());
            }
            "--false-alarms" => {
                false_alarms(value()?.parse()?);
                return Ok(());
            }
            _ => return Err(format!("no option {word}").into()),
        }
    }
    let text = std::fs::read_to_string(snapshot::path())?;
    let stored = snapshot::rows(&text)?;
    let old: BTreeMap<(&str, &str), &Row> = stored.iter().map(|row| (row.key(), row)).collect();
    if unseen.is_some() && !print {
        println!("unseen logs: nothing was tuned on their seeds");
    }
    let entries: Vec<Entry> = unseen
        .map_or_else(run::entries, |logs| generated::unseen(seeds..seeds + logs))
        .into_iter()
        .filter(|entry| only.is_empty() || only.iter().any(|word| entry.set.contains(word.as_str())))
        .filter(|entry| log.as_ref().is_none_or(|log| *log == entry.log))
        .collect();
    let mut tallies: Vec<(String, [Tally; 2])> = Vec::new();
    let mut seconds = Vec::new();
    for entry in entries.iter().skip(from).step_by(every.max(1)) {
        let name = || format!("{} {}", entry.set, entry.log);
        let Ok(made) = (entry.make)() else { continue };
        if print {
            return made.rows.print();
        }
        let begin = processor_s();
        let row = Row::of(&entry.set, &entry.log, &made);
        seconds.push((processor_s() - begin, name()));
        let before = match old.get(&(entry.set.as_str(), entry.log.as_str())) {
            Some(row) => (*row).clone(),
            None => row.clone(),
        };
        let before = &before;
        if tallies.last().is_none_or(|(set, _)| *set != entry.set) {
            tallies.push((entry.set.clone(), [Tally::default(); 2]));
        }
        if let Some((_, both)) = tallies.last_mut() {
            both[0].take(before);
            both[1].take(&row);
        }
        let merits = [merit(before), merit(&row)];
        if rows || merits[1] < merits[0] {
            println!(
                "{} {} {} hidden {} | {} {} | {} {} rms {} noise {} error {} predicted {} {:.1} s",
                match merits[1].cmp(&merits[0]) {
                    std::cmp::Ordering::Less => "worse ",
                    std::cmp::Ordering::Equal => "same  ",
                    std::cmp::Ordering::Greater => "better",
                },
                entry.set,
                entry.log,
                before.cell("hidden"),
                before.cell("verdict"),
                before.cell("named"),
                row.cell("verdict"),
                row.cell("named"),
                row.cell("rms_ut"),
                row.cell("noise_floor_ut"),
                row.cell("true_error_ut"),
                row.cell("predicted_error_ut"),
                seconds.last().map_or(0.0, |(s, _)| *s),
            );
        }
    }
    println!(
        "{:<24} {:>4}  {:<36} | {:<36}",
        "set", "n", "snapshot: first exactly false claims z-rms", "now: first exactly false claims z-rms"
    );
    let mut sum = [Tally::default(); 2];
    for (set, both) in &tallies {
        println!("{set:<24} {:>4}  {:<36} | {}", both[0].logs, both[0].cells(), both[1].cells());
        for (sum, one) in sum.iter_mut().zip(both) {
            sum.logs += one.logs;
            sum.hidden += one.hidden;
            sum.first += one.first;
            sum.exact_of += one.exact_of;
            sum.exact += one.exact;
            sum.false_names += one.false_names;
            sum.claims += one.claims;
            sum.ratios.squares += one.ratios.squares;
            sum.ratios.count += one.ratios.count;
        }
    }
    println!("{:<24} {:>4}  {:<36} | {}", "all", sum[0].logs, sum[0].cells(), sum[1].cells());
    seconds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: f64| seconds.get((share * seconds.len().saturating_sub(1) as f64).round() as usize);
    if let (Some(median), Some(most), Some(worst)) = (at(0.5), at(0.9), at(1.0)) {
        println!(
            "processor time median {:.2} s, 90 % {:.2} s, worst {:.2} s ({}), {} logs",
            median.0,
            most.0,
            worst.0,
            worst.1,
            seconds.len()
        );
    }
    Ok(())
}
