//! How the magnetometer is turned beside the gyro, from the field's own turning.
//!
//! In the board's frame the field turns against the board: `dh/dt = −ω × h`. Over a short turn `φ` that the gyro has summed up,
//! `Δu = ū × (Rᵀ φ')` exactly, with `ū` the mean of the direction before and after and `φ'` the turn's axis times
//! `2 tan(|φ|/2)` (Cayley). That is linear in the nine entries of `Rᵀ`. No acceleration of the board's own disturbs it.

use crate::bounds::{GYRO_GAINS, GYRO_RAD};
use crate::samples::samples::Samples;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Turns of so much are compared, rad: beside them the noise of a direction is small.
const TURN_RAD: f64 = 0.15;
/// Their axis moves little in so short a time, s.
const LONGEST_S: f64 = 0.25;
/// A smaller turn in that time says little, rad.
const LEAST_RAD: f64 = 0.03;
/// A larger turn from one sample to the next is not summed up well, rad.
const MOST_RAD: f64 = 0.7;
/// Fewer turns tell nothing.
const LEAST_TURNS: usize = 100;

/// One turn: the direction before and after, and what the gyro has summed up between them, rad.
struct Turn {
    before: Vector3<f64>,
    after: Vector3<f64>,
    turn_rad: Vector3<f64>,
}

/// The turns of a log, one after the other.
fn turns(samples: &Samples, direction: &dyn Fn(usize) -> Vector3<f64>) -> Vec<Turn> {
    let Some(time) = &samples.time else { return Vec::new() };
    let rate = |at: usize| samples.readings[at].turn_radps.map(Vector3::from);
    let mut list = Vec::new();
    let (mut from, mut turn_rad) = (0, Vector3::zeros());
    for next in 1..samples.len() {
        let (Some(one), Some(two)) = (rate(next - 1), rate(next)) else {
            (from, turn_rad) = (next, Vector3::zeros());
            continue;
        };
        let step = 0.5 * (one + two) * (time[next] - time[next - 1]);
        turn_rad += step;
        let late = time[next] - time[from] > LONGEST_S;
        if !(step.norm() < MOST_RAD) {
            (from, turn_rad) = (next, Vector3::zeros());
        } else if turn_rad.norm() > TURN_RAD || late {
            // A gap in the log ends a turn too.
            if turn_rad.norm() > LEAST_RAD && time[next] - time[from] < 2.0 * LONGEST_S {
                list.push(Turn { before: direction(from), after: direction(next), turn_rad });
            }
            (from, turn_rad) = (next, Vector3::zeros());
        }
    }
    list
}

/// The rotation from the frame of the field's `direction` at each sample to the gyro's. `None` where the log has no gyro or too few
/// turns about different axes.
pub fn rotation(samples: &Samples, direction: &dyn Fn(usize) -> Vector3<f64>) -> Option<Matrix3<f64>> {
    let turns = turns(samples, direction);
    if turns.len() < LEAST_TURNS {
        return None;
    }
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    let mut right = SVector::<f64, 9>::zeros();
    let mut squares = 0.0;
    for Turn { before, after, turn_rad } in &turns {
        let (mean, change) = (0.5 * (before + after), after - before);
        let half = 0.5 * turn_rad.norm();
        let turn = turn_rad * (half.tan() / half);
        for axis in 0..3 {
            let mut row = SVector::<f64, 9>::zeros();
            for entry in 0..3 {
                let across = mean.cross(&Vector3::ith(entry, 1.0))[axis];
                (0..3).for_each(|other| row[3 * entry + other] = across * turn[other]);
            }
            normal += row * row.transpose();
            right += row * change[axis];
            squares += change[axis] * change[axis];
        }
    }
    let inverse = normal.cholesky()?.inverse();
    let found = inverse * right;
    let left = (squares - found.dot(&right)).max(0.0) / (3 * turns.len() - 9) as f64;
    let worst = (0..9).map(|i| (inverse[(i, i)] * left).sqrt()).fold(0.0, f64::max);
    let svd = Matrix3::from_fn(|i, j| found[3 * i + j]).try_svd(true, true, 1e-12, 200)?;
    let sound = worst < GYRO_RAD && svd.singular_values.iter().all(|value| GYRO_GAINS.contains(value));
    let turned = svd.u? * svd.v_t?;
    (sound && turned.determinant() > 0.0).then(|| turned.transpose())
}
