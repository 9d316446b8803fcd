//! The command line: what can be asked, with help and examples.

#[cfg(feature = "program")]
pub use crate::cli_batch::BatchArgs;
#[cfg(feature = "program")]
pub use crate::cli_demo::{BoardArg, DemoArgs, HiddenArg};
pub use crate::cli_export::{ExportArgs, ExportForm};
#[cfg(feature = "program")]
use crate::cli_help::{CompletionsArgs, EffectsArgs, ManArgs};
#[cfg(feature = "program")]
pub use crate::cli_page::{LiveArgs, ReportArgs, WebArgs};
#[cfg(feature = "program")]
use crate::field_unit::FieldUnit;
use crate::headings::known_heading;
#[cfg(feature = "program")]
use crate::link_args::{FetchArgs, RecordArgs, SendArgs};
use clap::Args;
#[cfg(feature = "program")]
use clap::{Parser, Subcommand};
use ironout_analysis::confined::guided::KnownHeading;
use ironout_analysis::outcome::request::Purpose;
use std::path::PathBuf;

pub use crate::log_args::{Expected, FieldArgs, LogArgs, MethodArg, scale};
pub use crate::shell::{quoted, typed_option};

#[cfg(feature = "program")]
const ABOUT: &str = "Calibrate a magnetometer and find out what causes the remaining error.

A log is a recording of a board, phone or autopilot. ironout detects its format
from the content, and prints how it read the file. Its own format is CSV with
units in the header: t_s,mx_ut,my_ut,mz_ut (microtesla), or mx_counts,… with
--ut-per-count, and any other columns (ax_mps2,…, gx_radps,…, temp_c, motor_a).
Body axes: x forward, y right, z down. docs/command-line.md has all of it.";

#[cfg(feature = "program")]
const EXAMPLES: &str = "Examples:
  ironout simulate -o log.csv --seed 1         create a log to try
  ironout fit log.csv -o cal.json              calibrate, and keep the result
  ironout diagnose log.csv                     find the cause of the remaining error
  ironout apply log.csv --cal cal.json         error before and after
  ironout check later.csv --cal cal.json       is the calibration still good?
  ironout export cal.json --as c               use it in your firmware
  ironout demo                                 a board calibrates itself

Exit status: 0 done, 1 the data do not support a calibration, 2 bad input or
usage.";

/// The command line.
#[cfg(feature = "program")]
#[derive(Debug, Parser)]
#[command(name = "ironout", version, about = ABOUT, after_help = EXAMPLES, max_term_width = 110)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
    /// Print one JSON object and nothing else on standard output (unknown values are null)
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

#[cfg(feature = "program")]
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
#[cfg(feature = "program")]
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Calibrate: fit offset and matrix to a log of the sensor in many orientations
    Fit(FitArgs),
    /// Correct a log with a calibration, and print the error before and after
    Apply(ApplyArgs),
    /// Check whether a calibration is still good for a new log
    Check(CheckArgs),
    /// Write a calibration as Rust, C, JSON, or as parameters for PX4, ArduPilot, Betaflight, ROS, IIO
    Export(ExportArgs),
    /// Write a simulated log whose truth is known (and written into it)
    Simulate(SimulateArgs),
    /// Run a complete calibration on an emulated board, with the error before and after
    Demo(DemoArgs),
    /// Find out what causes the remaining error
    Diagnose(DiagnoseArgs),
    /// List the effects that can be tested on a log, and what it lacks for the others
    Effects(EffectsArgs),
    /// Study many logs: one row per log, and what they have in common
    Batch(BatchArgs),
    /// Put a calibration with its effects on a board
    Send(SendArgs),
    /// Read the calibration of a board
    Fetch(FetchArgs),
    /// Record the samples of a board as a log
    Record(RecordArgs),
    /// Write a page about a log for a browser: verdict, sphere, plots, effects to switch on and off
    Report(ReportArgs),
    /// Read a log of another program, and write it as CSV
    Import(ImportArgs),
    /// Calibrate a connected board in a browser, with directions, quality and causes of error
    Live(LiveArgs),
    /// Write the page for a web server: it reads and fits logs in the browser
    Web(WebArgs),
    /// Print the completion script of a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write one for each command
    Man(ManArgs),
}

/// `fit`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout fit log.csv                               print the calibration
  ironout fit log.csv -o cal.json                   and write it, if accepted
  ironout fit log.csv -v                            with matrix and all figures
  ironout fit raw.csv --ut-per-count 0.0333         counts, 0.0333 µT per count
  ironout fit log.csv --at 52.52,13.40,2026-03-01   scale to Berlin's field
  ironout fit x.csv --map mx_ut=MagX,my_ut=MagY,mz_ut=MagZ --rotate roll180
  ironout fit monday.csv tuesday.csv -o cal.json    two recordings, one calibration

Rotate the sensor slowly through as many orientations as you can, away from
iron: for example a full turn about each of its axes, and again when tilted.
Exit status 1: refused; the reason is printed.")]
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
    /// Add an effect to the model, as diagnose names it (repeatable); refused if it is not significant in the log
    #[arg(long, value_name = "EFFECT")]
    pub add: Vec<String>,
    /// Keep effects given with --add even if the log shows no evidence for them
    #[arg(long, requires = "add")]
    pub force_effect: bool,
    /// Use the information of an earlier calibration
    #[arg(long, value_name = "CAL.json", group = "earlier")]
    pub prior: Option<PathBuf>,
    /// Use another log of the same sensor, fitted first, as the earlier calibration; or "parameters", the compass calibration of
    /// the autopilot that recorded this log
    #[arg(long, value_name = "LOG|parameters", group = "earlier")]
    pub prior_from: Option<PathBuf>,
    /// Keep only the matrix of the earlier calibration and fit the offset again: after a battery swap, or at another place of
    /// the same vehicle
    #[arg(long, value_name = "WHAT", requires = "earlier")]
    pub free: Option<Free>,
    /// A true heading that you know at a time of the log, as 12.5=90: s, degrees clockwise from north (repeatable). Needs an
    /// accelerometer and a gyro
    #[arg(long = "heading", value_name = "T=DEG", value_parser = known_heading, allow_hyphen_values = true)]
    pub headings: Vec<KnownHeading>,
    /// Orientations that the calibration is for: all, level (tilts up to 5°), boat (up to 20°), or a tilt in degrees (default: all if the
    /// log contains them, otherwise those in the log)
    #[arg(long = "for", value_name = "ORIENTATIONS", value_parser = purpose)]
    pub purpose: Option<Purpose>,
}

/// What `--free` fits again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Free {
    /// The hard iron.
    Offset,
}

/// Reads the attitudes of `--for`.
///
/// # Errors
/// What is expected, in words.
pub fn purpose(text: &str) -> Result<Purpose, String> {
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

Results: good; field (another field strength, the calibration is still good);
moved (another offset: a magnet, a new part, a shock); other (another sensor,
mounting or scale); heading (wrong compared with heading_deg); worse (the
errors have grown for another reason); unknown (too few directions). Exit
status 0 if the calibration can be kept, else 1.")]
pub struct CheckArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    /// The calibration
    #[arg(long, value_name = "CAL.json")]
    pub cal: PathBuf,
    /// Declination: degrees that magnetic north is east of true north, if heading_deg is relative to true north
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

The log contains its truth as # comments. The same seed gives the same log.
A column of any name can drive an effect: temp_c warms up, current_a comes in
bursts, servo has levels, load is rough, every other one wanders slowly. The
strength of an effect is the rms of its disturbance in multiples of the noise
(3 if not given).")]
pub struct SimulateArgs {
    /// Write the log here (-: to standard output)
    #[arg(short, long, value_name = "LOG")]
    pub output: PathBuf,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Length of the log
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    pub seconds: f64,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    pub rate: f64,
    /// Standard deviation of the noise on each axis, microtesla
    #[arg(long, value_name = "UT", default_value_t = 0.25)]
    pub noise: f64,
    /// Hide an effect (or a fault of the data: burst, clipping, stuck, gap …) in the log (repeatable)
    #[arg(long, value_name = "ID[=STRENGTH]")]
    pub effect: Vec<String>,
    /// Another recording of the same sensor with the same hidden effects: other motion, other currents, other noise (but the same drift,
    /// and a step at the same time)
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub recording: u64,
    /// Motion of the sensor: sphere | hand | planar | rest | cap=SHARE of the sphere
    #[arg(long, value_name = "MOTION", default_value = "sphere")]
    pub motion: String,
    /// Let the temperature rise steadily with time instead of warming up
    #[arg(long)]
    pub ramp: bool,
    /// Omit a column from the log (repeatable)
    #[arg(long, value_name = "COLUMN")]
    pub without: Vec<String>,
}

/// `import`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout import phone.csv -o log.csv
  ironout import putty.log -o log.csv --map 'mx_ut=column 1[mG],my_ut=column 2[mG],mz_ut=column 3[mG]'
  socat -u /dev/ttyACM0,b115200 - | ironout import - -o log.csv

ironout detects the format from the content: tables with any separator, prints
of a serial monitor, MotionCal lines, streams of a board. It prints how it read
each column, and the --map option that fixes this interpretation.")]
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
#[command(after_help = "Examples:
  ironout diagnose log.csv
  ironout diagnose log.csv -v                 with the residual by column
  ironout diagnose flight.csv --derive 'drive=throttle^1.5*vbat'   test a hypothesis")]
pub struct DiagnoseArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub field: FieldArgs,
    /// Start with this effect in the model (repeatable)
    #[arg(long, value_name = "EFFECT")]
    pub add: Vec<String>,
    /// Use the information of an earlier calibration
    #[arg(long, value_name = "CAL.json")]
    pub prior: Option<PathBuf>,
}
