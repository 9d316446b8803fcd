//! `cargo layers`: no circles, arrows that only run down, no file too long. Exit status 1 where something is not in order,
//! 2 where it could not be looked at.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = std::env::args().nth(1).unwrap_or_else(|| ".".to_string());
    let report = Path::new(&root)
        .canonicalize()
        .map_err(|error| format!("{root}: {error}"))
        .and_then(|root| ironout_layers::check_workspace(&root));
    match report {
        Ok(report) => {
            print!("{report}");
            if report.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(2)
        }
    }
}
