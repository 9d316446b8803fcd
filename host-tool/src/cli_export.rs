//! What can be asked of `export`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// The output formats of `export`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportForm {
    /// A Rust const for the crate ironout
    Rust,
    /// A C header with a function that applies it
    C,
    /// The calibration file itself, checked
    Json,
    /// Parameters for PX4 (a file that QGroundControl loads)
    Px4,
    /// Parameters for ArduPilot (a file that Mission Planner or MAVProxy loads)
    Ardupilot,
    /// Lines for Betaflight's command line
    Betaflight,
    /// Parameters for ROS 2 (YAML, magnetometer_pipeline)
    Ros,
    /// Attributes for Linux' Industrial I/O
    Iio,
}

impl ExportForm {
    /// Its word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            ExportForm::Rust => "rust",
            ExportForm::C => "c",
            ExportForm::Json => "json",
            ExportForm::Px4 => "px4",
            ExportForm::Ardupilot => "ardupilot",
            ExportForm::Betaflight => "betaflight",
            ExportForm::Ros => "ros",
            ExportForm::Iio => "iio",
        }
    }
}

/// `export`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout export cal.json --as rust -o src/calibration.rs
  ironout export cal.json --as c -o calibration.h
  ironout export cal.json --as px4 --log log.csv -o mag.params
  ironout export cal.json --as ardupilot --number 2 -o mag2.param

If a program cannot represent the whole calibration, the file states what is
lost. With --log ironout refits it on that log, and states the extra error.
docs/exports.md has the formulas, units and how to load each.")]
pub struct ExportArgs {
    /// The calibration
    pub cal: PathBuf,
    /// Output format
    #[arg(long = "as", value_enum, ignore_case = true, value_name = "FORMAT")]
    pub form: ExportForm,
    /// Output file (default: standard output)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Refit the target's parameters on this log (the one of the calibration), and print the extra error
    #[arg(long, value_name = "LOG", help_heading = "Parameters of other programs")]
    pub log: Option<PathBuf>,
    /// Other headers of that log, as for fit (repeatable)
    #[arg(
        long,
        value_name = "NAME=HEADER,…",
        requires = "log",
        help_heading = "Parameters of other programs"
    )]
    pub map: Vec<String>,
    /// Which magnetometer of the target: PX4 0 to 3, ArduPilot 1 to 3, IIO the device
    #[arg(long, value_name = "N", help_heading = "Parameters of other programs")]
    pub number: Option<usize>,
    /// The sensor's id as the autopilot prints it (PX4 CAL_MAGn_ID, ArduPilot COMPASS_DEV_ID)
    #[arg(long, value_name = "ID", help_heading = "Parameters of other programs")]
    pub device_id: Option<u32>,
    /// PX4, ArduPilot: the whole rotation to the accelerometer as Euler angles (external magnetometers only)
    #[arg(long, help_heading = "Parameters of other programs")]
    pub euler: bool,
    /// Scale of the target's driver in µT per count, for Betaflight and IIO (default: that of the log)
    #[arg(
        long,
        value_name = "UT[,UT,UT]",
        help_heading = "Parameters of other programs",
        allow_hyphen_values = true
    )]
    pub ut_per_count: Option<String>,
}

impl ExportArgs {
    /// An option that is given and says nothing to this form.
    pub fn unused(&self) -> Option<&'static str> {
        use ExportForm::{Ardupilot, Betaflight, C, Iio, Json, Px4, Ros, Rust};
        let form = self.form;
        let unused = |given: bool, by: &[ExportForm], option: &'static str| {
            (given && by.contains(&form)).then_some(option)
        };
        unused(self.log.is_some(), &[Rust, C, Json], "--log")
            .or_else(|| unused(self.number.is_some(), &[Rust, C, Json, Ros], "--number"))
            .or_else(|| {
                unused(self.device_id.is_some(), &[Rust, C, Json, Betaflight, Ros, Iio], "--device-id")
            })
            .or_else(|| unused(self.euler, &[Rust, C, Json, Betaflight, Ros, Iio], "--euler"))
            .or_else(|| {
                unused(self.ut_per_count.is_some(), &[Rust, C, Json, Px4, Ardupilot, Ros], "--ut-per-count")
            })
    }
}
