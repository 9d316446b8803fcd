//! `cargo effects-accuracy`: how well hidden effects are found, as a table held to its snapshot.
//!
//! `--seeds N` runs fewer logs of each kind, `--accept` writes the snapshot.

use ironout_cli::effect_table::{CASES, HEADING, line, run};
use std::process::ExitCode;

const SNAPSHOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/effects.txt");
/// Logs of each kind behind the snapshot.
const SEEDS: u64 = 20;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let seeds = arguments
        .iter()
        .position(|word| word == "--seeds")
        .and_then(|at| arguments.get(at + 1))
        .and_then(|number| number.parse().ok())
        .unwrap_or(SEEDS);
    let mut table = format!("{seeds} logs of each kind, 80 s at 50 Hz\n{HEADING}\n");
    println!("{}", table.trim_end());
    for case in &CASES {
        let text = line(case, &run(case, seeds));
        println!("{text}");
        table += &text;
        table.push('\n');
    }
    if arguments.iter().any(|word| word == "--accept") {
        return match std::fs::write(SNAPSHOT, &table) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("{SNAPSHOT}: {error}");
                ExitCode::FAILURE
            }
        };
    }
    if seeds != SEEDS {
        return ExitCode::SUCCESS;
    }
    match std::fs::read_to_string(SNAPSHOT) {
        Ok(old) if old == table => ExitCode::SUCCESS,
        Ok(_) => {
            eprintln!(
                "the table differs from {SNAPSHOT}: if that is meant, run again with --accept and read the diff"
            );
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{SNAPSHOT}: {error}");
            ExitCode::FAILURE
        }
    }
}
