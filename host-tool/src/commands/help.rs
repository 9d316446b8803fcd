//! `ironout completions` and `ironout man`: what shells and manuals know of the command line.

use crate::cli::Cli;
use crate::cli_help::{CompletionsArgs, ManArgs};
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::output;
use clap::CommandFactory;
use std::io::{self, Write};

/// Writes the completion script of a shell.
pub fn completions(arguments: &CompletionsArgs) -> Outcome<u8> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "ironout", &mut script);
    output::note(io::stdout().write_all(&script));
    Ok(EXIT_OK)
}

/// Prints the page of the program, or writes a page for each command into a folder.
pub fn man(arguments: &ManArgs) -> Outcome<u8> {
    let Some(folder) = &arguments.folder else {
        let mut page = Vec::new();
        clap_mangen::Man::new(Cli::command())
            .render(&mut page)
            .map_err(|error| Failure::usage(error.to_string()))?;
        output::note(io::stdout().write_all(&page));
        return Ok(EXIT_OK);
    };
    std::fs::create_dir_all(folder).map_err(|error| Failure::io("create", folder, &error))?;
    clap_mangen::generate_to(Cli::command(), folder)
        .map_err(|error| Failure::io("write to", folder, &error))?;
    eprintln!("wrote the manual pages to {}", folder.display());
    Ok(EXIT_OK)
}
