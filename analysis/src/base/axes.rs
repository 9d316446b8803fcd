//! The rotation that magnitudes leave open, from an accelerometer: the matrix becomes a full 3×3.

use crate::base::dip_errors::{RotationErrors, TRIANGLE};
use crate::base::mounting::OrderStatus;
use crate::bounds::{ALIGNABLE, KNOWN_DEG, MAX_DIP_SPREAD_DEG};
use crate::calibration::StdErrors;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use serde::Serialize;

/// Whether the matrix stands in the accelerometer's axes.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub enum Alignment {
    /// There is no accelerometer (or it says too little).
    #[default]
    None,
    /// The matrix is a full one.
    Done {
        /// Rotation beside the triangular matrix, degrees.
        angle_deg: f64,
        /// Spread of the dip before, degrees.
        before_deg: f64,
        /// Spread of the dip after, degrees.
        after_deg: f64,
        /// How the axes stand in the log: in order, or as a mounting that the matrix contains.
        order_status: OrderStatus,
    },
    /// The matrix is a full one, fitted with the accelerometer and the gyro at once.
    ByAll,
    /// The log's axes are those of a left hand: no rotation mends that, and the corrected vector would point elsewhere.
    Mirrored(OrderStatus),
    /// The log's axes are a mounting's or its mirror image's, and nothing that is known tells which.
    Open(OrderStatus),
    /// The accelerometer shows no constant dip: the matrix stays triangular.
    NoDip {
        /// Spread of the dip after the best rotation, degrees.
        after_deg: f64,
    },
}

/// What the dip says about a model.
#[derive(Debug, Clone, Copy)]
pub struct Found<'f> {
    /// Spread of the dip with the triangular matrix, degrees.
    pub before_deg: f64,
    /// Spread of the dip after alignment, degrees.
    pub after_deg: f64,
    /// Angle of the rotation beside the symmetric matrix, degrees.
    pub angle_deg: f64,
    /// How the axes stand in the log.
    pub order_status: OrderStatus,
    /// Errors of the rotation vector.
    pub rotation: Option<&'f RotationErrors>,
}

/// A matrix in the axes that it can be given in, with its errors.
#[derive(Debug, Clone)]
pub struct Aligned {
    /// Full where aligned, else upper triangular.
    pub matrix: [[f64; 3]; 3],
    /// Standard errors of offset and matrix.
    pub std_errors: StdErrors,
    /// Whether it is aligned, and why not.
    pub alignment: Alignment,
    /// 1σ that the rotation turns a corrected vector by, rad rms in the worst direction; zero where there is no rotation.
    pub rotation_error_rad: f64,
}

impl Aligned {
    /// Of `full`, whose offset and triangle have this `covariance` and whose corrected vectors are predicted to be off by
    /// `predicted_share` of the field: aligned where the dip says enough. `None` where `full` is singular.
    pub fn of(
        full: &[[f64; 3]; 3],
        covariance: &[[f64; 9]; 9],
        predicted_share: f64,
        found: Option<Found>,
    ) -> Option<Self> {
        let triangle = triangle_of(full)?;
        let alignment = match &found {
            Some(found) if predicted_share <= ALIGNABLE => alignment(found, covariance),
            _ => Alignment::None,
        };
        let rotation = found.and_then(|found| found.rotation);
        let offset_ut = [0, 1, 2].map(|i| covariance[i][i].max(0.0).sqrt());
        let (matrix, errors) = match &alignment {
            Alignment::Done { .. } => (*full, full_errors(&triangle, full, covariance, rotation)),
            _ => (triangle, full_errors(&triangle, &triangle, covariance, None)),
        };
        let is_done = matches!(alignment, Alignment::Done { .. });
        let rotation_error_rad =
            rotation.filter(|_| is_done).map_or(0.0, |rotation| across(&rotation.covariance(covariance)));
        let std_errors = StdErrors { offset_ut, matrix: errors };
        Some(Aligned { matrix, std_errors, alignment, rotation_error_rad })
    }
}

fn alignment(found: &Found, covariance: &[[f64; 9]; 9]) -> Alignment {
    let error_deg = found.rotation.map(|rotation| {
        let turned = rotation.covariance(covariance);
        (0..3).map(|i| turned[(i, i)].max(0.0).sqrt().to_degrees()).fold(0.0, f64::max)
    });
    let order_status = found.order_status;
    if order_status.is_open() {
        return Alignment::Open(order_status);
    }
    if order_status.is_mirrored() {
        return Alignment::Mirrored(order_status);
    }
    if found.after_deg > MAX_DIP_SPREAD_DEG {
        return Alignment::NoDip { after_deg: found.after_deg };
    }
    match error_deg {
        Some(error_deg) if error_deg <= KNOWN_DEG => Alignment::Done {
            angle_deg: found.angle_deg,
            before_deg: found.before_deg,
            after_deg: found.after_deg,
            order_status,
        },
        _ => Alignment::None,
    }
}

/// Rms length of `φ × u` for the unit vector `u` where it is largest: across the axis about which least is uncertain.
fn across(rotation: &Matrix3<f64>) -> f64 {
    (rotation.trace() - rotation.symmetric_eigenvalues().min().max(0.0)).max(0.0).sqrt()
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
fn full_errors(
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
    use crate::base::start::NO_ROTATION;

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
