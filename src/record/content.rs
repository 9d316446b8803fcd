//! A calibration with where it comes from.

use super::covariance::Covariance;
use super::holds_for::HoldsFor;
use super::predicted::PredictedError;
use crate::calibration::Calibration;
#[cfg(feature = "effects")]
use crate::extended::{Effects, ExtendedCalibration};
use crate::fit::{FitReport, Method, Order};
use crate::sensor::AxisMap;

/// A calibration with where it comes from, as it is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Record {
    /// Number of the record; each one written is one above the newest found (wrapping).
    pub sequence: u32,
    /// The calibration: offset, matrix, field.
    pub calibration: Calibration<f64>,
    /// The effects that belong to it.
    #[cfg(feature = "effects")]
    pub effects: Effects<f64>,
    /// The method of the fit.
    pub method: Method,
    /// The model the data carried.
    pub model: Order,
    /// Number of samples behind the fit.
    pub samples: u64,
    /// Estimated sensor noise, µT per axis.
    pub noise_ut: f64,
    /// Residual rms of the corrected magnitude, µT.
    pub rms_ut: f64,
    /// How the sensor was mounted; `None` where the record does not say. Offset and matrix are in the board's axes, and right
    /// only with this mounting.
    pub axes: Option<AxisMap>,
    /// The predicted error of the corrected vector in the worst direction, from noise alone.
    pub predicted_error: PredictedError,
    /// How the errors of offset and matrix hang together, where that is known. A record whose effects leave no room for it is stored
    /// without.
    pub covariance: Option<Covariance>,
    /// The tilts that it holds for; `None`: all.
    pub holds_for: Option<HoldsFor>,
}

impl Record {
    /// The record of a fit, without effects; its sequence number is given when it is stored.
    pub fn of(report: &FitReport) -> Self {
        Self {
            sequence: 0,
            calibration: report.calibration,
            #[cfg(feature = "effects")]
            effects: Effects::none(),
            method: report.method,
            model: report.model,
            samples: report.samples,
            noise_ut: report.noise_ut,
            rms_ut: report.rms_ut,
            axes: None,
            predicted_error: PredictedError::of_share(
                report.predicted_error_ut / report.calibration.field_ut,
            ),
            covariance: Covariance::of_spread(&report.spread),
            holds_for: None,
        }
    }

    /// Offset, matrix, field and effects.
    #[cfg(feature = "effects")]
    pub fn extended(&self) -> ExtendedCalibration<f64> {
        ExtendedCalibration { base: self.calibration, effects: self.effects }
    }

    /// Whether offset and matrix, and the effects, are numbers that correct.
    #[cfg(feature = "record")]
    pub(super) fn is_sound(&self) -> bool {
        #[cfg(feature = "effects")]
        return self.extended().is_sound();
        #[cfg(not(feature = "effects"))]
        self.calibration.is_sound()
    }

    /// How many effects belong to it.
    #[cfg(feature = "record")]
    pub(super) fn count_effects(&self) -> u8 {
        #[cfg(feature = "effects")]
        return self.effects.len() as u8;
        #[cfg(not(feature = "effects"))]
        0
    }
}
