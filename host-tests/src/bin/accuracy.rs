//! `cargo accuracy`: accuracy and verdicts as tables, held to a snapshot.
//!
//! `--json` prints one object on standard output; `--accept` stores the tables as the new snapshot and writes the README's.

use ironout_host_tests::accuracy::{gates, paper_table, table};
use std::process::ExitCode;

fn main() -> ExitCode {
    let (mut json, mut accept) = (false, false);
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--json" => json = true,
            "--accept" => accept = true,
            _ => {
                eprintln!("usage: cargo accuracy [--json] [--accept]");
                return ExitCode::from(2);
            }
        }
    }
    let report = table::measure(table::FULL);
    let text = report.text();
    if json {
        println!("{}", report.json());
    } else {
        print!("{text}");
    }
    if accept {
        if let Err(error) = store(&report, &text) {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    } else if std::fs::read_to_string(table::snapshot_path()).unwrap_or_default() != text {
        eprintln!("the tables differ from {}", table::snapshot_path().display());
        eprintln!("if the change is meant: cargo accuracy --accept, and look at the difference");
        return ExitCode::FAILURE;
    }
    let wrong: usize = report
        .limited
        .iter()
        .filter(|group| group.name == "all")
        .flat_map(|group| group.tallies.iter().take(3))
        .map(|tally| tally.wrongly_accepted)
        .sum();
    if wrong > 0 {
        eprintln!(
            "{wrong} calibrations of limited attitude were accepted though off by more than {} %",
            gates::WRONG * 100.0
        );
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn store(report: &table::Report, text: &str) -> std::io::Result<()> {
    std::fs::write(table::snapshot_path(), text)?;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md");
    let mut readme = std::fs::read_to_string(path)?;
    let tables = [
        ("accuracy-paper", paper_table::markdown(&report.paper)),
        ("accuracy-sweep", format!("```text\n{}```", table::sweep(&report.sweep))),
        (
            "accuracy-verdicts",
            format!("```text\n{}\n{}```", table::verdicts(&report.limited), table::verdicts(&report.full)),
        ),
    ];
    for (name, table) in tables {
        match table::between_markers(&readme, name, &table) {
            Some(changed) => readme = changed,
            None => eprintln!("README.md has no <!-- {name}:begin --> and <!-- {name}:end -->"),
        }
    }
    std::fs::write(path, readme)
}
