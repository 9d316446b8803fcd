//! An accelerometer that is not calibrated: offset and matrix by the magnetometer's own method, gravity in the field's place.
//!
//! Zero and gains of an accelerometer turn the direction down by as much as they are wrong (0.3 m/s² is 1.8°), and the heading with it.
//! Whether there is anything to correct the log says itself: each tenth of it under the fit of the others (a hand's acceleration is no
//! error of the sensor, and no calibration lowers it).

use crate::calibration::{Accelerometer, STANDARD_GRAVITY_MPS2};
use crate::table::Table;
use ironout::fit::{FitOptions, MAX_PREDICTED_ERROR, fit};
use ironout::scatter::ScatterBuilder;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Parts of a log.
const PARTS: usize = 10;
/// Fewer rows say nothing.
const FEWEST: usize = 200;
/// A calibration is used where it lowers the squares on unseen time by so many standard errors of the parts' mean (of a Student t with 9
/// degrees of freedom, chance is further out once in 600) ...
const CERTAIN: f64 = 4.0;
/// ... leaves at most this share of them: beside a hand's large accelerations, which go with the attitudes, a small correction is theirs ...
const LEAVES: f64 = 0.9;
/// ... and takes off at least this, m/s² rms: less is 0.3° at most.
const LEAST_MPS2: f64 = 0.05;
/// ... and so many times what the correction itself is known to: one that the attitudes hardly determine turns more than it mends.
const KNOWN: f64 = 5.0;
/// The core's fit is of a field: m/s² times this lie in its range.
const AS_FIELD: f64 = 5.0;

/// The calibration of a log's accelerometer; `None` without one, where its attitudes do not determine it, and where it has nothing to
/// correct.
pub fn accelerometer(table: &Table<'_>) -> Option<Accelerometer> {
    let axes = table.accel_mps2?;
    let rows: Vec<[f64; 3]> = (0..table.rows())
        .map(|row| axes.map(|axis| axis[row]))
        .filter(|row| row.iter().all(|value| value.is_finite()))
        .collect();
    if rows.len() < FEWEST {
        return None;
    }
    let part = |at: usize| at * rows.len() / PARTS..(at + 1) * rows.len() / PARTS;
    let sums: Vec<ScatterBuilder> = (0..PARTS)
        .map(|at| {
            let mut sum = ScatterBuilder::new([0.0; 3]);
            rows[part(at)].iter().for_each(|row| sum.push(row.map(|value| AS_FIELD * value)));
            sum
        })
        .collect();
    let length = |row: &[f64; 3]| Vector3::from(*row).norm();
    let mean = rows.iter().map(length).sum::<f64>() / rows.len() as f64;
    let squares: f64 = rows.iter().map(|row| (length(row) - mean).powi(2)).sum();
    let before_mps2 = (squares / rows.len() as f64).sqrt();
    // What the calibration takes off the mean square of each part.
    let mut taken = [0.0; PARTS];
    for (at, taken) in taken.iter_mut().enumerate() {
        let ((own, _), rows) = (fitted(&sums, Some(at))?, &rows[part(at)]);
        let square = |row: &[f64; 3]| {
            (length(row) - mean).powi(2) - (length(&own.apply(*row)) - STANDARD_GRAVITY_MPS2).powi(2)
        };
        *taken = rows.iter().map(square).sum::<f64>() / rows.len() as f64;
    }
    let n = PARTS as f64;
    let mean_taken = taken.iter().sum::<f64>() / n;
    let variance = taken.iter().map(|one| (one - mean_taken).powi(2)).sum::<f64>() / (n - 1.0);
    let certain = mean_taken > CERTAIN * (variance / n).sqrt();
    let matters =
        mean_taken > (1.0 - LEAVES) * before_mps2 * before_mps2 && mean_taken > LEAST_MPS2 * LEAST_MPS2;
    let after_mps2 = (before_mps2 * before_mps2 - mean_taken).max(0.0).sqrt();
    let (whole, error_mps2) = fitted(&sums, None)?;
    let is_known = mean_taken > (KNOWN * error_mps2).powi(2);
    (certain && matters && is_known).then_some(Accelerometer { before_mps2, after_mps2, ..whole })
}

/// Of all parts but one, and the predicted error of what it corrects, m/s².
fn fitted(sums: &[ScatterBuilder], without: Option<usize>) -> Option<(Accelerometer, f64)> {
    let mut sum = ScatterBuilder::new([0.0; 3]);
    sums.iter().enumerate().filter(|(at, _)| Some(*at) != without).for_each(|(_, part)| {
        sum.merge(part);
    });
    let options = FitOptions { field_ut: Some(AS_FIELD * STANDARD_GRAVITY_MPS2), ..FitOptions::default() };
    let report = fit(&sum.finish(0.0).ok()?, &options).ok()?;
    let own = Matrix3::from_fn(|i, j| report.calibration.matrix[i][j]);
    // The symmetric matrix of the same ellipsoid.
    let squared = SymmetricEigen::try_new(own.transpose() * own, 1e-14, 200)?;
    let root = Matrix3::from_diagonal(&squared.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let matrix = squared.eigenvectors * root * squared.eigenvectors.transpose();
    let known = matrix.iter().all(|value| value.is_finite())
        && report.predicted_error_ut <= MAX_PREDICTED_ERROR * report.calibration.field_ut;
    let own = Accelerometer {
        offset_mps2: report.calibration.offset_ut.map(|value| value / AS_FIELD),
        matrix: std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)])),
        before_mps2: 0.0,
        after_mps2: 0.0,
    };
    known.then_some((own, report.predicted_error_ut / AS_FIELD))
}
