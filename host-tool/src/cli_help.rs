//! Arguments of the commands about the program itself and about a log's effects.

use crate::log_args::LogArgs;
use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

/// `effects`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  ironout effects log.csv

Prints the effects of each column, as fit --add and diagnose --add take them,
and what the log lacks for the others. It does not search: ironout diagnose
tests all of them.")]
pub struct EffectsArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
}

/// `completions`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout completions bash > ~/.local/share/bash-completion/completions/ironout
  ironout completions zsh > \"${fpath[1]}/_ironout\"
  ironout completions fish > ~/.config/fish/completions/ironout.fish")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// `man`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout man | man -l -                     read the page of the program
  ironout man ~/.local/share/man/man1        write a page for each command")]
pub struct ManArgs {
    /// Folder for one page per command (default: print the page of the program)
    #[arg(value_name = "DIR")]
    pub folder: Option<PathBuf>,
}
