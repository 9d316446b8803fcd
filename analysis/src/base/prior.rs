//! An earlier calibration as information about offset and triangle.

use crate::base::known::Earlier;
use serde::{Deserialize, Serialize};

/// What an earlier calibration says, with the offset as it is where this log's columns have their means.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// Hard iron, µT.
    pub offset_ut: [f64; 3],
    /// The upper triangular matrix.
    pub triangle: [[f64; 3]; 3],
    /// Inverse of the covariance of the offset (3) and of the triangle by rows (6).
    pub information: [[f64; 9]; 9],
    /// The field that it is scaled to, µT.
    pub field_ut: f64,
}

impl Prior {
    /// For the study of a log that is scaled to `field_ut`; `None` keeps the calibration's own field.
    pub fn earlier(&self, field_ut: Option<f64>) -> Earlier {
        let scale = field_ut.map_or(1.0, |field| field / self.field_ut);
        let c = self.triangle;
        let [x, y, z] = self.offset_ut;
        let triangle = [c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]].map(|value| value * scale);
        let [a, b, d, e, f, g] = triangle;
        let unit = |i: usize| if i < 3 { 1.0 } else { 1.0 / scale };
        Earlier {
            parameters: [x, y, z, a, b, d, e, f, g],
            information: std::array::from_fn(|i| {
                std::array::from_fn(|j| self.information[i][j] * unit(i) * unit(j))
            }),
        }
    }
}
