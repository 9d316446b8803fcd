//! A log in columns, and how to read one.

use crate::input::mount::Mounting;
use crate::input::read_as::ReadAs;
use crate::input::repair_asked::Asked;
use ironout_analysis::frame::Frame;

/// How to read a log.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// `--map`: (name of the format, header in the file).
    pub map: Vec<(String, String)>,
    /// `--rotate`.
    pub mounting: Mounting,
    /// `--ut-per-count`: microtesla a count for x, y, z.
    pub ut_per_count: Option<[f64; 3]>,
    /// The same where the log is in counts and no scale is given: that of a calibration.
    pub default_ut_per_count: Option<[f64; 3]>,
    /// `--instance`: which sensor of the log; `None` where none was asked for.
    pub instance: Option<usize>,
    /// `--repair`.
    pub repair: Vec<Asked>,
    /// Show a progress bar on long work (only where standard error is a terminal).
    pub progress: bool,
}

/// A numeric column that is not a sensor of the format: temperature, current, throttle, anything.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariate {
    /// Its header (after `--map`).
    pub name: String,
    /// One value a row; NaN where the cell is empty, and what was written where it is NaN or infinite.
    pub values: Vec<f64>,
    /// Rows with an empty cell.
    pub empty: usize,
    /// Rows with NaN or an infinity written out.
    pub not_finite: usize,
}

/// A log in columns, every column `rows` long, in body axes and SI-like units.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// The file as it was named.
    pub path: std::path::PathBuf,
    /// Rows read.
    pub rows: usize,
    /// Seconds; `None` without a time column. Never decreasing.
    pub time_s: Option<Vec<f64>>,
    /// The magnetometer in µT, three columns, finite.
    pub field_ut: [Vec<f64>; 3],
    /// From the numbers of the file to the field in body axes, as the reader did it.
    pub frame: Frame,
    /// Scale, where the log holds counts.
    pub ut_per_count: Option<[f64; 3]>,
    /// The raw counts, where the log holds 16-bit integers and `--rotate` left them alone: from these the fit
    /// gives the same bits as the board.
    pub counts: Option<Vec<[i16; 3]>>,
    /// Specific force, m/s²; NaN where a cell is empty.
    pub accel_mps2: Option<[Vec<f64>; 3]>,
    /// Angular rate, rad/s; NaN where a cell is empty.
    pub gyro_radps: Option<[Vec<f64>; 3]>,
    /// Reference heading, degrees; NaN where a cell is empty. Never fitted.
    pub heading_deg: Option<Vec<f64>>,
    /// The field of the Earth at every row, where the log tells where it was: magnitude, µT, and dip, degrees.
    pub earth: Option<[Vec<f64>; 2]>,
    /// Declination there, degrees to the east.
    pub declination_deg: Option<f64>,
    /// The first row of each further log, where several were joined.
    pub recordings: Vec<usize>,
    /// Every other numeric column.
    pub covariates: Vec<Covariate>,
    /// How it was read.
    pub read_as: ReadAs,
    /// What the user should know about how the log was read.
    pub notices: Vec<String>,
}

impl Log {
    /// The field of one row, µT.
    pub fn field(&self, row: usize) -> [f64; 3] {
        [self.field_ut[0][row], self.field_ut[1][row], self.field_ut[2][row]]
    }

    /// The covariate of that name.
    pub fn covariate(&self, name: &str) -> Option<&Covariate> {
        self.covariates.iter().find(|covariate| covariate.name == name)
    }

    /// The rows that are samples: the first of every run of equal field triples, which a log faster than its
    /// sensor repeats.
    pub fn samples(&self) -> Vec<usize> {
        (0..self.rows).filter(|&row| row == 0 || self.field(row) != self.field(row - 1)).collect()
    }
}
