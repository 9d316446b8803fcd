//! `cargo truths`: harder truths, as a table with intervals; effects put into real recordings among them.
//!
//! Without words it runs what the snapshot holds, and holds it to that; `--accept` writes the snapshot and the table of
//! `host-tests/measured.md`. `-n N` logs of each kind, `--tuned-on` takes the logs that thresholds were tuned on instead of those that are measured,
//! `--failing` prints what did not come out as it should, `--all` every log, `--from N` begins elsewhere, words choose kinds.
//! `--csv N` prints log N of each kind asked for, with what is hidden in it as a comment.

use ironout_host_tests::accuracy::injected::Source;
use ironout_host_tests::accuracy::truths::{MEASURED_ON, Outcome, TUNED_ON, csv_of, run, text, times};
use ironout_host_tests::accuracy::truths_table::{LOGS, Truths};
use ironout_simulation::truths::Kind;
use std::process::ExitCode;

/// Runs what the snapshot holds.
fn whole(accept: bool) -> ExitCode {
    let truths = Truths::measure(LOGS);
    print!("{}", truths.text());
    println!("\n{}", truths.times());
    match if accept { truths.store() } else { truths.hold() } {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}\nif the change is meant: cargo truths --accept, and look at the difference");
            ExitCode::FAILURE
        }
    }
}

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        None => return whole(false),
        Some("--accept") => return whole(true),
        Some(_) => {}
    }
    let (mut logs, mut from, mut family) = (LOGS, 0, MEASURED_ON);
    let (mut failing, mut all, mut csv) = (false, false, None);
    let (mut kinds, mut sources): (Vec<Kind>, Vec<Source>) = (Vec::new(), Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || words.next().and_then(|word| word.parse().ok());
        match word.as_str() {
            "-n" => logs = number().unwrap_or(LOGS),
            "--from" => from = number().unwrap_or(0),
            "--csv" => csv = number(),
            "--tuned-on" => family = TUNED_ON,
            "--failing" => failing = true,
            "--all" => all = true,
            word => {
                let kind = Kind::ALL.into_iter().find(|kind| kind.name() == word);
                let source = Source::ALL.into_iter().find(|source| source.name() == word);
                if kind.is_none() && source.is_none() {
                    let names: Vec<&str> =
                        Kind::ALL.map(Kind::name).into_iter().chain(Source::ALL.map(Source::name)).collect();
                    eprintln!("`{word}` is no option and no kind of log; kinds: {}", names.join(", "));
                    return ExitCode::from(2);
                }
                kinds.extend(kind);
                sources.extend(source);
            }
        }
    }
    if kinds.is_empty() && sources.is_empty() {
        kinds.extend(Kind::ALL);
        sources.extend(Source::ALL);
    }
    if let Some(number) = csv {
        let simulated = kinds.iter().map(|&kind| csv_of(kind, family, number));
        let recorded = sources.iter().filter_map(|source| source.csv(number));
        let texts: Vec<String> = simulated.chain(recorded).collect();
        if texts.is_empty() {
            eprintln!("--csv: the recording of that kind is not beside the project");
            return ExitCode::from(2);
        }
        print!("{}", texts.concat());
        return ExitCode::SUCCESS;
    }
    let mut list: Vec<Outcome> = Vec::new();
    for kind in kinds {
        let found = run(kind, family, from..from + logs, |one| {
            if all || (failing && !one.good(kind)) {
                eprintln!("{}", one.line(kind.name()));
            }
        });
        print!("{}", text(kind, &found));
        list.extend(found);
    }
    for source in sources {
        let found = source.run(logs, |one| {
            if all || (failing && !one.first() && source != Source::Untouched) {
                eprintln!("{}", one.line(source.name()));
            }
        });
        if found.is_empty() {
            eprintln!("SKIPPED: {}: the recordings are not here", source.name());
        }
        print!("{}", source.text(&found));
        list.extend(found);
    }
    let [median, most, worst] = times(&list);
    println!(
        "\ntime of a diagnosis: median {median:.2} s, 90 % {most:.1} s, worst {worst:.1} s of {} logs",
        list.len()
    );
    ExitCode::SUCCESS
}
