//! The arguments of the commands that read a log: how it is read, and what is known of the field.

use crate::failure::{Failure, Outcome};
use crate::geomag::EarthField;
use crate::input::{self, Log, Mounting, ReadOptions};
use crate::shell::{quoted, typed_option};
use clap::{Args, ValueEnum};
use ironout::fit::Method;
use std::path::{Path, PathBuf};

/// What a log from standard input is called in the commands that come next.
pub const SAVED: &str = "log.csv";

/// Options about reading a log.
#[derive(Debug, Args, Clone)]
pub struct LogArgs {
    /// The log, in any supported format (docs/formats.md); ironout detects the format from the content; - is standard input
    pub log: PathBuf,
    /// Further logs of the same sensor in the same mounting
    #[arg(value_name = "LOG")]
    pub more: Vec<PathBuf>,
    /// Scale of raw counts, in µT per count: one number, or three (x,y,z)
    #[arg(long, value_name = "UT[,UT,UT]", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub ut_per_count: Option<String>,
    /// Which column is what, with its unit (repeatable)
    #[arg(
        help = "Map columns: NAME=HEADER[UNIT], e.g. mx_ut=MagX[mG],my_ut=MagY[mG],mz_ut=MagZ[mG],t_s=time[ms] (repeatable)"
    )]
    #[arg(long, value_name = "NAME=HEADER[UNIT],…", help_heading = "Reading the log")]
    pub map: Vec<String>,
    /// From the sensor's mounting to body axes: roll180 | roll180,yaw90 | y,-x,z (body x,y,z from sensor axes) | nine
    /// numbers; mag:, accel: or gyro: before it turns one sensor only (repeatable)
    #[arg(long, value_name = "ROTATION", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub rotate: Vec<String>,
    /// Which magnetometer of the log, if it has several
    #[arg(long, value_name = "N", help_heading = "Reading the log")]
    pub instance: Option<usize>,
    /// Add a computed column, row by row: 'drive=throttle^1.5*vbat' (repeatable); operators + - * / ^,
    /// functions sin, sqrt, exp, min(a,b), diff(x), lowpass(x,seconds) …
    #[arg(
        long,
        value_name = "NAME=EXPRESSION",
        help_heading = "Reading the log",
        allow_hyphen_values = true
    )]
    pub derive: Vec<String>,
    /// Ignore a column, as if the log did not contain it (repeatable)
    #[arg(long, value_name = "COLUMN", help_heading = "Reading the log")]
    pub ignore: Vec<String>,
    /// Broken numbers of the magnetometer, repaired (repeatable): unsigned, swapped-bytes, signed-low-byte, x:unwrap=…, x:late=ROWS,
    /// range, error-code=VALUE; none takes them as they are
    #[arg(
        help = "Repair corrupted magnetometer numbers: unsigned | swapped-bytes | signed-low-byte | x:unwrap=MODULUS/FROM | \
             x:late=ROWS | range | error-code=VALUE, prefixed with the axes if not all are affected (xy:unsigned); none \
             uses the numbers unchanged (repeatable)"
    )]
    #[arg(long, value_name = "REPAIR", help_heading = "Reading the log", allow_hyphen_values = true)]
    pub repair: Vec<String>,
    /// The day of the log: for the field along lat_deg, lon_deg and the height
    #[arg(long, value_name = "YYYY-MM-DD", help_heading = "Reading the log")]
    pub date: Option<String>,
    /// The true field at every row: a magnitude (a proton, fluxgate or base station magnetometer, a coil), or three columns of
    /// a reference sensor in any axes; the unit comes from the end of the name (_nt, _ut, _g), otherwise from the size
    #[arg(long, value_name = "COLUMN[,COLUMN,COLUMN]", help_heading = "Reading the log")]
    pub reference: Option<String>,
}

impl LogArgs {
    /// A log without any option.
    pub fn of(log: &Path) -> LogArgs {
        LogArgs {
            log: log.to_path_buf(),
            more: Vec::new(),
            ut_per_count: None,
            map: Vec::new(),
            rotate: Vec::new(),
            instance: None,
            derive: Vec::new(),
            ignore: Vec::new(),
            repair: Vec::new(),
            date: None,
            reference: None,
        }
    }

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
            repair: input::parse_repair(&self.repair)?,
            progress: true,
        })
    }

    /// The log and the options it was read with, as they are typed: for the next command that is suggested.
    pub fn typed(&self) -> String {
        let name = |log: &PathBuf| match log.to_str() {
            // What came from there comes no second time.
            Some("-") => SAVED.to_string(),
            _ => typed_path(&log.display().to_string()),
        };
        let logs: Vec<String> = self.logs().map(name).collect();
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
        let options = options.chain(self.repair.iter().map(|value| ("--repair", value)));
        let options = options.chain(instance.iter().map(|value| ("--instance", value)));
        let options = options.chain(self.derive.iter().map(|value| ("--derive", value)));
        let options = options.chain(self.ignore.iter().map(|value| ("--ignore", value)));
        let options = options.chain(self.date.iter().map(|value| ("--date", value)));
        let options = options.chain(self.reference.iter().map(|value| ("--reference", value)));
        options.map(|(option, value)| typed_option(option, value)).collect()
    }
}

/// A file as it is typed: one that begins with a minus would be read as an option.
fn typed_path(path: &str) -> String {
    if path.starts_with('-') && path != "-" { quoted(&format!("./{path}")) } else { quoted(path) }
}

/// Scale in µT per count for x, y, z, of one number or of three.
///
/// # Errors
/// What is not a positive number, with the form.
pub fn scale(text: &str) -> Outcome<[f64; 3]> {
    let values: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0))
        .collect();
    match values.as_deref() {
        Some([one]) => Ok([*one; 3]),
        Some([x, y, z]) => Ok([*x, *y, *z]),
        _ => Err(Failure::usage(format!(
            "--ut-per-count {text}: expected one positive number, or three for x,y,z, in µT per count, as in \
             --ut-per-count 0.0333 (for an axis with the wrong sign use --rotate)"
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
    /// Field strength of corrected vectors, in µT (default: mean field strength of the log)
    #[arg(long, value_name = "UT", conflicts_with = "at", allow_hyphen_values = true)]
    pub field: Option<f64>,
    /// Set the field strength from the World Magnetic Model at this latitude, longitude (degrees) and date (YYYY-MM-DD)
    #[arg(long, value_name = "LAT,LON,DATE", allow_hyphen_values = true)]
    pub at: Option<String>,
    /// How to fit offset and matrix (with --add or --prior, everything is fitted together)
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

impl Expected {
    /// With the mean of a reference that was logged, where no magnitude was given.
    pub fn or_reference(self, arguments: &LogArgs, log: &Log) -> Expected {
        let logged = log.earth.as_ref().filter(|_| arguments.reference.is_some());
        let mean = logged.map(|[field, _]| field.iter().sum::<f64>() / field.len().max(1) as f64);
        Expected { field_ut: self.field_ut.or(mean), ..self }
    }
}

impl FieldArgs {
    /// The method of the base model.
    ///
    /// # Errors
    /// If effects or an earlier calibration are to be fitted together with it, which these methods do not.
    pub fn method_with(&self, add: &[String], prior: Option<&PathBuf>) -> Outcome<Method> {
        let method = match self.method {
            MethodArg::Adjusted => Method::Adjusted,
            MethodArg::Trace => Method::Trace,
            MethodArg::Constant => Method::Constant,
        };
        if method != Method::Adjusted && !(add.is_empty() && prior.is_none()) {
            return Err(Failure::usage(format!(
                "--method {}: this method cannot be combined with --add or --prior. Omit it",
                method.name()
            )));
        }
        Ok(method)
    }

    /// The options as they are typed. With effects, everything is fitted together, whatever the base's method.
    pub fn typed(&self, with_effects: bool) -> String {
        let mut words = String::new();
        if let Some(field) = self.field {
            words.push_str(&typed_option("--field", &field.to_string()));
        }
        if let Some(at) = &self.at {
            words.push_str(&typed_option("--at", at));
        }
        match self.method {
            MethodArg::Adjusted => {}
            _ if with_effects => {}
            MethodArg::Trace => words.push_str(" --method trace"),
            MethodArg::Constant => words.push_str(" --method constant"),
        }
        words
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
