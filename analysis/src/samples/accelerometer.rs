//! An accelerometer that is not calibrated: offset and matrix by the magnetometer's own method, gravity in the field's place.
//!
//! Zero and gains of an accelerometer turn the direction down by as much as they are wrong (0.3 m/s² is 1.8°), and the heading with it.
//! Whether there is anything to correct the log says itself: each tenth of it under the fit of the others (a hand's acceleration is no
//! error of the sensor, and no calibration lowers it).

use crate::calibration::{Accelerometer, STANDARD_GRAVITY_MPS2};
use crate::samples::detected::Estimate;
use crate::table::Table;
use ironout::fit::{FitOptions, MAX_PREDICTED_ERROR, fit};
use ironout::scatter::ScatterBuilder;
use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

/// Parts of a log.
const PARTS: usize = 10;
/// Fewer rows say nothing.
const FEWEST: usize = 200;
/// A calibration is used where it lowers the squares on held-out time by so many standard errors of the parts' mean (of a Student t with 9
/// degrees of freedom, chance is further out once in 600) ...
const CERTAIN: f64 = 4.0;
/// ... leaves at most this share of them: next to a hand's large accelerations, which go with the attitudes, a small correction is theirs ...
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

/// Zero errors before a log says more, m/s²: typical ones in the data sheets of LSM6DSO and BMI270 are 20 mg, of LIS3DH and LSM303AGR 40.
const ZERO_MPS2: f64 = 0.2;
/// Gains before a log says more, in m/s² at gravity: tenfold what data sheets allow, since a hand's acceleration makes readings longer.
const GAIN_MPS2: f64 = 1.0;

/// Second moment of the zero error that an accelerometer is expected to have, (m/s²)²: what data sheets allow, narrowed by what the
/// lengths of its readings say. `|a| − g = a₀·û + Σ gᵢûᵢ²` is linear in zero `a₀` and gains; the errors of these are those of batch means, since a
/// hand's acceleration goes with the motion. The zero itself is not corrected, so that it is part of the moment.
pub fn zero_error_square(axes: [&[f64]; 3]) -> Matrix3<f64> {
    let rows = axes[0].len();
    let row = |row: usize| {
        let force = Vector3::from_fn(|axis, _| axes[axis][row]);
        let length = force.norm();
        let u = force / length;
        let known = length.is_finite() && length > 0.0;
        known.then(|| (SVector::from([u.x, u.y, u.z, u.x * u.x, u.y * u.y, u.z * u.z]), length))
    };
    let prior = SVector::from([ZERO_MPS2, ZERO_MPS2, ZERO_MPS2, GAIN_MPS2, GAIN_MPS2, GAIN_MPS2])
        .map(|spread| 1.0 / (spread * spread));
    let (mut normal, mut right) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
    for (column, length) in (0..rows).filter_map(row) {
        normal += column * column.transpose();
        right += column * (length - STANDARD_GRAVITY_MPS2);
    }
    let mut estimate = Estimate::new(normal, right, prior, rows);
    for (at, (column, length)) in (0..rows).filter_map(|at| Some((at, row(at)?))) {
        estimate.add(at, column, length - STANDARD_GRAVITY_MPS2);
    }
    let (mean, covariance) = estimate.posterior();
    (covariance + mean * mean.transpose()).fixed_view::<3, 3>(0, 0).into_owned()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Attitudes all around, one after the other, of a gravity that an accelerometer with this zero error reads; a hand adds so much, slowly.
    fn moment(zero: [f64; 3], hand_mps2: f64, level: bool) -> Matrix3<f64> {
        let rows = 3000;
        let mut axes: [Vec<f64>; 3] = Default::default();
        for row in 0..rows {
            let t = f64::from(row) * 0.02;
            let z = if level { 1.0 } else { (0.9 * t).sin() };
            let across = (1.0_f64 - z * z).max(0.0).sqrt();
            let u = [across * (0.37 * t).cos(), across * (0.37 * t).sin(), z];
            let hand =
                [hand_mps2 * (5.3 * t).sin(), hand_mps2 * (4.1 * t).cos(), hand_mps2 * (6.7 * t).sin()];
            (0..3).for_each(|i| axes[i].push(STANDARD_GRAVITY_MPS2 * u[i] + zero[i] + hand[i]));
        }
        zero_error_square(axes.each_ref().map(Vec::as_slice))
    }

    #[test]
    fn lengths_tell_a_zero_error_as_far_as_the_attitudes_go() {
        let zero = [0.1, -0.05, 0.02];
        let moments = moment(zero, 0.0, false);
        for (axis, value) in zero.into_iter().enumerate() {
            assert!((moments[(axis, axis)].sqrt() - value.abs()).abs() < 0.02, "{moments}");
        }
        let none = moment([0.0; 3], 0.0, false);
        assert!((0..3).all(|axis| none[(axis, axis)].sqrt() < 0.01), "{none}");
        let level = moment([0.0; 3], 0.0, true);
        assert!((0..2).all(|axis| (level[(axis, axis)].sqrt() - ZERO_MPS2).abs() < 1e-3), "{level}");
        // A hand makes it less certain, and never more than what chips have.
        let shaken = moment([0.0; 3], 2.0, false);
        assert!((0..3).all(|axis| shaken[(axis, axis)] > none[(axis, axis)]), "{shaken}");
    }

    #[test]
    fn nothing_is_known_of_nothing() {
        let none = [f64::NAN; 30];
        for moment in [zero_error_square([&none; 3]), zero_error_square([&[]; 3])] {
            let prior = Matrix3::from_diagonal_element(ZERO_MPS2 * ZERO_MPS2);
            assert!((moment - prior).norm() < 1e-12, "{moment}");
        }
    }
}
