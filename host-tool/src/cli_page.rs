//! What can be asked of the commands that make a page.

use crate::cli_demo::HiddenArg;
use crate::failure::{Failure, Outcome};
use crate::link_args;
use crate::log_args::{FieldArgs, LogArgs};
use clap::{ArgGroup, Args};
use std::path::PathBuf;
use std::time::Duration;

/// `report`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout report log.csv -o report.html
  ironout report log.csv --add offset:current_a -o report.html
  ironout report log.csv --cal old.json --cal new.json -o report.html   side by side
  ironout report log.csv --compare later.csv -o report.html
  ironout report log.csv --plots figures/                               each plot as SVG

One file that works offline: the browser refits when you switch effects on or
off. No data is uploaded.")]
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
    /// Start with this effect switched on (repeatable)
    #[arg(long, value_name = "EFFECT")]
    pub add: Vec<String>,
    /// Also show the log with this calibration (repeatable)
    #[arg(long, value_name = "CAL.json")]
    pub cal: Vec<PathBuf>,
    /// Another log of the same kind, fitted separately and shown next to this one
    #[arg(long, alias = "beside", value_name = "LOG")]
    pub compare: Option<PathBuf>,
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

/// Slower, a log hardly moves; faster, a machine cannot keep up.
const MIN_SPEED: f64 = 0.1;
const MAX_SPEED: f64 = 50.0;

/// `live`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("where").required(true).args(["port", "tcp", "qemu", "replay"]))]
#[command(after_help = "Examples:
  ironout live --port /dev/ttyACM0      then open the address that it prints
  ironout live --qemu                   an emulated board that turns by itself
  ironout live --qemu --hidden temperature   one that has to find the cause
  ironout live --replay log.csv         a simulated board in the field of a log

The page is served on this machine only. Ctrl-C ends.")]
pub struct LiveArgs {
    /// The board's serial port, as in /dev/ttyACM0 or COM5 (115200 8N1)
    #[arg(long, value_name = "SERIAL", help_heading = "The board")]
    pub port: Option<String>,
    /// The board's console behind a TCP port, as in localhost:4000
    #[arg(long, value_name = "ADDR", help_heading = "The board")]
    pub tcp: Option<String>,
    /// The firmware in QEMU, with a simulated sensor that rotates all the time
    #[arg(long, help_heading = "The board")]
    pub qemu: bool,
    /// A simulated board in the field of this log, with its columns, at the log's own pace
    #[arg(long, value_name = "LOG", help_heading = "The board")]
    pub replay: Option<PathBuf>,
    /// Hide an effect from the board in QEMU. It starts when a calibration is accepted
    #[arg(long, value_enum, value_name = "EFFECT", conflicts_with_all = ["port", "tcp", "replay"], help_heading = "The board")]
    pub hidden: Option<HiddenArg>,
    /// Replay speed factor
    #[arg(
        long,
        value_name = "TIMES",
        default_value_t = 1.0,
        requires = "replay",
        help_heading = "The board"
    )]
    pub speed: f64,
    /// The port on this machine to serve the page at (0: a free one)
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub listen: u16,
    /// Timeout for an answer of the board, in seconds
    #[arg(long, value_name = "S", default_value_t = 10.0, help_heading = "The board")]
    pub wait: f64,
}

impl LiveArgs {
    /// How long an answer may take; errors name the option.
    pub fn wait(&self) -> Outcome<Duration> {
        link_args::wait(self.wait)
    }

    /// How fast a log is replayed; errors name the option.
    pub fn speed(&self) -> Outcome<f64> {
        if self.speed >= MIN_SPEED && self.speed <= MAX_SPEED {
            return Ok(self.speed);
        }
        Err(Failure::usage(format!("--speed {}: from {MIN_SPEED} to {MAX_SPEED}", self.speed)))
    }
}
