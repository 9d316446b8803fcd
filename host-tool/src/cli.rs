//! The command line: what can be asked, with help and examples.

#[cfg(not(target_arch = "wasm32"))]
pub use crate::cli_demo::{BoardArg, DemoArgs, HiddenArg};
pub use crate::cli_export::{ExportArgs, ExportForm};
use crate::failure::{Failure, Outcome};
use crate::geomag::EarthField;
use crate::input::{self, Mounting, ReadOptions};
#[cfg(not(target_arch = "wasm32"))]
pub use crate::cli_page::{LiveArgs, ReportArgs, WebArgs};
#[cfg(not(target_arch = "wasm32"))]
use crate::link_args::{FetchArgs, RecordArgs, SendArgs};
use clap::{Args, ValueEnum};
#[cfg(not(target_arch = "wasm32"))]
use clap::{Parser, Subcommand};
use ironout::fit::Method;
use std::path::{Path, PathBuf};

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

/// Options about reading a log.
#[derive(Debug, Args, Clone)]
pub struct LogArgs {
    /// The log: any format that is read (docs/formats.md), told by its content; - is standard input
    pub log: PathBuf,
    /// Further logs of the same sensor in the same mounting
    #[arg(value_name = "LOG")]
    pub more: Vec<PathBuf>,
    /// Scale of mx_counts,… in microtesla a count: one number, or three for x,y,z
    #[arg(long, value_name = "UT[,UT,UT]", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub ut_per_count: Option<String>,
    /// Which column is what, with its unit (repeatable)
    #[arg(
        help = "Which column is what: mx_ut=MagX,my_ut=MagY,mz_ut=MagZ, with its unit as in t_s=time[ms] or mx_ut=MagX[mG] (repeatable)"
    )]
    #[arg(long, value_name = "NAME=HEADER[UNIT],…", help_heading = "Reading the log")]
    pub map: Vec<String>,
    /// From the sensor's mounting to body axes: roll180 | roll180,yaw90 | y,-x,z (body x,y,z from sensor axes) | nine
    /// numbers; mag:, accel: or gyro: before it turns one sensor only (repeatable)
    #[arg(long, value_name = "ROTATION", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub rotate: Vec<String>,
    /// Which magnetometer of the log, where it has several
    #[arg(long, value_name = "N", help_heading = "Reading the log")]
    pub instance: Option<usize>,
    /// A further column, computed from others row by row: 'drive=throttle^1.5*vbat' (repeatable); operators + - * / ^,
    /// functions sin, sqrt, exp, min(a,b), diff(x), lowpass(x,seconds) …
    #[arg(
        long,
        value_name = "NAME=EXPRESSION",
        help_heading = "Reading the log",
        allow_hyphen_values = true
    )]
    pub derive: Vec<String>,
}

impl LogArgs {
    /// Every log that is named.
    pub fn logs(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.log).chain(&self.more)
    }

    /// The same options for one log alone.
    pub fn alone(&self, log: &Path) -> LogArgs {
        LogArgs { log: log.to_path_buf(), more: Vec::new(), ..self.clone() }
    }

    /// The reader's options; errors name the option.
    pub fn options(&self) -> Outcome<ReadOptions> {
        Ok(ReadOptions {
            map: input::parse_map(&self.map)?,
            mounting: Mounting::parse(&self.rotate)?,
            ut_per_count: self.ut_per_count.as_deref().map(scale).transpose()?,
            default_ut_per_count: None,
            instance: self.instance,
            progress: true,
        })
    }

    /// The log and the options it was read with, as they are typed: for the next command that is suggested.
    pub fn typed(&self) -> String {
        let logs: Vec<String> = self.logs().map(|log| typed_path(&log.display().to_string())).collect();
        logs.join(" ") + &self.typed_options()
    }

    /// The same options with another log; the log's own name where it is one of these.
    pub fn typed_for(&self, log: &str) -> String {
        typed_path(log) + &self.typed_options()
    }

    fn typed_options(&self) -> String {
        let instance = self.instance.map(|number| number.to_string());
        let options = self.ut_per_count.iter().map(|value| ("--ut-per-count", value));
        let options = options.chain(self.map.iter().map(|value| ("--map", value)));
        let options = options.chain(self.rotate.iter().map(|value| ("--rotate", value)));
        let options = options.chain(instance.iter().map(|value| ("--instance", value)));
        let options = options.chain(self.derive.iter().map(|value| ("--derive", value)));
        options.map(|(option, value)| typed_option(option, value)).collect()
    }
}

/// A file as it is typed: one that begins with a minus would be taken for an option.
fn typed_path(path: &str) -> String {
    if path.starts_with('-') && path != "-" { quoted(&format!("./{path}")) } else { quoted(path) }
}

/// Microtesla a count for x, y, z, of one number or of three.
///
/// # Errors
/// What is no positive number, with the form.
pub fn scale(text: &str) -> Outcome<[f64; 3]> {
    let values: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0))
        .collect();
    match values.as_deref() {
        Some([one]) => Ok([*one; 3]),
        Some([x, y, z]) => Ok([*x, *y, *z]),
        _ => Err(Failure::usage(format!(
            "--ut-per-count {text}: expected one positive number, or three for x,y,z, in microtesla a count, as in \
             --ut-per-count 0.0333 (an axis of the wrong sign is for --rotate)"
        ))),
    }
}

/// The fit's way through the normal equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Adjusted least squares: no noise bias, estimates the noise too
    Adjusted,
    /// Trace normalisation: plain least squares, never singular
    Trace,
    /// Constant normalisation: the nine columns of the paper
    Constant,
}

/// Options about the field and the method.
#[derive(Debug, Args, Clone)]
pub struct FieldArgs {
    /// The magnitude to scale corrected vectors to, microtesla (without it, the log's own mean is kept)
    #[arg(long, value_name = "UT", conflicts_with = "at", allow_hyphen_values = true)]
    pub field: Option<f64>,
    /// The same from the world magnetic model: degrees north, degrees east, YYYY-MM-DD
    #[arg(long, value_name = "LAT,LON,DATE", allow_hyphen_values = true)]
    pub at: Option<String>,
    /// How to fit offset and matrix (with effects, or on top of --prior, everything is fitted at once)
    #[arg(long, value_enum, default_value_t = MethodArg::Adjusted)]
    pub method: MethodArg,
}

/// What is known of the field before the fit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Expected {
    /// `--field`, or F of `--at`.
    pub field_ut: Option<f64>,
    /// The model's answer to `--at`.
    pub earth: Option<EarthField>,
}

impl FieldArgs {
    /// The method of the base model.
    ///
    /// # Errors
    /// Where effects or an earlier calibration are to be fitted together with it, which these methods do not.
    pub fn method_with(&self, add: &[String], prior: Option<&PathBuf>) -> Outcome<Method> {
        let method = match self.method {
            MethodArg::Adjusted => Method::Adjusted,
            MethodArg::Trace => Method::Trace,
            MethodArg::Constant => Method::Constant,
        };
        if method != Method::Adjusted && !(add.is_empty() && prior.is_none()) {
            return Err(Failure::usage(format!(
                "--method {}: with --add and --prior everything is fitted at once, which these methods do not: leave it out",
                method.name()
            )));
        }
        Ok(method)
    }

    /// The expected field; errors name the option.
    pub fn expected(&self) -> Outcome<Expected> {
        if let Some(text) = &self.at {
            let earth = EarthField::parse(text)?;
            return Ok(Expected { field_ut: Some(earth.field_ut), earth: Some(earth) });
        }
        if let Some(field) = self.field
            && !(field.is_finite() && (1.0..=10_000.0).contains(&field))
        {
            return Err(Failure::usage(format!(
                "--field {field}: expected a magnitude in microtesla (the Earth's is 22 to 67), from 1 to 10000"
            )));
        }
        Ok(Expected { field_ut: self.field, earth: None })
    }
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
    /// Another recording of the same board with the same hidden effects: other motion, other currents, other noise
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
