//! How far readings lie off the ellipsoid that they lie nearest to: the roughness that a change of scale, or an axis of another time,
//! makes without making a row jump.

use crate::samples::series::median;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Coefficients of a quadric whose squares sum to a sphere's.
const TERMS: usize = 9;
/// Readings fill space where their scatter in the narrowest direction is at least this share of that in the widest: level turns, and
/// axes that are copies, do not.
const MIN_SPREAD: f64 = 0.03;
type Normal = SMatrix<f64, TERMS, TERMS>;
type Row = SVector<f64, TERMS>;

/// Root mean square distance from the ellipsoid, as a share of its size; `None` where there is none.
pub fn misfit(points: &[[f64; 3]]) -> Option<f64> {
    if points.len() < 4 * TERMS {
        return None;
    }
    let middle = [0, 1, 2].map(|axis| median(&mut points.iter().map(|p| p[axis]).collect::<Vec<_>>()));
    let about = |p: &[f64; 3]| [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]];
    let length = |p: [f64; 3]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    let size = median(&mut points.iter().map(|p| length(about(p))).collect::<Vec<_>>());
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    // In a plane, or along a line, an ellipsoid is nothing that readings could be off.
    let scatter = points.iter().fold(Matrix3::zeros(), |sum, point| {
        let p = Vector3::from(about(point)) / size;
        sum + p * p.transpose()
    });
    let mean = points.iter().fold(Vector3::zeros(), |sum, point| sum + Vector3::from(about(point)) / size)
        / points.len() as f64;
    let spread = (scatter / points.len() as f64 - mean * mean.transpose()).symmetric_eigenvalues();
    if spread.min() < MIN_SPREAD * spread.max() {
        return None;
    }
    let terms = |p: &[f64; 3]| {
        let [x, y, z] = about(p).map(|v| v / size);
        let row = Row::from([
            x * x + y * y - 2.0 * z * z,
            x * x + z * z - 2.0 * y * y,
            x * y,
            x * z,
            y * z,
            x,
            y,
            z,
            1.0,
        ]);
        (row, x * x + y * y + z * z)
    };
    let (mut normal, mut right) = (Normal::zeros(), Row::zeros());
    for point in points {
        let (row, square) = terms(point);
        normal += row * row.transpose();
        right += row * square;
    }
    // A plane leaves directions that nothing determines.
    normal += Normal::identity() * (1e-9 * normal.trace());
    let solution = normal.cholesky()?.solve(&right);
    let squares = points.iter().map(|point| {
        let (row, square) = terms(point);
        (square - row.dot(&solution)).powi(2)
    });
    // A radius is off by half of what its square is.
    let rms = 0.5 * (squares.sum::<f64>() / points.len() as f64).sqrt();
    rms.is_finite().then_some(rms)
}
