//! What a calibration's errors make of a heading, at the attitudes that a vehicle has.

use crate::confined::solve::Solved;
use crate::confined::state::{MATRIX, OFFSET, ZERO, effect_at};
use nalgebra::{DVector, Rotation3, Vector3};

/// Headings, and directions to tilt to, over which an error is averaged.
const HEADINGS: usize = 24;
const TILTS: usize = 8;

/// How far a heading follows the parameters, at one attitude: the corrected reading's error towards magnetic east over the horizontal
/// field. `attitude` takes the board's axes to north, east, down.
fn follows(solved: &Solved, mean_down: &Vector3<f64>, attitude: &Rotation3<f64>) -> DVector<f64> {
    let state = &solved.state;
    let level_ut = horizontal_ut(solved);
    let field = attitude.inverse() * Vector3::new(level_ut, 0.0, state.vertical_ut);
    let east = attitude.inverse() * Vector3::y();
    let mut row = DVector::zeros(state.parameters());
    let offset = -state.matrix.transpose() * east;
    for i in 0..3 {
        row[OFFSET + i] = offset[i] / level_ut;
        for j in 0..3 {
            row[MATRIX + 3 * i + j] = east[i] * field[j] / level_ut;
        }
        // The matrix is turned to gravity as the accelerometer shows it at the mean attitude.
        let turned = mean_down.cross(&Vector3::ith(i, 1.0)).cross(&field);
        row[ZERO + i] = east.dot(&turned) / level_ut;
    }
    row
}

/// The horizontal part of the field, µT.
pub fn horizontal_ut(solved: &Solved) -> f64 {
    let state = &solved.state;
    (state.field_ut.powi(2) - state.vertical_ut.powi(2)).max(1e-4 * state.field_ut.powi(2)).sqrt()
}

/// Standard deviation of a heading, degrees rms over all headings and all ways to be tilted by so much from the mean attitude, with the
/// accelerometer's gravity and effects whose columns have these mean squares. One constant for all headings is not an error of a calibration: it is how the board stands in the vehicle.
pub fn heading_error_deg(
    solved: &Solved,
    mean_down: &Vector3<f64>,
    effects_square: &[f64],
    tilt_deg: f64,
) -> f64 {
    let upright = Rotation3::rotation_between(mean_down, &Vector3::z())
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let turn = |part: usize, of: usize| std::f64::consts::TAU * part as f64 / of as f64;
    let at = |heading: usize, tilt: f64, way: usize| {
        let way = turn(way, TILTS);
        let axis = Vector3::new(way.cos(), way.sin(), 0.0);
        Rotation3::from_euler_angles(0.0, 0.0, turn(heading, HEADINGS))
            * Rotation3::new(axis * tilt)
            * upright
    };
    let level: Vec<DVector<f64>> =
        (0..HEADINGS).map(|heading| follows(solved, mean_down, &at(heading, 0.0, 0))).collect();
    let constant = level.iter().sum::<DVector<f64>>() / HEADINGS as f64;
    let ways = if tilt_deg > 0.0 { TILTS } else { 1 };
    let mut square = 0.0;
    for heading in 0..HEADINGS {
        for way in 0..ways {
            let row = follows(solved, mean_down, &at(heading, tilt_deg.to_radians(), way)) - &constant;
            square += row.dot(&(&solved.covariance * &row));
            for (effect, column_square) in effects_square.iter().enumerate() {
                // The vector of an effect moves a heading as the offset does, as much as its column is away from where it is zero.
                let by_offset = row.fixed_rows::<3>(OFFSET);
                let part = solved.covariance.fixed_view::<3, 3>(effect_at(effect), effect_at(effect));
                square += column_square * by_offset.dot(&(part * by_offset));
            }
        }
    }
    (square / (HEADINGS * ways) as f64).max(0.0).sqrt().to_degrees()
}

/// Standard deviation (rms length) of a corrected vector in the worst direction, µT, with the rotation between the sensors.
pub fn vector_error_ut(solved: &Solved) -> f64 {
    let state = &solved.state;
    let directions = 200;
    let mut worst = 0.0_f64;
    for index in 0..directions {
        // A spiral of equal areas.
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(directions);
        let (r, angle) = ((1.0 - z * z).sqrt(), f64::from(index) * 2.399_963_229_728_653);
        let v = Vector3::new(r * angle.cos(), r * angle.sin(), z) * state.field_ut;
        let square: f64 = (0..3)
            .map(|axis| {
                let mut row = DVector::zeros(state.parameters());
                for i in 0..3 {
                    row[OFFSET + i] = -state.matrix[(axis, i)];
                    row[MATRIX + 3 * axis + i] = v[i];
                }
                row.dot(&(&solved.covariance * &row))
            })
            .sum();
        worst = worst.max(square);
    }
    worst.sqrt()
}

/// Standard errors of the offset, µT, and of the matrix.
pub fn std_errors(solved: &Solved) -> ([f64; 3], [[f64; 3]; 3]) {
    let sigma = |at: usize| solved.covariance[(at, at)].max(0.0).sqrt();
    let matrix = solved.state.matrix;
    // dC = E C: an entry's variance from those of its row of E.
    let entry = |i: usize, j: usize| {
        let row = Vector3::from(matrix.column(j));
        let part = solved.covariance.fixed_view::<3, 3>(MATRIX + 3 * i, MATRIX + 3 * i);
        row.dot(&(part * row)).max(0.0).sqrt()
    };
    (
        std::array::from_fn(|i| sigma(OFFSET + i)),
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
    )
}
