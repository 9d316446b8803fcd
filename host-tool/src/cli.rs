//! The command line: what can be asked, with help and examples.

use crate::failure::{Failure, Outcome};
use crate::geomag::EarthField;
use crate::input::{self, Mounting, ReadOptions};
use clap::{Args, Parser, Subcommand, ValueEnum};
use ironout::fit::Method;
use std::path::PathBuf;

const ABOUT: &str = "Calibrates magnetometers and shows what the calibration leaves over.

A log is a CSV file whose header names its units: t_s,mx_ut,my_ut,mz_ut
(microtesla) or mx_counts,… with --ut-per-count. Other columns (accelerometer
ax_mps2,…, gyroscope gx_radps,…, temp_c, motor_a, anything) are welcome.
Body axes: x forward, y right, z down. docs/command-line.md has all of it.";

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
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Calibrate: offset and matrix from a log of the sensor turned through many attitudes
    Fit(FitArgs),
    /// Correct a log with a calibration, and show the error before and after
    Apply(ApplyArgs),
    /// Is a calibration still good for a new log?
    Check(CheckArgs),
    /// Write a calibration as Rust, C or JSON
    Export(ExportArgs),
    /// Write a simulated log whose truth is known (and written into it)
    Simulate(SimulateArgs),
    /// The whole story on an emulated board: turn, calibrate, restart, error before and after
    Demo(DemoArgs),
    /// Find the missing effect: what the calibration does not explain, and why
    Diagnose(DiagnoseArgs),
    /// A page with the plots of a log and its calibration (not built yet)
    Report(LaterArgs),
    /// Read other programs' logs (not built yet)
    Import(LaterArgs),
    /// Calibrate a connected board while watching (not built yet)
    Live(LaterArgs),
}

/// Options about reading a log.
#[derive(Debug, Args, Clone)]
pub struct LogArgs {
    /// The log (CSV with a header)
    pub log: PathBuf,
    /// Scale of mx_counts,… in microtesla a count: one number, or three for x,y,z
    #[arg(long, value_name = "UT[,UT,UT]", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub ut_per_count: Option<String>,
    /// Take other headers: mx_ut=MagX,my_ut=MagY,mz_ut=MagZ (repeatable)
    #[arg(long, value_name = "NAME=HEADER,…", help_heading = "Reading the log")]
    pub map: Vec<String>,
    /// From the sensor's mounting to body axes: roll180 | roll180,yaw90 | y,-x,z (body x,y,z from sensor axes) | nine
    /// numbers; mag:, accel: or gyro: before it turns one sensor only (repeatable)
    #[arg(long, value_name = "ROTATION", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub rotate: Vec<String>,
    /// Which magnetometer of the log, where it has several
    #[arg(long, value_name = "N", help_heading = "Reading the log")]
    pub instance: Option<usize>,
}

impl LogArgs {
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
        self.typed_for(&self.log.display().to_string())
    }

    /// The same options with another log.
    pub fn typed_for(&self, log: &str) -> String {
        // A file that begins with a minus would be taken for an option.
        let mut typed = if log.starts_with('-') { quoted(&format!("./{log}")) } else { quoted(log) };
        let options = self.ut_per_count.iter().map(|value| ("--ut-per-count", value));
        let options = options.chain(self.map.iter().map(|value| ("--map", value)));
        for (option, value) in options.chain(self.rotate.iter().map(|value| ("--rotate", value))) {
            typed.push_str(&typed_option(option, value));
        }
        typed
    }
}

/// A word of a POSIX shell: quoted only where it must be.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./:=,+@%^".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// ` --option value`; a value that begins with a minus needs the equals sign.
pub fn typed_option(option: &str, value: &str) -> String {
    format!(" {option}{}{}", if value.starts_with('-') { "=" } else { " " }, quoted(value))
}

fn scale(text: &str) -> Outcome<[f64; 3]> {
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
    /// Write the corrected log here
    #[arg(short, long, value_name = "OUT.csv")]
    pub output: Option<PathBuf>,
}

/// `check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout check today.csv --cal cal.json && echo still good

Says good; field (another magnitude, the calibration holds); moved (another
offset: a magnet, a new part, a shock); worse (errors grew, and neither
explains it); or unknown (too few directions). Exit status 0 where the
calibration can be kept, 1 where not.")]
pub struct CheckArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    /// The calibration
    #[arg(long, value_name = "CAL.json")]
    pub cal: PathBuf,
}

/// The forms of `export`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportForm {
    /// A Rust const for the crate ironout
    Rust,
    /// A C header with a function that applies it
    C,
    /// The calibration file itself, checked
    Json,
}

/// `export`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout export cal.json --as rust -o src/calibration.rs
  ironout export cal.json --as c -o calibration.h")]
pub struct ExportArgs {
    /// The calibration
    pub cal: PathBuf,
    /// The form
    #[arg(long = "as", value_enum)]
    pub form: ExportForm,
    /// Write here instead of to standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
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
    /// Write the log here
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

/// `demo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout demo
  ironout demo --board pico

Needs qemu-system-arm for mps2, without which the same session runs on a
simulated bus, and Node with rp2040js (npm ci in host-tests/pico) for pico.")]
pub struct DemoArgs {
    /// Use the simulated bus even where QEMU is installed
    #[arg(long)]
    pub no_qemu: bool,
    /// The board whose firmware is emulated
    #[arg(long, value_enum, value_name = "BOARD", default_value = "mps2")]
    pub board: BoardArg,
}

/// The boards that can be emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BoardArg {
    /// Arm's MPS2 with a Cortex-M4F, in QEMU
    Mps2,
    /// A Raspberry Pi Pico, in rp2040js
    Pico,
}

/// `diagnose`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  ironout diagnose log.csv")]
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

/// Any arguments of a command that is not built yet.
#[derive(Debug, Args)]
pub struct LaterArgs {
    /// Whatever follows
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    pub rest: Vec<String>,
}
