//! How far readings lie off the ellipsoid that they lie nearest to: the roughness that a change of scale, or an axis of another time,
//! makes without making a row jump.

use super::series::half_range;
use crate::samples::series::median;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Readings that an ellipsoid is fitted to, at most.
const MAX_POINTS: usize = 2500;
/// A repair leaves at most this share of the distance from the ellipsoid.
pub const MAX_MISFIT_SHARE: f64 = 0.4;
/// Coefficients of a quadric whose squares sum to a sphere's.
const TERMS: usize = 9;
/// Readings fill space where their scatter in the narrowest direction is at least this share of that in the widest: level turns, and
/// axes that are copies, do not.
const MIN_SPREAD: f64 = 0.03;
/// Readings lie within this many half ranges of the median of each axis: a median at one end of a range is two away from the other.
const MAX_REACH: f64 = 2.2;
/// How often what is far off is left out and the rest fitted again: each fit is bent less.
const TRIMS: usize = 3;
/// Readings that are further off than this many times the median are not of the sensor alone.
const MAX_USUAL: f64 = 5.0;
type Normal = SMatrix<f64, TERMS, TERMS>;
type Row = SVector<f64, TERMS>;

/// Readings from all over a log, from the numbers by row and axis. Their distance is an odd number of rows, so that where every second row is
/// of another kind, both kinds are among them.
pub fn points(rows: usize, of: impl Fn(usize, usize) -> f64) -> Vec<[f64; 3]> {
    let every = rows.div_ceil(MAX_POINTS) | 1;
    (0..rows).step_by(every).map(|row| [0, 1, 2].map(|axis| of(row, axis))).collect()
}

/// Root mean square distance from the ellipsoid, as a share of its size; `None` where there is none.
pub fn misfit(points: &[[f64; 3]]) -> Option<f64> {
    Some(rms(&off(points)?))
}

/// The same of the readings without those that are far off: spikes and a passing magnet say nothing of the others. What lies outside of
/// the readings' own range goes first: it would bend every fit. With how many readings it is of.
pub fn usual_misfit(points: &[[f64; 3]]) -> Option<(f64, usize)> {
    let mut kept = points.to_vec();
    for axis in 0..3 {
        let values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        let (middle, reach) = (median(&mut values.clone()), MAX_REACH * half_range(&values));
        kept.retain(|point| (point[axis] - middle).abs() <= reach);
    }
    for _ in 0..TRIMS {
        let far = off(&kept)?;
        let most = MAX_USUAL * median(&mut far.iter().map(|off| off.abs()).collect::<Vec<_>>());
        let mut far = far.iter();
        kept.retain(|_| far.next().is_some_and(|off| off.abs() <= most));
    }
    Some((rms(&off(&kept)?), kept.len()))
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// How far each reading is off, as a share of the ellipsoid's size.
fn off(points: &[[f64; 3]]) -> Option<Vec<f64>> {
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
    // A radius is off by half of what its square is.
    let off = points.iter().map(|point| {
        let (row, square) = terms(point);
        0.5 * (square - row.dot(&solution))
    });
    let off: Vec<f64> = off.collect();
    off.iter().all(|value| value.is_finite()).then_some(off)
}
