//! The host side of `ironout`: reads logs, runs the core on them, and says what came out, in words or as JSON.
//!
//! Everything numeric is the core's; here are files, tables and words. [`run`] is the whole program.

pub mod atomic;
pub mod cal_file;
pub mod cli;
pub mod commands;
pub mod diagnose;
pub mod effect_table;
pub mod effects;
pub mod failure;
pub mod geomag;
pub mod input;
pub mod output;
pub mod pipeline;
pub mod prior;
pub mod progress;

use clap::Parser;
use failure::{EXIT_USAGE, Failure};
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs one command line (the program's name first) and gives its exit status.
pub fn run(arguments: Vec<OsString>) -> ExitCode {
    let json = arguments.iter().any(|argument| argument == "--json");
    let cli = match cli::Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(&error, json),
    };
    match commands::run(&cli) {
        Ok(status) => ExitCode::from(status),
        Err(failure) => {
            report(&failure, json);
            ExitCode::from(failure.exit)
        }
    }
}

fn report(failure: &Failure, json: bool) {
    if json {
        output::line(&failure.to_json().to_string());
    } else {
        eprintln!("error: {failure}");
    }
}

/// Help and version are answers; everything else clap says is an error of usage.
fn usage(error: &clap::Error, json: bool) -> ExitCode {
    use clap::error::ErrorKind;
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if json {
        let text = error.render().to_string();
        let message = text.strip_prefix("error: ").unwrap_or(&text).trim();
        report(&Failure::usage(message), true);
    } else {
        let _ = error.print();
    }
    ExitCode::from(EXIT_USAGE)
}
