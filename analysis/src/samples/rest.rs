//! Whether a log is of a board at rest.

use crate::samples::samples::Samples;
use crate::samples::series::median;
use nalgebra::{DMatrix, DVector};

/// A turning board turns faster than this for half of the time, rad/s.
const RESTING_RADPS: f64 = 0.05;
/// A resting board's direction down stays within this angle's sine.
const RESTING_TILT: f64 = 0.06;
/// Without gyro and accelerometer: the share of the vector's variance that the columns must explain.
const EXPLAINED: f64 = 0.6;

/// Whether the board rests: then the vector itself is the residual.
pub fn at_rest(samples: &Samples) -> bool {
    let turns: Vec<f64> = samples
        .readings
        .iter()
        .filter_map(|reading| reading.turn_radps)
        .map(|w| w.iter().map(|value| value * value).sum::<f64>().sqrt())
        .collect();
    let downs: Vec<[f64; 3]> = samples.readings.iter().filter_map(|reading| reading.down).collect();
    let enough = |n: usize| 2 * n > samples.len();
    if enough(downs.len()) {
        return tilt(&downs) < RESTING_TILT && (!enough(turns.len()) || slow(turns));
    }
    if enough(turns.len()) {
        return slow(turns);
    }
    explained_by_columns(samples) > EXPLAINED
}

fn slow(mut turns: Vec<f64>) -> bool {
    median(&mut turns) < RESTING_RADPS
}

fn tilt(downs: &[[f64; 3]]) -> f64 {
    let n = downs.len() as f64;
    let mean = [0, 1, 2].map(|axis| downs.iter().map(|d| d[axis]).sum::<f64>() / n);
    (downs.iter().map(|d| (0..3).map(|axis| (d[axis] - mean[axis]).powi(2)).sum::<f64>()).sum::<f64>() / n)
        .sqrt()
}

/// Share of the measured vector's variance that a linear combination of the covariates explains, if the vector stays
/// within less than half of its own length; zero otherwise.
fn explained_by_columns(samples: &Samples) -> f64 {
    let columns: Vec<_> = samples.columns.iter().filter(|column| column.problem.is_none()).take(16).collect();
    let mean = samples.mean_vector();
    let length = mean.iter().map(|value| value * value).sum::<f64>().sqrt();
    let n = samples.len();
    let spread = (samples
        .readings
        .iter()
        .map(|reading| (0..3).map(|axis| (reading.measured_ut[axis] - mean[axis]).powi(2)).sum::<f64>())
        .sum::<f64>()
        / n.max(1) as f64)
        .sqrt();
    // An axis that is a copy of another leaves no ellipsoid to lose: then a coil may be as strong as the field.
    let most = if samples.axes == [true; 3] { 0.5 } else { 2.0 };
    if columns.is_empty() || n < 10 * columns.len() || spread > most * length {
        return 0.0;
    }
    let scales: Vec<f64> = columns
        .iter()
        .map(|column| (column.mean_square - column.mean * column.mean).max(1e-300).sqrt())
        .collect();
    let k = 2 * columns.len();
    let mut normal = DMatrix::<f64>::zeros(k, k);
    let mut right = DMatrix::<f64>::zeros(k, 3);
    let mut total = 0.0;
    for sample in 0..n {
        let row = DVector::from_iterator(
            k,
            columns.iter().zip(&scales).flat_map(|(column, scale)| {
                let value = (column.values[sample] - column.mean) / scale;
                [value, value * value - 1.0]
            }),
        );
        let off =
            nalgebra::RowVector3::from_fn(|_, axis| samples.readings[sample].measured_ut[axis] - mean[axis]);
        normal += &row * row.transpose();
        right += &row * off;
        total += off.norm_squared();
    }
    for i in 0..k {
        normal[(i, i)] += 1e-6 * n as f64;
    }
    let Some(factor) = normal.cholesky() else { return 0.0 };
    let explained: f64 = right.component_mul(&factor.solve(&right)).sum();
    explained / total.max(1e-300)
}
