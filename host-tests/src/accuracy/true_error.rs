//! How far a calibration is from the truth of a simulated log.

use ironout_analysis::base::axes::Alignment;
use ironout_analysis::effects::calibrated;
use ironout_analysis::{Corrector, Diagnosis, Table};
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

/// An error of this many medians is that of a bad reading: six standard deviations of a vector of white noise.
const OUTLIER_OF_MEDIAN: f64 = 4.0;
/// Rounds in which bad readings are left out.
const ROUNDS_WITHOUT_OUTLIERS: usize = 4;
/// Directions of the sphere in which an error is looked at.
const DIRECTIONS: usize = 200;
/// True error of the calibration in the worst direction of the sphere, µT: the part of the corrected vectors' errors that is an
/// offset and a matrix, which noise hardly enters. In the scale of the truth: a log alone cannot tell the size of the field, nor,
/// without an accelerometer, how the axes are turned, so that scale and (there) the best rotation are taken out.
pub fn true_error_ut(table: &Table<'_>, diagnosis: &Diagnosis, truth: &[[f64; 3]]) -> Option<f64> {
    let entries: Vec<_> = diagnosis.effects.iter().map(Into::into).collect();
    let calibrated = calibrated(diagnosis.calibration?, &entries, diagnosis.registry).ok()?;
    let corrector = Corrector::new(calibrated, table).ok()?;
    let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = truth
        .iter()
        .enumerate()
        // A stale reading is that of an earlier attitude.
        .filter(|&(row, _)| row == 0 || table.field(row) != table.field(row - 1))
        .filter_map(|(row, truth)| Some((Vector3::from(corrector.correct(row).ok()?), Vector3::from(*truth))))
        .filter(|(own, truth)| own.iter().chain(truth).all(|value| value.is_finite()))
        .collect();
    worst_error_ut(pairs, matches!(diagnosis.alignment, Alignment::Done { .. }))
}

/// The same of corrected vectors beside the true ones; without alignment the best rotation is taken out.
pub fn worst_error_ut(pairs: Vec<(Vector3<f64>, Vector3<f64>)>, is_aligned: bool) -> Option<f64> {
    let linear = linear_error(pairs, is_aligned)?;
    let worst = (0..DIRECTIONS).map(|place| {
        // A spiral of equal areas.
        let z = 1.0 - (2 * place + 1) as f64 / DIRECTIONS as f64;
        let (sine, cosine) = (place as f64 * 2.399_963_229_728_653).sin_cos();
        let across = (1.0 - z * z).sqrt();
        (linear.transpose() * Vector4::new(1.0, across * cosine, across * sine, z)).norm()
    });
    Some(worst.fold(0.0, f64::max))
}

/// The errors of corrected vectors (beside the true ones) as least squares on (1, direction), µT. A stale, clipped or disturbed
/// reading is no error of the calibration: those far off the others are left out, and the rest is fitted again.
fn linear_error(
    mut pairs: Vec<(Vector3<f64>, Vector3<f64>)>,
    is_aligned: bool,
) -> Option<SMatrix<f64, 4, 3>> {
    let mut rounds = 0..ROUNDS_WITHOUT_OUTLIERS;
    loop {
        let mean = |list: &mut dyn Iterator<Item = f64>| list.sum::<f64>() / pairs.len().max(1) as f64;
        let field_ut = mean(&mut pairs.iter().map(|(_, truth)| truth.norm()));
        let scale = field_ut / mean(&mut pairs.iter().map(|(own, _)| own.norm()));
        let rotation = if is_aligned { Matrix3::identity() } else { best_rotation(&pairs)? };
        let at = |truth: &Vector3<f64>| {
            let direction = truth / field_ut;
            Vector4::new(1.0, direction.x, direction.y, direction.z)
        };
        let error = |own: &Vector3<f64>, truth: &Vector3<f64>| rotation * own * scale - truth;
        let (mut normal, mut right) = (Matrix4::zeros(), SMatrix::<f64, 4, 3>::zeros());
        for (own, truth) in &pairs {
            normal += at(truth) * at(truth).transpose();
            right += at(truth) * error(own, truth).transpose();
        }
        let linear = normal.cholesky()?.solve(&right);
        if rounds.next().is_none() {
            return Some(linear);
        }
        let off: Vec<f64> = (pairs.iter())
            .map(|(own, truth)| (error(own, truth) - linear.transpose() * at(truth)).norm())
            .collect();
        let mut sorted = off.clone();
        sorted.sort_by(f64::total_cmp);
        let limit = OUTLIER_OF_MEDIAN * sorted.get(sorted.len() / 2)?;
        let mut off = off.into_iter();
        pairs.retain(|_| off.next().is_some_and(|off| off <= limit));
    }
}

/// The rotation that turns the first vectors best onto the second (Kabsch 1976).
pub fn best_rotation(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Option<Matrix3<f64>> {
    let products: Matrix3<f64> = pairs.iter().map(|(own, truth)| truth * own.transpose()).sum();
    let svd = products.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    Some(u * mirror * v_t)
}
