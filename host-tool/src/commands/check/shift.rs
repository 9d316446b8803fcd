//! A moved offset, or another field, in what a calibration leaves.

use ironout::calibration::{Calibration, norm};
use nalgebra::{SMatrix, SVector};

/// An offset has moved where the shift is this many standard errors, …
const MOVED_SIGMA: f64 = 4.0;
/// … and at least this share of the field.
const MOVED: f64 = 0.02;
/// The linear estimate of a shift means something up to this share of the field.
const LINEAR: f64 = 0.3;
/// A shift of the offset is stated where its standard error is below this share of the field.
const KNOWN: f64 = 0.02;

/// A change of the offset, and of the field's magnitude, that explains a residual.
pub(super) struct Shift {
    pub(super) offset_ut: [f64; 3],
    pub(super) offset_std_ut: [f64; 3],
    pub(super) field_ut: f64,
    /// Rms of what it leaves.
    pub(super) rms_ut: f64,
    pub(super) known: bool,
}

impl Shift {
    /// Whether the offset moved, beyond doubt and by enough to matter.
    pub(super) fn moved(&self, field_ut: f64) -> bool {
        self.known
            && norm(self.offset_ut) >= MOVED * field_ut
            && self
                .offset_ut
                .iter()
                .zip(self.offset_std_ut)
                .any(|(shift, std)| shift.abs() > MOVED_SIGMA * std)
    }
}

/// Least squares of the residual on a shift of the offset and of the field: `r = (Cᵀu)·δb + δF`: what is
/// added to every measurement shows along the corrected direction.
pub(super) fn shift(
    corrected: &[[f64; 3]],
    residual: &[f64],
    calibration: &Calibration<f64>,
) -> Option<Shift> {
    let mut normal = SMatrix::<f64, 4, 4>::zeros();
    let mut right = SVector::<f64, 4>::zeros();
    for (h, &r) in corrected.iter().zip(residual) {
        let length = norm(*h);
        if length <= 0.0 {
            continue;
        }
        let c = &calibration.matrix;
        let slope = [0, 1, 2].map(|axis| (0..3).map(|row| c[row][axis] * h[row]).sum::<f64>() / length);
        let row = SVector::<f64, 4>::new(slope[0], slope[1], slope[2], 1.0);
        normal += row * row.transpose();
        right += row * r;
    }
    let factor = normal.cholesky()?;
    let solution = factor.solve(&right);
    let n = corrected.len() as f64;
    let squares: f64 = residual.iter().map(|r| r * r).sum();
    let rms_ut = ((squares - solution.dot(&right)).max(0.0) / n).sqrt();
    let inverse = factor.inverse();
    // Neighbouring residuals are not independent: count a tenth of the samples.
    let std = |i: usize| rms_ut * (10.0 * inverse[(i, i)]).sqrt();
    let offset_std_ut = [std(0), std(1), std(2)];
    Some(Shift {
        offset_ut: [solution[0], solution[1], solution[2]],
        offset_std_ut,
        field_ut: solution[3],
        rms_ut,
        known: offset_std_ut.iter().all(|s| *s <= KNOWN * calibration.field_ut)
            && norm([solution[0], solution[1], solution[2]]).max(solution[3].abs())
                <= LINEAR * calibration.field_ut,
    })
}
