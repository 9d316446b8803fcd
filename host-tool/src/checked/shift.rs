//! A moved offset, or another field, in what a calibration leaves.

use ironout::calibration::{Calibration, norm};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// An offset has moved where the shift is this many standard errors, …
const MOVED_SIGMA: f64 = 4.0;
/// … and at least this share of the field.
const MOVED: f64 = 0.02;
/// A shift of the offset is stated where its standard error is below this share of the field.
const KNOWN: f64 = 0.02;
/// Neighbouring residuals are not independent: so many samples count as one.
const SAMPLES_PER_INDEPENDENT: f64 = 10.0;
/// Gauss–Newton from the algebraic sphere settles in fewer steps.
const MAX_STEPS: usize = 20;

/// A change of the offset, and of the field's magnitude, that explains a residual.
pub struct Shift {
    pub(crate) offset_ut: [f64; 3],
    pub(crate) offset_std_ut: [f64; 3],
    pub(crate) field_ut: f64,
    /// The same change of the offset in the corrected vectors, µT.
    pub(crate) centre_ut: [f64; 3],
    /// Rms of what it leaves.
    pub(crate) rms_ut: f64,
    pub(crate) known: bool,
}

impl Shift {
    /// Whether the offset moved, beyond doubt and by enough to matter.
    pub(crate) fn moved(&self, field_ut: f64) -> bool {
        self.known
            && norm(self.offset_ut) >= MOVED * field_ut
            && self
                .offset_ut
                .iter()
                .zip(self.offset_std_ut)
                .any(|(shift, std)| shift.abs() > MOVED_SIGMA * std)
    }
}

/// The sphere that corrected vectors lie on: with the calibration's matrix, a change of the offset by `δb` moves its centre to `C δb`, however large
/// it is, and another field changes its radius. `residual` is what the calibration leaves of each vector. `None` where the vectors
/// determine no sphere.
pub(crate) fn shift(
    corrected: &[[f64; 3]],
    residual: &[f64],
    calibration: &Calibration<f64>,
) -> Option<Shift> {
    let field_ut = calibration.field_ut;
    // With the share of the field at each place: on a journey it changes.
    let points: Vec<(Vector3<f64>, f64)> = (corrected.iter().zip(residual))
        .map(|(h, r)| (Vector3::from(*h), (norm(*h) - r) / field_ut))
        .filter(|(h, share)| h.norm() > 0.0 && *share > 0.0)
        .collect();
    // Algebraic: ‖h‖² = 2 c·h + (F² − ‖c‖²).
    let (mut normal, mut right) = (SMatrix::<f64, 4, 4>::zeros(), SVector::<f64, 4>::zeros());
    for (h, _) in &points {
        let row = SVector::<f64, 4>::new(2.0 * h.x, 2.0 * h.y, 2.0 * h.z, field_ut);
        normal += row * row.transpose();
        right += row * h.norm_squared();
    }
    let start = normal.cholesky()?.solve(&right);
    let mut centre = Vector3::new(start[0], start[1], start[2]);
    let mut radius = (start[3] * field_ut + centre.norm_squared()).max(0.0).sqrt();
    let mut squares = f64::INFINITY;
    let mut inverse = SMatrix::<f64, 4, 4>::zeros();
    for _ in 0..MAX_STEPS {
        let (mut normal, mut right) = (SMatrix::<f64, 4, 4>::zeros(), SVector::<f64, 4>::zeros());
        let mut sum = 0.0;
        for (h, share) in &points {
            let beside = h - centre;
            let length = beside.norm().max(f64::MIN_POSITIVE);
            let (u, r) = (beside / length, length - share * radius);
            let row = SVector::<f64, 4>::new(u.x, u.y, u.z, *share);
            normal += row * row.transpose();
            right += row * r;
            sum += r * r;
        }
        let factor = normal.cholesky()?;
        inverse = factor.inverse();
        if sum >= squares * (1.0 - 1e-9) {
            break;
        }
        squares = sum;
        let step = factor.solve(&right);
        centre += Vector3::new(step[0], step[1], step[2]);
        radius += step[3];
    }
    let rms_ut = (squares / points.len().max(1) as f64).sqrt();
    let back = Matrix3::from_fn(|i, j| calibration.matrix[i][j]).try_inverse()?;
    let own: Matrix3<f64> = inverse.fixed_view::<3, 3>(0, 0).into();
    let offset_covariance = back * own * back.transpose();
    let offset_std_ut =
        [0, 1, 2].map(|i| rms_ut * (SAMPLES_PER_INDEPENDENT * offset_covariance[(i, i)]).sqrt());
    let offset_ut: [f64; 3] = (back * centre).into();
    let finite = offset_ut.iter().chain(&offset_std_ut).chain([&rms_ut]).all(|value| value.is_finite());
    finite.then(|| Shift {
        offset_ut,
        offset_std_ut,
        field_ut: radius - field_ut,
        centre_ut: centre.into(),
        rms_ut,
        known: offset_std_ut.iter().all(|std| *std <= KNOWN * field_ut),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_any_size_is_found() {
        let matrix = [[1.1, 0.05, -0.02], [0.0, 0.95, 0.03], [0.0, 0.0, 1.02]];
        let calibration = Calibration { offset_ut: [0.0; 3], matrix, field_ut: 50.0 };
        let back = Matrix3::from_fn(|i, j| matrix[i][j]).try_inverse().expect("regular");
        for (size, field_ut) in [(0.0, 50.0), (3.0, 50.0), (60.0, 50.0), (400.0, 24.0), (20.0, 100.0)] {
            let moved = Vector3::new(0.6, -0.5, 0.62).normalize() * size;
            let corrected: Vec<[f64; 3]> = (0..300)
                .map(|i| {
                    let z = 1.0 - (2 * i + 1) as f64 / 300.0;
                    let (sine, cosine) = (i as f64 * 2.399_963).sin_cos();
                    let across = (1.0 - z * z).sqrt();
                    let measured =
                        back * (Vector3::new(across * cosine, across * sine, z) * field_ut) + moved;
                    calibration.apply(measured.into())
                })
                .collect();
            let residual: Vec<f64> = corrected.iter().map(|h| norm(*h) - 50.0).collect();
            let found = shift(&corrected, &residual, &calibration).expect("a sphere");
            let off = (Vector3::from(found.offset_ut) - moved).norm();
            assert!(off < 1e-6 && (found.field_ut - (field_ut - 50.0)).abs() < 1e-6, "{size}: {off}");
            assert_eq!(found.moved(50.0), size > 0.0);
        }
    }
}
