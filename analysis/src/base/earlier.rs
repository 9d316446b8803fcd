//! An earlier calibration as information about offset and triangle.

use crate::base::prior::Earlier;
use crate::base::start::NO_ROTATION;
use crate::bounds::OTHER_DAY;
use crate::samples::samples::Condition;
use ironout::study::Model;
use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What an earlier calibration says, with the offset as it is where the columns of its effects have their means in this log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EarlierCalibration {
    /// Hard iron, µT.
    pub offset_ut: [f64; 3],
    /// The upper triangular matrix.
    pub triangle: [[f64; 3]; 3],
    /// Inverse of the covariance of the offset (3) and of the triangle by rows (6).
    pub information: [[f64; 9]; 9],
    /// The field that it is scaled to, µT.
    pub field_ut: f64,
    /// How the columns were over the samples that it was fitted to: what acts by a column had its mean effect then, and that is in the
    /// offset and matrix. Columns that are not here have their mean in this log.
    #[serde(default)]
    pub conditions: BTreeMap<String, Condition>,
}

impl EarlierCalibration {
    /// For the study of a log that is scaled to `field_ut`; `None` keeps the calibration's own field.
    pub fn earlier(&self, field_ut: Option<f64>) -> Earlier {
        let scale = field_ut.map_or(1.0, |field| field / self.field_ut);
        let c = self.triangle;
        let [x, y, z] = self.offset_ut;
        let triangle = [c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]].map(|value| value * scale);
        let [a, b, d, e, f, g] = triangle;
        let unit = |i: usize| if i < 3 { 1.0 } else { 1.0 / scale };
        let information = self.loosened();
        Earlier {
            parameters: [x, y, z, a, b, d, e, f, g],
            information: std::array::from_fn(|i| {
                std::array::from_fn(|j| information[i][j] * unit(i) * unit(j))
            }),
        }
    }

    /// The earlier calibration as the model that a study on top of it begins with.
    pub fn model(&self, field_ut: Option<f64>) -> Option<Model<f64>> {
        let [x, y, z, a, b, d, e, f, g] = self.earlier(field_ut).parameters;
        let triangle = [[a, b, d], [0.0, e, f], [0.0, 0.0, g]];
        Model::new([x, y, z], triangle, field_ut.unwrap_or(self.field_ut), NO_ROTATION, 0.0)
    }

    /// The same with nothing known along these directions of offset (3) and triangle (6): Λ − Λv (vᵀΛv)⁻¹ vᵀΛ, one after the other.
    pub fn without(&self, directions: &[[f64; 9]]) -> EarlierCalibration {
        let mut left = self.clone();
        for v in directions {
            let pull: [f64; 9] = std::array::from_fn(|i| (0..9).map(|j| left.information[i][j] * v[j]).sum());
            let along: f64 = pull.iter().zip(v).map(|(a, b)| a * b).sum();
            if along > 0.0 {
                for (row, a) in left.information.iter_mut().zip(pull) {
                    row.iter_mut().zip(pull).for_each(|(value, b)| *value -= a * b / along);
                }
            }
        }
        left
    }

    /// The same with nothing known of the offset.
    pub fn without_offset(&self) -> EarlierCalibration {
        self.without(&[0, 1, 2].map(|axis| std::array::from_fn(|i| f64::from(u8::from(i == axis)))))
    }

    /// The information with what no noise tells: a board is not quite the same at another place and day.
    fn loosened(&self) -> [[f64; 9]; 9] {
        let spread = |i: usize| OTHER_DAY * if i < 3 { self.field_ut } else { 1.0 };
        // (Λ⁻¹ + D²)⁻¹ without inverting Λ, which may be singular: D⁻¹ (1 − (1 + DΛD)⁻¹) D⁻¹.
        let scaled = SMatrix::<f64, 9, 9>::from_fn(|i, j| self.information[i][j] * spread(i) * spread(j));
        let Some(factor) = (SMatrix::identity() + scaled).cholesky() else { return self.information };
        let rest = SMatrix::identity() - factor.inverse();
        std::array::from_fn(|i| {
            std::array::from_fn(|j| 0.5 * (rest[(i, j)] + rest[(j, i)]) / (spread(i) * spread(j)))
        })
    }
}
