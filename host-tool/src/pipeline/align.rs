//! The rotation that magnitudes leave open, from an accelerometer: the matrix becomes a full 3×3.

use super::solution::{Alignment, Solution};
use super::{Data, MOST_SPREAD_DEG};
use crate::diagnose::alignment::align;
use crate::diagnose::base::NO_ROTATION;
use crate::diagnose::dip_errors::{DipErrors, RotationErrors, TRIANGLE};
use crate::diagnose::samples::Samples;
use ironout::study::Model;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// A calibration whose predicted error is beyond this share of the field says nothing about directions.
pub const ALIGNABLE: f64 = 0.05;
/// A rotation is used where its standard error is below this, degrees.
const KNOWN_DEG: f64 = 3.0;

/// Aligns a solution with a triangular matrix, whose offset and triangle have this covariance.
pub fn align_solution(data: &Data, used: &[u32], solution: &mut Solution, covariance: &[[f64; 9]; 9]) {
    let sure = solution.predicted_error_ut <= ALIGNABLE * solution.calibration.field_ut;
    if data.log.accel_mps2.is_none() || !sure {
        return;
    }
    let samples = Samples::take(&data.table_of(used), &vec![false; data.log.rows], [true; 3]);
    let down = samples.readings.iter().filter(|reading| reading.down.is_some()).count();
    let triangle = solution.calibration.matrix;
    let (offset_ut, field_ut) = (solution.calibration.offset_ut, solution.calibration.field_ut);
    let model = Model::new(offset_ut, triangle, field_ut, NO_ROTATION, 0.0);
    let Some(model) = model.filter(|_| down * 10 > 3 * samples.len()) else { return };
    // There are no effects here whose shape could fail.
    let Ok(Some(found)) = align(&samples, &model) else { return };
    let Ok(Some(errors)) = DipErrors::of(&samples, &found.model, &[], None) else { return };
    let rotation = errors.rotation(None);
    let turned = rotation.covariance(covariance);
    let error_deg = (0..3).map(|i| turned[(i, i)].max(0.0).sqrt().to_degrees()).fold(0.0, f64::max);
    if found.after_deg > MOST_SPREAD_DEG {
        solution.alignment = Alignment::NoDip { after_deg: found.after_deg };
        return;
    }
    if error_deg > KNOWN_DEG {
        return;
    }
    let axis_order = found.axis_order;
    if let Some(order) = axis_order.clone().filter(|order| is_mirrored(order)) {
        solution.alignment = Alignment::Mirrored { order };
        return;
    }
    solution.calibration.matrix = found.model.full_matrix();
    solution.std_errors.matrix =
        full_errors(&triangle, &solution.calibration.matrix, covariance, Some(&rotation));
    solution.alignment = Alignment::Done {
        angle_deg: found.angle_deg,
        before_deg: found.before_deg,
        after_deg: found.after_deg,
        axis_order,
    };
}

/// Whether an order of axes, as in `y,x,z`, turns right hands into left ones: then no rotation mends it.
pub fn is_mirrored(order: &str) -> bool {
    let names: Vec<&str> = order.split(',').map(|name| name.trim_start_matches('-')).collect();
    let swaps = (0..names.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let odd = swaps.filter(|&(i, j)| names[i] < names[j]).count() + order.matches('-').count();
    odd % 2 == 1
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// The upper triangular matrix with the same `CᵀC`: an aligned matrix without its rotation.
pub fn triangle_of(full: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let c = matrix(full);
    let upper = (c.transpose() * c).cholesky()?.l().transpose();
    Some(std::array::from_fn(|i| std::array::from_fn(|j| upper[(i, j)])))
}

/// Standard errors of a full matrix `M = R C`: `δM = R δC + φ × M`, where the rotation `φ` follows offset and triangle.
pub fn full_errors(
    triangle: &[[f64; 3]; 3],
    full: &[[f64; 3]; 3],
    covariance: &[[f64; 9]; 9],
    rotation: Option<&RotationErrors>,
) -> [[f64; 3]; 3] {
    let m = matrix(full);
    let r = matrix(triangle).try_inverse().map_or_else(Matrix3::identity, |inverse| m * inverse);
    let nine = SMatrix::<f64, 9, 9>::from_fn(|i, j| covariance[i][j]);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let mut weights = SVector::<f64, 9>::zeros();
            for (slot, (row, _)) in TRIANGLE.into_iter().enumerate().filter(|(_, (_, column))| *column == j) {
                weights[3 + slot] = r[(i, row)];
            }
            let mut variance = 0.0;
            if let Some(rotation) = rotation {
                let column: Vector3<f64> = m.column(j).into();
                let turn = Vector3::from_fn(|axis, _| Vector3::ith(axis, 1.0).cross(&column)[i]);
                weights += SMatrix::<f64, 3, 9>::from_fn(|i, j| rotation.follows[i][j]).transpose() * turn;
                variance += turn.dot(&(matrix(&rotation.own) * turn));
            }
            (variance + weights.dot(&(nine * weights))).max(0.0).sqrt()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_rotation_the_errors_are_those_of_the_triangle() {
        let triangle = [[1.1, 0.1, -0.05], [0.0, 0.9, 0.2], [0.0, 0.0, 1.0]];
        let mut covariance = [[0.0; 9]; 9];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = (i as f64 * 1e-3).powi(2);
        }
        let errors = full_errors(&triangle, &triangle, &covariance, None);
        for (errors, expected) in errors.iter().flatten().zip([3.0, 4.0, 5.0, 0.0, 6.0, 7.0, 0.0, 0.0, 8.0]) {
            assert!((errors - expected * 1e-3).abs() < 1e-12, "{errors} against {expected}");
        }
        assert!(
            triangle_of(&triangle)
                .expect("positive definite")
                .iter()
                .flatten()
                .zip(triangle.iter().flatten())
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
    }

    #[test]
    fn a_mirrored_order_is_told_from_a_turned_one() {
        for (order, mirrored) in
            [("x,y,z", false), ("y,x,z", true), ("y,x,-z", false), ("y,z,x", false), ("-x,-y,-z", true)]
        {
            assert_eq!(is_mirrored(order), mirrored, "{order}");
        }
    }

    #[test]
    fn an_error_of_the_rotation_shows_across_each_column() {
        let identity = NO_ROTATION;
        let about_z = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 4e-6]];
        let rotation = RotationErrors { own: about_z, follows: [[0.0; 9]; 3] };
        let errors = full_errors(&identity, &identity, &[[0.0; 9]; 9], Some(&rotation));
        for (i, row) in errors.iter().enumerate() {
            for (j, error) in row.iter().enumerate() {
                let expected = if (i, j) == (0, 1) || (i, j) == (1, 0) { 2e-3 } else { 0.0 };
                assert!((error - expected).abs() < 1e-12, "{i} {j}: {error}");
            }
        }
    }
}
