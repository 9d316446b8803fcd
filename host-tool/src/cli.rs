//! The command line: what can be asked, with help and examples.

#[cfg(not(target_arch = "wasm32"))]
pub use crate::cli_batch::BatchArgs;
#[cfg(not(target_arch = "wasm32"))]
pub use crate::cli_demo::{BoardArg, DemoArgs, HiddenArg};
pub use crate::cli_export::{ExportArgs, ExportForm};
#[cfg(not(target_arch = "wasm32"))]
pub use crate::cli_page::{LiveArgs, ReportArgs, WebArgs};
#[cfg(not(target_arch = "wasm32"))]
use crate::field_unit::FieldUnit;
#[cfg(not(target_arch = "wasm32"))]
use crate::link_args::{FetchArgs, RecordArgs, SendArgs};
use clap::Args;
#[cfg(not(target_arch = "wasm32"))]
use clap::{Parser, Subcommand};
use ironout_analysis::outcome::request::Purpose;
use std::path::PathBuf;

pub use crate::log_args::{Expected, FieldArgs, LogArgs, MethodArg, scale};
pub use crate::shell::{quoted, typed_option};

#[cfg(not(target_arch = "wasm32"))]
const ABOUT: &str = "Calibrates magnetometers and shows what the calibration leaves over.

A log is what your board, telephone or logger wrote: it is told by its content,
and how it was read is said. The program's own is CSV whose header names its
units: t_s,mx_ut,my_ut,mz_ut (microtesla) or mx_counts,… with --ut-per-count,
and any other columns (ax_mps2,…, gx_radps,…, temp_c, motor_a, anything).
Body axes: x forward, y right, z down. docs/command-line.md has all of it.";

#[cfg(not(target_arch = "wasm32"))]
const EXAMPLES: &str = "Examples:
  ironout demo                                 a board calibrates itself
  ironout simulate -o log.csv --seed 1         a log to try things on
  ironout fit log.csv -o cal.json              calibrate, keep the result
  ironout apply log.csv --cal cal.json         error before and after
  ironout check later.csv --cal cal.json       is it still good?
  ironout export cal.json --as c               into your firmware

Exit status: 0 done, 1 the data do not support a calibration, 2 bad input or
usage.";

/// The command line.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Debug, Parser)]
#[command(name = "ironout", version, about = ABOUT, after_help = EXAMPLES, max_term_width = 110)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// One JSON object on standard output and nothing else there (unknown values are null)
    #[arg(long, global = true)]
    pub json: bool,
    /// Print every figure, not only the answer
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Print one line
    #[arg(short, long, global = true, conflicts_with_all = ["verbose", "json"])]
    pub quiet: bool,
    /// Unit of magnetic fields in printed text (JSON and files keep microtesla)
    #[arg(long, global = true, value_enum, ignore_case = true, value_name = "UNIT", default_value = "ut")]
    pub unit: FieldUnit,
}

/// How much is printed, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// One JSON object.
    Json,
    /// One line.
    Line,
    /// The answer, at most a screen.
    Brief,
    /// The answer and every figure.
    Full,
}

#[cfg(not(target_arch = "wasm32"))]
impl Cli {
    /// The form that the options ask for.
    pub fn form(&self) -> Form {
        match (self.json, self.quiet, self.verbose) {
            (true, ..) => Form::Json,
            (_, true, _) => Form::Line,
            (.., true) => Form::Full,
            _ => Form::Brief,
        }
    }
}

/// The commands.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Calibrate: offset and matrix from a log of the sensor turned through many attitudes
    Fit(FitArgs),
    /// Correct a log with a calibration, and show the error before and after
    Apply(ApplyArgs),
    /// Is a calibration still good for a new log?
    Check(CheckArgs),
    /// Write a calibration as Rust, C, JSON, or as parameters for PX4, ArduPilot, Betaflight, ROS, IIO
    Export(ExportArgs),
    /// Write a simulated log whose truth is known (and written into it)
    Simulate(SimulateArgs),
    /// The whole story on an emulated board: turn, calibrate, restart, error before and after
    Demo(DemoArgs),
    /// Find the missing effect: what the calibration does not explain, and why
    Diagnose(DiagnoseArgs),
    /// Study many logs: one row per log, and what they have in common
    Batch(BatchArgs),
    /// Put a calibration with its effects on a board
    Send(SendArgs),
    /// Bring a board's calibration here
    Fetch(FetchArgs),
    /// Write a board's stream as a log
    Record(RecordArgs),
    /// One page about a log, to be read in a browser: verdict, sphere, plots, and effects as switches
    Report(ReportArgs),
    /// Read a log of another program, and write it as CSV
    Import(ImportArgs),
    /// Calibrate a connected board in a browser: where to turn, how good it is, why it is off
    Live(LiveArgs),
    /// The page by itself, to be put on any web server: logs are read and fitted in the browser
    Web(WebArgs),
}

/// `fit`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout fit log.csv                               look at the calibration
  ironout fit log.csv -o cal.json                   and keep it, if accepted
  ironout fit raw.csv --ut-per-count 0.0333         counts, 0.0333 µT each
  ironout fit log.csv --at 52.52,13.40,2026-03-01   scale to Berlin's field
  ironout fit x.csv --map mx_ut=MagX,my_ut=MagY,mz_ut=MagZ --rotate roll180
  ironout fit monday.csv tuesday.csv -o cal.json    two recordings, one calibration

Turn the sensor slowly through as many attitudes as you can, away from iron:
for example a full turn about each of its axes, and once more tilted. Exit
status 1: refused, and the reason says what to do.")]
pub struct FitArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub field: FieldArgs,
    /// Write the calibration here, if it is accepted (a refused one never replaces a file)
    #[arg(short, long, value_name = "CAL.json")]
    pub output: Option<PathBuf>,
    /// Add an effect to the model, as diagnose names it (repeatable); refused where the log does not show it
    #[arg(long, value_name = "EFFECT")]
    pub add: Vec<String>,
    /// Keep added effects that the log does not show
    #[arg(long, requires = "add")]
    pub force_effect: bool,
    /// Fit on top of an earlier calibration's information
    #[arg(long, value_name = "CAL.json")]
    pub prior: Option<PathBuf>,
    /// Take only the matrix of --prior as known and fit the offset anew: after a battery swap, at another place of the same vehicle
    #[arg(long, value_name = "WHAT", requires = "prior")]
    pub free: Option<Free>,
    /// Attitudes that the calibration is for: all, level (tilts up to 5°), boat (up to 20°), or a tilt in degrees. Without it: all where
    /// the log carries that, else those that it shows
    #[arg(long = "for", value_name = "ATTITUDES", value_parser = purpose)]
    pub purpose: Option<Purpose>,
}

/// What `--free` fits anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Free {
    /// The hard iron.
    Offset,
}

fn purpose(text: &str) -> Result<Purpose, String> {
    match text {
        "all" => Ok(Purpose::All),
        "level" => Ok(Purpose::Tilt(5.0)),
        "boat" => Ok(Purpose::Tilt(20.0)),
        _ => {
            let tilt = text.parse::<f64>().ok().filter(|tilt| (0.0..=90.0).contains(tilt));
            tilt.map(Purpose::Tilt)
                .ok_or_else(|| "expected all, level, boat, or degrees of tilt from 0 to 90".into())
        }
    }
}

/// `apply`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout apply log.csv --cal cal.json                    error before and after
  ironout apply log.csv --cal cal.json -o corrected.csv   and the corrected log

The corrected log keeps every column and gains cx_ut,cy_ut,cz_ut (corrected
vector, body axes), norm_ut (its magnitude) and residual_ut (magnitude minus
the calibration's field).")]
pub struct ApplyArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    /// The calibration
    #[arg(long, value_name = "CAL.json")]
    pub cal: PathBuf,
    /// Write the corrected log here (-: to standard output; of one log only)
    #[arg(short, long, value_name = "OUT.csv")]
    pub output: Option<PathBuf>,
}

/// `check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout check today.csv --cal cal.json && echo still good

Says good; field (another magnitude, the calibration holds); moved (another
offset: a magnet, a new part, a shock); worse (errors grew, and neither
explains it); heading (the log's heading_deg says so); or unknown (too few
directions). Exit status 0 where the calibration can be kept, 1 where not.")]
pub struct CheckArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    /// The calibration
    #[arg(long, value_name = "CAL.json")]
    pub cal: PathBuf,
    /// Degrees that magnetic north is east of true north, where heading_deg counts from true north
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = declination)]
    pub declination: Option<f64>,
}

fn declination(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.abs() <= 180.0);
    value.ok_or_else(|| "expected degrees from -180 to 180, positive to the east".into())
}

/// `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout simulate -o log.csv --seed 1 --seconds 60 --rate 50
  ironout simulate -o hot.csv --seconds 120 --effect offset:temp_c=3

The log carries its truth as # comments. The same seed gives the same log. The
strength of an effect is the rms of its disturbance in multiples of the noise
(3 if not given).")]
pub struct SimulateArgs {
    /// Write the log here (-: to standard output)
    #[arg(short, long, value_name = "LOG")]
    pub output: PathBuf,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Length of the log
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    pub seconds: f64,
    /// Samples a second
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    pub rate: f64,
    /// Standard deviation of the noise on each axis, microtesla
    #[arg(long, value_name = "UT", default_value_t = 0.25)]
    pub noise: f64,
    /// Hide an effect (or a fault of the data: burst, clipping, stuck, gap …) in the log (repeatable)
    #[arg(long, value_name = "ID[=STRENGTH]")]
    pub effect: Vec<String>,
    /// Another recording of the same board with the same hidden effects: other motion, other currents, other noise (a drift goes on as
    /// fast, and a step comes at its time again, as in no real one)
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub recording: u64,
    /// How the board is turned: sphere | hand | planar | rest | cap=SHARE of the sphere
    #[arg(long, value_name = "MOTION", default_value = "sphere")]
    pub motion: String,
    /// Let the temperature rise steadily with time instead of warming up
    #[arg(long)]
    pub ramp: bool,
    /// Leave a column out of the log (repeatable)
    #[arg(long, value_name = "COLUMN")]
    pub without: Vec<String>,
}

/// `import`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout import phone.csv -o log.csv
  ironout import putty.log -o log.csv --map 'mx_ut=column 1[mG],my_ut=column 2[mG],mz_ut=column 3[mG]'
  socat -u /dev/ttyACM0,b115200 - | ironout import - -o log.csv

Told by content: tables with any separator, prints of a serial monitor,
MotionCal lines, streams of a board. What was read as what is said, and the
--map that pins it.")]
pub struct ImportArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    /// Write the log here; - is standard output
    #[arg(short, long, value_name = "LOG.csv")]
    pub output: PathBuf,
}

/// `diagnose`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  ironout diagnose log.csv
  ironout diagnose flight.csv --derive 'drive=throttle^1.5*vbat'   a guess of your own")]
pub struct DiagnoseArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub field: FieldArgs,
    /// Begin with this effect in the model (repeatable)
    #[arg(long, value_name = "EFFECT")]
    pub add: Vec<String>,
    /// Study on top of an earlier calibration's information
    #[arg(long, value_name = "CAL.json")]
    pub prior: Option<PathBuf>,
}
