//! What is known of a calibration besides its numbers: errors, information, and the effects in it, as plain data.

use crate::plain;
use ironout::effect::Bends;
use nalgebra::{DMatrix, SMatrix};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Standard errors (1σ) of the parameters, from noise only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StdErrors {
    /// Of the offset, µT.
    pub offset_ut: [f64; 3],
    /// Of the matrix.
    pub matrix: [[f64; 3]; 3],
}

/// One effect in the model beyond offset and matrix.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectEntry {
    /// As `diagnose` names it: `offset:temp_c`.
    pub id: String,
    /// In words.
    pub name: String,
    /// Columns of the log it needs.
    pub columns: Vec<String>,
    /// Coefficients, in `unit`.
    pub coefficients: Vec<f64>,
    /// Their standard errors; null for a coefficient that the log did not show.
    pub std_errors: Vec<Option<f64>>,
    /// Unit of the coefficients.
    pub unit: String,
    /// The value of each column at which the effect is zero (for its square: whose square is).
    pub reference: BTreeMap<String, f64>,
    /// `at_s`, `frequency_hz`, `delay_s`, `time_constant_s` where the effect has one.
    pub parameters: BTreeMap<String, f64>,
    /// The least and the greatest value of each column that the effect was fitted over; absent in files of earlier
    /// programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<BTreeMap<String, [f64; 2]>>,
    /// What it bends, where it reads the field: `field`; absent where it is the reading.
    #[serde(default, with = "plain::bends", skip_serializing_if = "plain::is_reading")]
    pub bends: Bends,
}

/// The error of a heading at one tilt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtTilt {
    /// From the mean attitude of the log, degrees.
    pub tilt_deg: f64,
    /// 1σ, rms over all headings and ways to be tilted, degrees.
    pub heading_error_deg: f64,
}

/// The attitudes that a calibration is for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HoldsFor {
    /// Tilts up to this from the mean attitude of the log, degrees.
    pub tilt_deg: f64,
    /// The mean direction down in the log, body axes.
    pub down: [f64; 3],
    /// The error of a heading while level and tilted.
    pub heading_errors: Vec<AtTilt>,
}

impl HoldsFor {
    /// The limit in words.
    pub fn limit(&self) -> String {
        format!("fitted for tilts up to {:.0}°: the heading error is {} (1σ)", self.tilt_deg, self.words())
    }

    /// What to know before it is used elsewhere.
    pub fn notice(&self) -> String {
        format!("{}. The target of an export does not know this limit", self.limit())
    }

    /// The errors in words: `0.2° while level, 0.4° tilted by 10°`.
    pub fn words(&self) -> String {
        let of = |at: &AtTilt| {
            let error = at.heading_error_deg;
            let figure = if error < 9.95 { format!("{error:.1}°") } else { format!("{error:.0}°") };
            match at.tilt_deg {
                0.0 => format!("{figure} while level"),
                tilt => format!("{figure} tilted by {tilt:.0}°"),
            }
        };
        self.heading_errors.iter().map(of).collect::<Vec<_>>().join(", ")
    }
}

/// The normal matrix behind a calibration: the inverse of the parameters' covariance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Information {
    /// What each row and column stands for.
    pub parameters: Vec<String>,
    /// Symmetric, positive definite; units are the inverse squares of the parameters'.
    pub matrix: Vec<Vec<f64>>,
}

/// Names of the nine parameters, in the order of [`Information`].
pub const PARAMETERS: [&str; 9] = [
    "offset_ut[0]",
    "offset_ut[1]",
    "offset_ut[2]",
    "matrix[0][0]",
    "matrix[0][1]",
    "matrix[0][2]",
    "matrix[1][1]",
    "matrix[1][2]",
    "matrix[2][2]",
];

impl Information {
    /// Of a normal matrix over [`PARAMETERS`]; `None` if it is not finite and positive definite.
    pub fn of(matrix: &[[f64; 9]; 9]) -> Option<Self> {
        let symmetric = |i: usize, j: usize| (matrix[i][j] + matrix[j][i]) / 2.0;
        let matrix = (0..9).map(|i| (0..9).map(|j| symmetric(i, j)).collect()).collect();
        let information = Information { parameters: PARAMETERS.map(String::from).to_vec(), matrix };
        information.check().is_ok().then_some(information)
    }

    /// The inverse of a covariance; `None` if it has none that is finite and positive definite.
    pub fn from_covariance(covariance: &[[f64; 9]; 9]) -> Option<Self> {
        let matrix = SMatrix::<f64, 9, 9>::from_fn(|i, j| (covariance[i][j] + covariance[j][i]) / 2.0);
        // Offsets are in µT and matrix entries near 1: equal diagonals before inverting keep the digits.
        let scale = SMatrix::<f64, 9, 1>::from_fn(|i, _| 1.0 / matrix[(i, i)].sqrt());
        let unit = SMatrix::<f64, 9, 9>::from_fn(|i, j| matrix[(i, j)] * scale[i] * scale[j]);
        let inverse = unit.cholesky()?.inverse();
        let matrix: Vec<Vec<f64>> = (0..9)
            .map(|i| {
                (0..9).map(|j| (inverse[(i, j)] + inverse[(j, i)]) / 2.0 * scale[i] * scale[j]).collect()
            })
            .collect();
        matrix
            .iter()
            .flatten()
            .all(|value| value.is_finite())
            .then(|| Information { parameters: PARAMETERS.map(String::from).to_vec(), matrix })
    }

    /// The covariance of the nine parameters, whatever other parameters it has; `None` if it has none that is finite.
    pub fn covariance(&self) -> Option<[[f64; 9]; 9]> {
        self.check().ok()?;
        let n = self.parameters.len();
        let places: Vec<usize> = PARAMETERS
            .iter()
            .map(|name| self.parameters.iter().position(|own| own == name))
            .collect::<Option<_>>()?;
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / self.matrix[i][i].sqrt()).collect();
        let unit = DMatrix::from_fn(n, n, |i, j| {
            (self.matrix[i][j] + self.matrix[j][i]) / 2.0 * scale[i] * scale[j]
        });
        let inverse = unit.cholesky()?.inverse();
        let covariance = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let (row, column) = (places[i], places[j]);
                inverse[(row, column)] * scale[row] * scale[column]
            })
        });
        covariance.iter().flatten().all(|value: &f64| value.is_finite()).then_some(covariance)
    }

    /// Whether it has the shape of an information matrix, and is one.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&self) -> Result<(), &'static str> {
        let n = self.parameters.len();
        if !(9..=64).contains(&n) || self.matrix.len() != n || self.matrix.iter().any(|row| row.len() != n) {
            return Err("the information matrix has the wrong shape");
        }
        let scale: Vec<f64> = (0..n).map(|i| self.matrix[i][i].sqrt()).collect();
        if scale.iter().any(|value| !value.is_finite() || *value <= 0.0) {
            return Err("the information matrix is not positive definite");
        }
        let unit: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| self.matrix[i][j] / (scale[i] * scale[j])).collect()).collect();
        if (0..n).any(|i| (0..i).any(|j| (unit[i][j] - unit[j][i]).abs() > 1e-6)) {
            return Err("the information matrix is not symmetric");
        }
        if !positive_definite(unit) {
            return Err("the information matrix is not positive definite");
        }
        Ok(())
    }
}

/// Cholesky's pivots, of any size: a file may carry effects.
fn positive_definite(mut a: Vec<Vec<f64>>) -> bool {
    for k in 0..a.len() {
        let (done, rest) = a.split_at_mut(k + 1);
        let row = &done[k];
        let pivot = row[k];
        if pivot.is_nan() || pivot <= 1e-15 {
            return false;
        }
        for below in rest {
            let factor = below[k] / pivot;
            below.iter_mut().zip(row).for_each(|(value, above)| *value -= factor * above);
        }
    }
    true
}

/// Standard gravity (CGPM 1901), m/s².
pub const STANDARD_GRAVITY_MPS2: f64 = 9.80665;

/// How an accelerometer is corrected: `matrix · (measured − offset)`, of the length of standard gravity at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Accelerometer {
    /// What it reads without gravity, m/s².
    pub offset_mps2: [f64; 3],
    /// Gains and axes, symmetric: it turns nothing.
    pub matrix: [[f64; 3]; 3],
    /// Rms of the length about its mean before, m/s².
    pub before_mps2: f64,
    /// The same after, each tenth of the log under the fit of the others, m/s².
    pub after_mps2: f64,
}

impl Accelerometer {
    /// The corrected specific force, m/s².
    pub fn apply(&self, measured_mps2: [f64; 3]) -> [f64; 3] {
        let centred: [f64; 3] = std::array::from_fn(|axis| measured_mps2[axis] - self.offset_mps2[axis]);
        self.matrix.map(|row| (0..3).map(|axis| row[axis] * centred[axis]).sum())
    }
}

/// An effect with fitted coefficients.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedEffect {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: String,
    /// The physical cause.
    pub explanation: String,
    /// The columns it reads.
    pub columns: Vec<String>,
    /// Coefficients in `unit`.
    pub coefficients: Vec<f64>,
    /// Their standard errors.
    pub std_errors: Vec<f64>,
    /// Their unit.
    pub unit: String,
    /// Where it vanishes: column and value.
    pub reference: Vec<(String, f64)>,
    /// `at_s`, `frequency_hz`, `delay_s`, `time_constant_s`.
    pub parameters: Vec<(&'static str, f64)>,
    /// The least and the greatest value of each column over the samples of the fit.
    pub range: Vec<(String, [f64; 2])>,
    /// What it bends, where it reads the field.
    #[serde(with = "plain::bends", skip_serializing_if = "plain::is_reading")]
    pub bends: Bends,
}

impl From<&FittedEffect> for EffectEntry {
    fn from(fitted: &FittedEffect) -> Self {
        EffectEntry {
            id: fitted.id.clone(),
            name: fitted.name.clone(),
            columns: fitted.columns.clone(),
            coefficients: fitted.coefficients.clone(),
            std_errors: fitted
                .std_errors
                .iter()
                .map(|error| Some(*error).filter(|e| e.is_finite()))
                .collect(),
            unit: fitted.unit.clone(),
            reference: fitted.reference.iter().cloned().collect(),
            parameters: fitted.parameters.iter().map(|(name, value)| (name.to_string(), *value)).collect(),
            range: Some(fitted.range.iter().cloned().collect()),
            bends: fitted.bends,
        }
    }
}
