//! The arguments of the commands that speak to a board.

use crate::failure::{Failure, Outcome};
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

/// The longest timeout of an answer, s.
const LONGEST_WAIT_S: f64 = 3600.0;

/// Where the board is.
#[derive(Debug, Args, Clone)]
pub struct LinkArgs {
    /// The board's serial port, as in /dev/ttyACM0 or COM5 (115200 8N1)
    #[arg(
        long,
        value_name = "SERIAL",
        help_heading = "The board",
        conflicts_with = "tcp",
        required_unless_present = "tcp"
    )]
    pub port: Option<String>,
    /// The board's console behind a TCP port, as in localhost:4000
    #[arg(long, value_name = "ADDR", help_heading = "The board")]
    pub tcp: Option<String>,
    /// Timeout for an answer, in seconds (a board answers within 2)
    #[arg(long, value_name = "S", default_value_t = 10.0, help_heading = "The board")]
    pub wait: f64,
}

impl LinkArgs {
    /// How long an answer may take; errors name the option.
    pub fn wait(&self) -> Outcome<Duration> {
        wait(self.wait)
    }
}

/// How long an answer may take, of seconds as they are typed.
///
/// # Errors
/// No time, or one longer than anybody waits.
pub fn wait(seconds: f64) -> Outcome<Duration> {
    if seconds > 0.0 && seconds <= LONGEST_WAIT_S {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(Failure::usage(format!(
        "--wait {seconds}: expected seconds, more than 0 and at most {LONGEST_WAIT_S}"
    )))
}

/// `send`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout send cal.json --port /dev/ttyACM0
  ironout send cal.json --tcp localhost:4000

The board checks the whole calibration before it changes anything, stores it
like its own, and returns it for comparison. An interrupted transfer changes
nothing. Exit status 1: the board refused; the reason is printed.")]
pub struct SendArgs {
    /// The calibration, as fit writes it
    pub cal: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link: LinkArgs,
}

/// `fetch`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout fetch --port /dev/ttyACM0 -o cal.json
  ironout export cal.json --as c

If the board still has the covariance (it is lost after effect add), the file
also contains it, so that fit --prior can use it.")]
pub struct FetchArgs {
    /// Write the board's calibration here
    #[arg(short, long, value_name = "CAL.json")]
    pub output: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link: LinkArgs,
}

/// `record`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout record --port /dev/ttyACM0 -o log.csv --seconds 60
  ironout record --tcp localhost:4000 -o log.csv     until Ctrl-C
  ironout fit log.csv -o cal.json

The log has the board's own time stamps, the field in microtesla and every
column that the board knows. Lost samples are marked. If the board is
disconnected, recording continues when it is back.")]
pub struct RecordArgs {
    /// Write the log here (complete, when the recording ends)
    #[arg(short, long, value_name = "LOG.csv")]
    pub output: PathBuf,
    /// Stop after this many seconds of the board's clock (default: at Ctrl-C)
    #[arg(long, value_name = "S")]
    pub seconds: Option<f64>,
    /// How long to wait for a disconnected board, in seconds
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    pub patience: f64,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link: LinkArgs,
}

impl RecordArgs {
    /// Length and patience; errors name the option.
    pub fn times(&self) -> Outcome<(Option<f64>, Duration)> {
        let sound = |value: f64| value > 0.0 && value.is_finite() && value <= 1e7;
        if let Some(seconds) = self.seconds.filter(|seconds| !sound(*seconds)) {
            return Err(Failure::usage(format!("--seconds {seconds}: expected a number of seconds above 0")));
        }
        if !sound(self.patience) {
            return Err(Failure::usage(format!(
                "--patience {}: expected a number of seconds above 0",
                self.patience
            )));
        }
        Ok((self.seconds, Duration::from_secs_f64(self.patience)))
    }
}
