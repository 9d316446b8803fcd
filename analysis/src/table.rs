//! The log as the diagnosis sees it: borrowed columns.

use crate::calibration::Accelerometer;
use crate::track::{Place, Track};
use nalgebra::Matrix3;
use std::sync::OnceLock;

/// Borrowed columns of equal length. A missing cell is NaN.
#[derive(Debug, Clone, Default)]
pub struct Table<'a> {
    /// Time, s, not decreasing.
    pub time_s: Option<&'a [f64]>,
    /// The magnetometer, µT.
    pub field_ut: [&'a [f64]; 3],
    /// Another magnetometer in the same rows, in axes of its own, µT.
    pub other_ut: Option<[&'a [f64]; 3]>,
    /// The same as the sensor's 16-bit counts, and their scale, µT a count: from these a fit gives the board's bits.
    pub counts: Option<(&'a [[i16; 3]], [f64; 3])>,
    /// Specific force, m/s².
    pub accel_mps2: Option<[&'a [f64]; 3]>,
    /// Rate of turn, rad/s.
    pub gyro_radps: Option<[&'a [f64]; 3]>,
    /// Reference heading, degrees.
    pub heading_deg: Option<&'a [f64]>,
    /// The attitude that an autopilot worked out, as a quaternion from body axes (forward, right, down) to north, east, down: w, x, y, z.
    pub attitude: Option<[&'a [f64]; 4]>,
    /// The field of the Earth where the log was recorded, where that is known.
    pub earth: Option<Earth>,
    /// The field along the way, where the log tells where it was and that changes it.
    pub track: Option<Track>,
    /// The first row of each further recording, where several follow each other.
    pub recordings: Vec<usize>,
    /// Every other numeric column.
    pub covariates: Vec<Named<'a>>,
    /// Whether the axes of two sensors disagree, and nothing tells whose are wrong.
    pub axes_in_doubt: bool,
    /// What has been worked out of these columns; begins empty.
    pub derived: Derived,
}

/// Names of the columns of a logged attitude.
pub const ATTITUDE: [&str; 4] = ["q_w", "q_x", "q_y", "q_z"];
/// Names of the columns of another magnetometer.
pub const OTHER: [&str; 3] = ["mx_other_ut", "my_other_ut", "mz_other_ut"];

/// The field of the Earth at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Earth {
    /// Magnitude, µT.
    pub field_ut: f64,
    /// Dip below the horizon, degrees.
    pub dip_deg: f64,
    /// Declination to the east, degrees.
    pub declination_deg: f64,
}

/// Specific force without the board's own acceleration, in body axes, against gravity and with its usual length.
#[derive(Debug, Clone)]
pub struct QuietForce {
    /// m/s²; NaN where nothing is known.
    pub mps2: [Vec<f64>; 3],
    /// How it follows errors of the sensors, at every so many rows.
    pub(crate) follows: Vec<Follows>,
    pub(crate) every: usize,
    /// Covariance of what is left of the gyro's zero error, (rad/s)².
    pub gyro_zero_covariance: Matrix3<f64>,
}

/// How the quiet force of a row follows constant errors of the sensors.
#[derive(Debug, Clone, Copy)]
pub struct Follows {
    /// An error of the accelerometer's zero turns with the board and partly averages out: m/s² per m/s², the length apart.
    pub accel: Matrix3<f64>,
    /// An error of the gyro's zero turns the rows before and after against each other: rotation vector in body axes, rad per rad/s.
    pub gyro_s: Matrix3<f64>,
}

impl QuietForce {
    /// At a row.
    pub fn follows(&self, row: usize) -> Option<Follows> {
        self.follows.get(row / self.every).copied()
    }
}

/// Columns that are worked out of a table's own when they are first asked for.
#[derive(Debug, Clone, Default)]
pub struct Derived {
    /// Specific force without the board's own acceleration, m/s² ([`crate::samples::gravity`]).
    pub(crate) quiet_force: OnceLock<Option<QuietForce>>,
    /// What its own calibration makes of the accelerometer, m/s².
    pub(crate) corrected_force_mps2: OnceLock<Option<[Vec<f64>; 3]>>,
    /// That calibration, where it has something to correct.
    pub(crate) accelerometer: OnceLock<Option<Accelerometer>>,
    /// Second moment of the zero error that is left, (m/s²)².
    pub(crate) zero_error_square: OnceLock<Matrix3<f64>>,
}

/// A column that the log format asks for and that is not there, or one whose length is not that of the others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BadTable {
    /// Of `mx_ut`, `my_ut`, `mz_ut` this one is missing.
    Missing(&'static str),
    /// Of `ax_mps2` … or `gx_radps` … this one is missing next to the others.
    Incomplete(&'static str),
    /// This column has another number of rows than `mx_ut`.
    Ragged(String),
}

impl std::fmt::Display for BadTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            BadTable::Missing(name) => write!(f, "there is no column {name}"),
            BadTable::Incomplete(name) => write!(f, "{name} is missing: all three axes are needed"),
            BadTable::Ragged(name) => write!(f, "column {name} has another number of rows than mx_ut"),
        }
    }
}

impl std::error::Error for BadTable {}

/// A covariate.
#[derive(Debug, Clone)]
pub struct Named<'a> {
    /// Its header.
    pub name: &'a str,
    /// Its values.
    pub values: &'a [f64],
    /// Cells that hold NaN or an infinity written out.
    pub not_finite: usize,
}

/// Whether all three columns of a sensor are always zero: the logger has the columns, but no such sensor.
pub fn is_silent<A: AsRef<[f64]>>(axes: &[A; 3]) -> bool {
    axes.iter().all(|axis| axis.as_ref().iter().all(|value| *value == 0.0 || value.is_nan()))
}

impl<'a> Table<'a> {
    /// From columns named as in the log format: `mx_ut,my_ut,mz_ut` are needed, `t_s`, `ax_mps2 …`, `gx_radps …`,
    /// `mx_other_ut …`, `q_w …` and `heading_deg` are known, every other is a covariate. A missing cell is NaN.
    ///
    /// # Errors
    /// [`BadTable`].
    pub fn from_columns(columns: impl IntoIterator<Item = (&'a str, &'a [f64])>) -> Result<Self, BadTable> {
        const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
        const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
        const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];
        let columns: Vec<(&str, &[f64])> = columns.into_iter().collect();
        let find = |name: &str| columns.iter().find(|(own, _)| *own == name).map(|(_, values)| *values);
        let triple = |names: [&'static str; 3]| -> Result<Option<[&'a [f64]; 3]>, BadTable> {
            let found = names.map(find);
            match found {
                [Some(x), Some(y), Some(z)] => Ok(Some([x, y, z])),
                [None, None, None] => Ok(None),
                _ => {
                    let missing = names.into_iter().zip(found).find(|(_, values)| values.is_none());
                    Err(BadTable::Incomplete(missing.map_or(names[0], |(name, _)| name)))
                }
            }
        };
        let field_ut = triple(FIELD).map_err(|error| match error {
            BadTable::Incomplete(name) => BadTable::Missing(name),
            other => other,
        })?;
        let field_ut = field_ut.ok_or(BadTable::Missing(FIELD[0]))?;
        if let Some((name, _)) = columns.iter().find(|(_, values)| values.len() != field_ut[0].len()) {
            return Err(BadTable::Ragged((*name).to_string()));
        }
        let attitude = match ATTITUDE.map(find) {
            [Some(w), Some(x), Some(y), Some(z)] => Some([w, x, y, z]),
            _ => None,
        };
        let other_ut = triple(OTHER)?;
        let known = |name: &str| {
            FIELD.contains(&name)
                || OTHER.contains(&name)
                || (attitude.is_some() && ATTITUDE.contains(&name))
                || ACCEL.contains(&name)
                || GYRO.contains(&name)
                || ["t_s", "heading_deg"].contains(&name)
        };
        Ok(Table {
            time_s: find("t_s"),
            field_ut,
            other_ut,
            counts: None,
            accel_mps2: triple(ACCEL)?.filter(|axes| !is_silent(axes)),
            gyro_radps: triple(GYRO)?.filter(|axes| !is_silent(axes)),
            heading_deg: find("heading_deg"),
            attitude,
            earth: None,
            track: None,
            recordings: Vec::new(),
            axes_in_doubt: false,
            covariates: columns
                .iter()
                .filter(|(name, _)| !known(name))
                .map(|&(name, values)| Named { name, values, not_finite: 0 })
                .collect(),
            derived: Derived::default(),
        })
    }

    /// Tells this log from others: FNV-1a of the number of rows and of the first and last readings, 16 hexadecimal digits.
    pub fn fingerprint(&self) -> String {
        const READINGS: usize = 64;
        let rows = self.rows();
        let ends = (0..rows.min(READINGS)).chain(rows.saturating_sub(READINGS)..rows);
        let words = ends.flat_map(|row| self.field(row)).map(f64::to_bits).chain([rows as u64]);
        let bytes = words.flat_map(u64::to_le_bytes);
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        format!("{hash:016x}")
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.field_ut[0].len()
    }

    /// The measured vector of a row.
    pub fn field(&self, row: usize) -> [f64; 3] {
        self.field_ut.map(|axis| axis[row])
    }

    /// The place of a row on the track.
    pub fn place(&self, row: usize) -> Place {
        self.track.as_ref().map_or(Place::MEAN, |track| track.place(row))
    }

    /// The covariate of that name.
    pub fn covariate(&self, name: &str) -> Option<&Named<'a>> {
        self.covariates.iter().find(|covariate| covariate.name == name)
    }
}
