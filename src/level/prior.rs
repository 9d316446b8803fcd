//! What a level fit knows before.

use crate::calibration::Calibration;
use crate::record::HoldsFor;

/// Angles between the axes of a sensor, and between an ellipsoid's and an accelerometer's, 1σ, rad.
const AXIS_ERROR_RAD: f64 = 0.052;

/// What the vertical axis is held by.
#[derive(Clone, Copy, Debug)]
pub struct LevelPrior {
    /// The calibration in use, or the identity.
    pub calibration: Calibration<f64>,
    /// Its error over the field; `None` for the identity.
    pub error: Option<f64>,
    /// The tilts that it holds for; `None` for all.
    pub holds_for: Option<HoldsFor>,
}

impl LevelPrior {
    /// How far its axes are from the accelerometer's, 1σ, rad. An ellipsoid shows no rotation: a matrix with a lower triangle of zeros has
    /// the axes that the solve chose.
    pub(super) fn axis_error_rad(&self) -> f64 {
        let [_, [yx, ..], [zx, zy, _]] = self.calibration.matrix;
        match self.error {
            Some(error) if [yx, zx, zy] != [0.0; 3] => error,
            _ => AXIS_ERROR_RAD,
        }
    }
}
