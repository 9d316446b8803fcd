//! `gate`: the search of today and the evidence engine on the same logs, as a table.
//!
//! Frozen logs are compared with their snapshot. `--from K` begins at the K-th log, `--every N` takes each N-th, `--only S` sets whose
//! name contains S, `--rows` prints each log, `--trace` what the search does.

use ironout_analysis::Options;
use ironout_analysis::evidence::verdict::judge;
use ironout_host_tests::frozen::compare::merit;
use ironout_host_tests::frozen::entry::{Entry, Made};
use ironout_host_tests::frozen::row::{HEADER, Row};
use ironout_host_tests::frozen::{run, snapshot};
use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    match command(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn new_row(entry: &Entry, made: &Made, hidden: &str, trace: bool) -> Option<Row> {
    let table = made.rows.table()?;
    let options = Options { search: true, ..Options::default() };
    let found = judge(&table, &options, trace);
    let mut cells: [String; HEADER.len()] = Default::default();
    let words = [
        entry.set.clone(),
        entry.log.clone(),
        hidden.to_owned(),
        found.verdict.name().to_owned(),
        found.named.join("+"),
        found.confounded.join("+"),
    ];
    cells.iter_mut().zip(words).for_each(|(cell, word)| *cell = word);
    cells[11] = format!("{:.4}", found.rms_ut[1]);
    cells[13] = format!("{:.4} wander {:.3} in {:.1} s", found.noise_ut, found.wander.0, found.wander.1);
    Some(Row(cells))
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
}

impl Tally {
    fn take(&mut self, row: &Row) {
        let hidden = row.list("hidden");
        let named = row.list("named");
        self.logs += 1;
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
            "{:>3}/{:<3} {:>3}/{:<3} {:>3} {:>3}",
            self.first, self.hidden, self.exact, self.exact_of, self.false_names, self.claims
        )
    }
}

fn command(words: impl Iterator<Item = String>) -> Result<(), Box<dyn std::error::Error>> {
    let (mut from, mut every, mut only, mut rows, mut trace) = (0usize, 1usize, Vec::new(), false, false);
    let mut log = None;
    let mut words = words;
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--from" => from = value()?.parse()?,
            "--every" => every = value()?.parse()?,
            "--only" => only.push(value()?),
            "--log" => log = Some(value()?),
            "--rows" => rows = true,
            "--trace" => trace = true,
            _ => return Err(format!("no option {word}").into()),
        }
    }
    let text = std::fs::read_to_string(snapshot::path())?;
    let stored = snapshot::rows(&text)?;
    let old: BTreeMap<(&str, &str), &Row> = stored.iter().map(|row| (row.key(), row)).collect();
    let entries: Vec<Entry> = run::entries()
        .into_iter()
        .filter(|entry| only.is_empty() || only.iter().any(|word| entry.set.contains(word.as_str())))
        .filter(|entry| log.as_ref().is_none_or(|log| *log == entry.log))
        .collect();
    let mut tallies: Vec<(String, [Tally; 2])> = Vec::new();
    let mut seconds = Vec::new();
    for entry in entries.iter().skip(from).step_by(every.max(1)) {
        let Some(before) = old.get(&(entry.set.as_str(), entry.log.as_str())) else { continue };
        let Ok(made) = (entry.make)() else { continue };
        let begin = Instant::now();
        let Some(row) = new_row(entry, &made, before.cell("hidden"), trace) else { continue };
        seconds.push((begin.elapsed().as_secs_f64(), format!("{} {}", entry.set, entry.log)));
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
                "{} {} {} hidden {} | {} {} | {} {} rms {} noise {} {:.1} s",
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
                seconds.last().map_or(0.0, |(s, _)| *s),
            );
        }
    }
    println!("{:<24} {:>4}  {:<25} | {:<25}", "set", "n", "old: first exact false claim", "new");
    let mut sum = [Tally::default(); 2];
    for (set, both) in &tallies {
        println!("{set:<24} {:>4}  {} | {}", both[0].logs, both[0].cells(), both[1].cells());
        for (sum, one) in sum.iter_mut().zip(both) {
            sum.logs += one.logs;
            sum.hidden += one.hidden;
            sum.first += one.first;
            sum.exact_of += one.exact_of;
            sum.exact += one.exact;
            sum.false_names += one.false_names;
            sum.claims += one.claims;
        }
    }
    println!("{:<24} {:>4}  {} | {}", "all", sum[0].logs, sum[0].cells(), sum[1].cells());
    seconds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: f64| seconds.get((share * seconds.len().saturating_sub(1) as f64).round() as usize);
    if let (Some(median), Some(most), Some(worst)) = (at(0.5), at(0.9), at(1.0)) {
        println!("time: median {:.2} s, 90 % {:.2} s, worst {:.2} s ({})", median.0, most.0, worst.0, worst.1);
    }
    Ok(())
}
