//! What noise does to the methods that take the measured powers as they are.
//!
//! Squares of noisy data are too large on average. Over the full sphere that scales the ellipsoid a little; over a part of
//! it, it bends the ellipsoid, by many times the standard errors, and no residual shows it. The adjusted least squares of
//! the same sums has no such bias, so the distance to it tells.

use super::options::{FitOptions, Method};
use super::report::FitReport;
use super::root::Root;
use super::solve::check;
use crate::calibration::Calibration;
use crate::dense;
use crate::quadric::{Ellipsoid, Order};
use crate::scatter::Scatter;
use crate::vector::{minus, norm, upper_triangular};

impl FitReport {
    /// Adds to the predicted error what noise biases this method by: how far the corrected vector moves, in the worst
    /// direction, from that of the adjusted method on the same `scatter`. It costs about an adjusted solve; nothing changes
    /// where the method is [`Method::Adjusted`].
    pub fn add_noise_bias(&mut self, scatter: &Scatter) {
        if self.method == Method::Adjusted {
            return;
        }
        // Without an adjusted solution nothing vouches for this one.
        let bias = adjusted(scatter, self.model, self.calibration.field_ut)
            .and_then(|unbiased| worst_distance_ut(&self.calibration, &unbiased))
            .unwrap_or(self.calibration.field_ut);
        let square = self.predicted_error_ut * self.predicted_error_ut + bias * bias;
        self.predicted_error_ut = dense::root(square);
    }
}

/// The adjusted solution of a model, scaled to `field_ut`.
fn adjusted(scatter: &Scatter, model: Order, field_ut: f64) -> Option<Calibration> {
    let upper = check(scatter, &FitOptions::default()).ok()?;
    let mut root = Root::new();
    if !root.adjusted(scatter, upper, model) {
        return None;
    }
    let ellipsoid = Ellipsoid::from_coefficients(&root.beta)?;
    let matrix = upper_triangular(ellipsoid.factor.map(|entry| entry * field_ut / scatter.scale_ut), 0.0);
    let offset_ut = core::array::from_fn(|a| scatter.centre_ut[a] + ellipsoid.centre[a] * scatter.scale_ut);
    Some(Calibration { offset_ut, matrix, field_ut })
}

/// The largest distance between what two calibrations make of a measurement, over 26 directions of the field.
fn worst_distance_ut(a: &Calibration, b: &Calibration) -> Option<f64> {
    let mut worst = 0.0;
    for code in 0..27u8 {
        let v = [code % 3, code / 3 % 3, code / 9].map(|digit| f64::from(digit) - 1.0);
        let length = norm(v);
        if length == 0.0 {
            continue;
        }
        let field = v.map(|v| v * a.field_ut / length);
        let corrected = b.apply(a.distort(field)?);
        let distance = norm(minus(corrected, field));
        if !distance.is_finite() {
            return None;
        }
        worst = f64::max(worst, distance);
    }
    Some(worst)
}
