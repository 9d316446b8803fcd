//! The commands, one a file. Each gives its exit status, or a failure with its place.

mod apply;
mod batch;
mod check;
mod demo;
mod diagnose;
mod effects;
mod export;
mod fetch;
mod fit;
mod help;
mod import;
#[cfg(feature = "page")]
mod live;
#[cfg(not(feature = "page"))]
mod page_on_demand;
mod record;
#[cfg(feature = "page")]
mod report;
mod send;
mod simulate;
#[cfg(feature = "page")]
mod web;

use crate::cli::{Cli, Command};
use crate::failure::Outcome;

/// Runs the command.
pub fn run(cli: &Cli) -> Outcome<u8> {
    match &cli.command {
        Command::Fit(arguments) => fit::run(arguments, cli.form()),
        Command::Apply(arguments) => apply::run(arguments, cli.json),
        Command::Check(arguments) => check::run(arguments, cli.json),
        Command::Export(arguments) => export::run::run(arguments, cli.json),
        Command::Simulate(arguments) => simulate::run(arguments, cli.json),
        Command::Demo(arguments) => demo::run(arguments, cli.json),
        Command::Diagnose(arguments) => diagnose::run(arguments, cli.form()),
        Command::Batch(arguments) => batch::run::run(arguments, cli.json),
        Command::Send(arguments) => send::run(arguments, cli.json),
        Command::Fetch(arguments) => fetch::run(arguments, cli.json),
        Command::Record(arguments) => record::run(arguments, cli.json),
        #[cfg(feature = "page")]
        Command::Report(arguments) => report::run(arguments, cli.json),
        #[cfg(feature = "page")]
        Command::Web(arguments) => web::run(arguments, cli.json),
        #[cfg(feature = "page")]
        Command::Live(arguments) => live::run(arguments, cli.json),
        #[cfg(not(feature = "page"))]
        Command::Report(_) | Command::Web(_) | Command::Live(_) => page_on_demand::run(),
        Command::Effects(arguments) => effects::run(arguments, cli.form()),
        Command::Completions(arguments) => help::completions(arguments),
        Command::Man(arguments) => help::man(arguments),
        Command::Import(arguments) => import::run(arguments, cli.json),
    }
}
