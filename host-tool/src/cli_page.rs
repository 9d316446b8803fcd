//! What can be asked of the commands that make a page.

use crate::cli::{FieldArgs, LogArgs};
use clap::Args;
use std::path::PathBuf;

/// `report`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout report log.csv -o report.html
  ironout report log.csv --add offset:current_a -o report.html
  ironout report log.csv --cal old.json --cal new.json -o report.html   side by side
  ironout report log.csv --beside later.csv -o report.html
  ironout report log.csv --plots figures/                               each plot as SVG

One file that works offline: effects are switched on and fitted anew in the
browser. Nothing leaves the machine that opens it.")]
pub struct ReportArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub field: FieldArgs,
    /// Write the page here
    #[arg(short, long, value_name = "REPORT.html", required_unless_present = "plots")]
    pub output: Option<PathBuf>,
    /// Begin with this effect switched on (repeatable)
    #[arg(long, value_name = "EFFECT")]
    pub add: Vec<String>,
    /// Show the log under this calibration too, beside the others (repeatable)
    #[arg(long, value_name = "CAL.json")]
    pub cal: Vec<PathBuf>,
    /// Another log of the same kind, fitted by itself and shown beside this one
    #[arg(long, value_name = "LOG")]
    pub beside: Option<PathBuf>,
    /// Write each plot into this folder as SVG
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,
    /// Do not search for missing effects (faster)
    #[arg(long)]
    pub no_search: bool,
}

/// `web`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  ironout web -o public/      then put public/ on any web server, or open public/index.html")]
pub struct WebArgs {
    /// Write the page into this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}
