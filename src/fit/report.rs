//! What a fit answers.

use super::options::{MAX_PREDICTED_ERROR, Method};
use super::precision::Spread;
use crate::calibration::Calibration;
use crate::quadric::Order;

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// One linear solve, nothing to iterate.
    Direct,
    /// The root of the adjusted least squares was found.
    Converged {
        /// Factorisations it took.
        steps: u8,
    },
    /// The data have no noise above rounding.
    NoiseFree,
    /// The step limit came first; the estimate is the best so far.
    StepLimit,
}

/// Standard errors of a calibration, one σ, from noise only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StdErrors {
    /// Of the offset, µT.
    pub offset_ut: [f64; 3],
    /// Of the matrix; zero below the diagonal.
    pub matrix: [[f64; 3]; 3],
}

/// A calibration and what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct FitReport {
    /// The calibration: upper triangular matrix, positive diagonal.
    pub calibration: Calibration<f64>,
    /// The errors of `(b, C)` and how they hang together: a square root of their covariance, µT and 1.
    pub spread: Spread,
    /// The standard errors.
    pub std_errors: StdErrors,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: f64,
    /// What that noise makes of the corrected magnitude, rms, µT: the floor of `rms_ut`.
    pub residual_floor_ut: f64,
    /// Rms residual of the corrected magnitude, µT.
    pub rms_ut: f64,
    /// Predicted 1σ error of the corrected vector in the worst direction of the sphere, µT. From noise alone; where noise
    /// also biases the method, see [`Self::add_noise_bias`].
    pub predicted_error_ut: f64,
    /// Longest over shortest semi-axis of the ellipsoid.
    pub axis_ratio: f64,
    /// The magnitude the measurements have themselves, rms distance from the offset, µT.
    pub measured_field_ut: f64,
    /// Samples used.
    pub samples: u64,
    /// Of those, how many count as independent: what the standard errors rest on.
    pub effective_samples: f64,
    /// The method.
    pub method: Method,
    /// Which parameters the data carried.
    pub model: Order,
    /// Condition number of the normal matrix, estimated from its Cholesky factor.
    pub condition_number: f64,
    /// Why it ended.
    pub termination: Termination,
}

impl FitReport {
    /// The predicted error above which lower orders are tried, µT.
    pub(super) fn limit_ut(&self) -> f64 {
        MAX_PREDICTED_ERROR * self.calibration.field_ut
    }
}
