//! The calibration that a fit arrived at, whichever way it went.

use crate::base::axes::{Aligned, Alignment};
use crate::calibration::{FittedEffect, Information, StdErrors};
use crate::plain;
use ironout::calibration::Calibration;
use ironout::fit::{FitReport, Order};
use ironout::quality::Figures;
use serde::Serialize;

/// A calibration and what is known about it.
#[derive(Debug, Clone, Serialize)]
pub struct Solution {
    /// Offset, matrix (full where aligned) and field.
    #[serde(serialize_with = "plain::calibration")]
    pub calibration: Calibration<f64>,
    /// Their standard errors.
    pub std_errors: StdErrors,
    /// The effects in the model.
    pub effects: Vec<FittedEffect>,
    /// Rms of the corrected magnitude about the field, µT.
    pub rms_ut: f64,
    /// Predicted 1σ error of a corrected vector in the worst direction, µT, in the sensor's own axes.
    pub predicted_error_ut: f64,
    /// 1σ that the rotation to the accelerometer turns a corrected vector by, rad; zero where there is none.
    pub rotation_error_rad: f64,
    /// Rms of one axis by which the gyro says that the field is another one from place to place, µT; zero where it does not.
    pub field_varies_by_ut: f64,
    /// The magnitude the measurements have themselves, µT.
    pub measured_field_ut: f64,
    /// Which parameters the data carried.
    #[serde(serialize_with = "plain::model")]
    pub model: Order,
    /// What it knows about offset and triangle.
    pub information: Option<Information>,
    /// How it was aligned to the accelerometer, if the log has one.
    pub alignment: Alignment,
    /// The errors without the effects.
    pub without_effects: Option<WithoutEffects>,
    /// What was known besides the log, in words.
    pub prior: Option<String>,
}

/// Rms of the corrected magnitude with offset and matrix only.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WithoutEffects {
    /// On the log, µT.
    pub rms_ut: f64,
    /// On held-out blocks of it, µT.
    pub holdout_rms_ut: Option<f64>,
}

impl Solution {
    /// That of the core's fit.
    pub fn of_report(report: &FitReport) -> Self {
        Solution {
            calibration: report.calibration,
            std_errors: StdErrors {
                offset_ut: report.std_errors.offset_ut,
                matrix: report.std_errors.matrix,
            },
            effects: Vec::new(),
            rms_ut: report.rms_ut,
            predicted_error_ut: report.predicted_error_ut,
            rotation_error_rad: 0.0,
            field_varies_by_ut: 0.0,
            measured_field_ut: report.measured_field_ut,
            model: report.model,
            information: Information::from_covariance(&report.spread.covariance()),
            alignment: Alignment::None,
            without_effects: None,
            prior: None,
        }
    }

    /// Takes the axes that the dip allows.
    pub fn take(&mut self, aligned: Aligned) {
        self.calibration.matrix = aligned.matrix;
        self.std_errors.matrix = aligned.std_errors.matrix;
        self.alignment = aligned.alignment;
        self.rotation_error_rad = aligned.rotation_error_rad;
    }

    /// Predicted 1σ error of a corrected vector in the worst direction, µT, in the axes that it is given in.
    pub fn vector_error_ut(&self) -> f64 {
        // Of one axis along each of the two directions across the field.
        (self.predicted_error_ut.hypot(self.rotation_error_rad * self.calibration.field_ut))
            .hypot(self.field_varies_by_ut * std::f64::consts::SQRT_2)
    }

    /// What it is judged by.
    pub fn figures(&self, samples: u64) -> Figures {
        Figures {
            calibration: self.calibration,
            samples,
            predicted_error_ut: self.predicted_error_ut,
            rms_ut: self.rms_ut,
            measured_field_ut: self.measured_field_ut,
        }
    }
}
