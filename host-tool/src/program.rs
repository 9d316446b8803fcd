//! The whole program: a command line in, an exit status out.

use crate::failure::{self, EXIT_USAGE, Failure};
use crate::{cli, commands, field_unit, output, paint, wrap};
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs one command line (the program's name first) and gives its exit status.
pub fn run(arguments: Vec<OsString>) -> ExitCode {
    let json = arguments.iter().any(|argument| argument == "--json");
    let cli = match cli::Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(&advised(error), json),
    };
    field_unit::choose(cli.unit);
    match commands::run(&cli) {
        Ok(status) => delivered(status),
        Err(failure) => {
            report(&failure, json);
            delivered(failure.exit)
        }
    }
}

/// The exit status, unless the answer could not be written.
fn delivered(status: u8) -> ExitCode {
    match output::finish() {
        Ok(()) => ExitCode::from(status),
        Err(failure) => {
            // Standard output is at fault: said on standard error, with --json too.
            report(&failure, false);
            ExitCode::from(failure.exit)
        }
    }
}

fn report(failure: &Failure, json: bool) {
    if json {
        output::line(&failure.to_json().to_string());
    } else {
        let text = wrap::message(&format!("error: {failure}"), wrap::WIDTH);
        anstream::eprintln!("{}", paint::text(&text));
    }
}

/// An error of usage without advice that fits no option of this program (`use '-- --units'`).
fn advised(mut error: clap::Error) -> clap::Error {
    use clap::error::{ContextKind, ContextValue};
    let misleads = matches!(error.get(ContextKind::Suggested), Some(ContextValue::StyledStrs(list))
        if list.iter().any(|text| text.to_string().contains("to pass '")));
    if misleads {
        error.remove(ContextKind::Suggested);
        let unit = "'--map mx_ut=HEADER[mG]' states the unit of a column, '--unit' that of the output";
        if matches!(error.get(ContextKind::InvalidArg), Some(ContextValue::String(name)) if name.starts_with("--unit"))
        {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![unit.into()]));
        }
    }
    error
}

/// Help and version are answers; everything else clap says is an error of usage.
fn usage(error: &clap::Error, json: bool) -> ExitCode {
    use clap::error::ErrorKind;
    let answer = match error.kind() {
        ErrorKind::DisplayHelp => Some("help"),
        ErrorKind::DisplayVersion => Some("version"),
        _ => None,
    };
    if let Some(answer) = answer {
        if json {
            let text = error.render().to_string();
            output::line(&serde_json::json!({ answer: text.trim_end() }).to_string());
        } else {
            output::note(error.print());
        }
        return delivered(failure::EXIT_OK);
    }
    if json {
        let text = error.render().to_string();
        let message = text.strip_prefix("error: ").unwrap_or(&text).trim();
        report(&Failure::usage(message), true);
    } else {
        // Standard error: there is no other place to say that it is full.
        let _ = error.print();
    }
    delivered(EXIT_USAGE)
}
