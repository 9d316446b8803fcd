//! Whether a log is of a board at rest.

use crate::base::start::sphere;
use crate::bounds::{
    EXPLAINED_AT_REST, NOISE_AT_REST, RESTING_RADPS, RESTING_TILT, RESTING_TURN_RAD, ROUND, ROUND_NOISES,
};
use crate::samples::samples::Samples;
use crate::samples::series::{median, rms, second_difference_sigma};
use nalgebra::{DMatrix, DVector};

/// A turn is summed over so long, s: less than the drift of a gyro's zero makes anything of.
const TURN_TIME_S: f64 = 10.0;

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
    let is_line = || !goes_round(samples) || told_by_columns(samples);
    if enough(downs.len()) {
        let is_still = |turns| slow(turns) && turned_rad(samples) < RESTING_TURN_RAD;
        return tilt(&downs) < RESTING_TILT && if enough(turns.len()) { is_still(turns) } else { is_line() };
    }
    if enough(turns.len()) {
        // Without a time column the unit of the gyro cannot be checked against the field.
        let is_still = || match samples.time {
            Some(_) => turned_rad(samples) < RESTING_TURN_RAD,
            None => is_line(),
        };
        return slow(turns) && is_still();
    }
    told_by_columns(samples)
}

fn slow(mut turns: Vec<f64>) -> bool {
    median(&mut turns) < RESTING_RADPS
}

/// Rms of the turns that the gyro sums up, beyond its zero rate, rad; 0 without time.
fn turned_rad(samples: &Samples) -> f64 {
    let Some(time) = &samples.time else { return 0.0 };
    let rate = |axis: usize| samples.readings.iter().filter_map(move |r| Some(r.turn_radps?[axis]));
    let zero = [0, 1, 2].map(|axis| median(&mut rate(axis).collect::<Vec<_>>()));
    let (mut angle, mut squares) = ([0.0; 3], 0.0);
    for (at, reading) in samples.readings.iter().enumerate().skip(1) {
        let step_s = (time[at] - time[at - 1]).clamp(0.0, 1.0);
        let fade = (-step_s / TURN_TIME_S).exp();
        let rate = reading.turn_radps.unwrap_or(zero);
        angle = [0, 1, 2].map(|axis| angle[axis] * fade + (rate[axis] - zero[axis]) * step_s);
        squares += angle.iter().map(|a| a * a).sum::<f64>();
    }
    (squares / samples.len().max(1) as f64).sqrt()
}

/// Whether the readings spread in a plane or further, as those of a level board that is turned: one cause moves them along a line.
fn goes_round(samples: &Samples) -> bool {
    let mean = nalgebra::Vector3::from(samples.mean_vector());
    let off = |m: [f64; 3]| nalgebra::Vector3::from(m) - mean;
    let scatter: nalgebra::Matrix3<f64> = samples
        .readings
        .iter()
        .map(|reading| off(reading.measured_ut))
        .map(|off| off * off.transpose())
        .sum();
    let mut spread =
        scatter.symmetric_eigenvalues().map(|value| (value.max(0.0) / samples.len().max(1) as f64).sqrt());
    spread.as_mut_slice().sort_by(f64::total_cmp);
    let axis = |axis: usize| samples.readings.iter().map(move |reading| reading.measured_ut[axis]);
    let noise = (0..3).map(|i| second_difference_sigma(&axis(i).collect::<Vec<f64>>())).fold(0.0, f64::max);
    spread[1] > ROUND * spread[2] && spread[1] > ROUND_NOISES * noise
}

fn tilt(downs: &[[f64; 3]]) -> f64 {
    let n = downs.len() as f64;
    let mean = [0, 1, 2].map(|axis| downs.iter().map(|d| d[axis]).sum::<f64>() / n);
    (downs.iter().map(|d| (0..3).map(|axis| (d[axis] - mean[axis]).powi(2)).sum::<f64>()).sum::<f64>() / n)
        .sqrt()
}

/// Whether covariates explain most of the measured vector's variance, if it stays within less than half of its own length, and
/// more than a sphere does: slow columns meet a slow motion by chance, and an offset makes any vector long.
fn told_by_columns(samples: &Samples) -> bool {
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
        return false;
    }
    let scales: Vec<f64> = columns
        .iter()
        .map(|column| (column.mean_square - column.mean * column.mean).max(1e-300).sqrt())
        .collect();
    let k = 2 * columns.len();
    let mut normal = DMatrix::<f64>::zeros(k, k);
    let mut right = DMatrix::<f64>::zeros(k, 3);
    let mut total = 0.0;
    let regressors = |sample: usize| {
        DVector::from_iterator(
            k,
            columns.iter().zip(&scales).flat_map(|(column, scale)| {
                let value = (column.values[sample] - column.mean) / scale;
                [value, value * value - 1.0]
            }),
        )
    };
    for sample in 0..n {
        let row = regressors(sample);
        let off =
            nalgebra::RowVector3::from_fn(|_, axis| samples.readings[sample].measured_ut[axis] - mean[axis]);
        normal += &row * row.transpose();
        right += &row * off;
        total += off.norm_squared();
    }
    for i in 0..k {
        normal[(i, i)] += 1e-6 * n as f64;
    }
    let Some(factor) = normal.cholesky() else { return false };
    let found = factor.solve(&right);
    if right.component_mul(&found).sum() <= EXPLAINED_AT_REST * total {
        return false;
    }
    let left: Vec<[f64; 3]> = (0..n)
        .map(|sample| {
            let row = &found.tr_mul(&regressors(sample));
            [0, 1, 2].map(|axis| samples.readings[sample].measured_ut[axis] - mean[axis] - row[axis])
        })
        .collect();
    let per_axis = |axis: usize| left.iter().map(|vector| vector[axis]).collect::<Vec<f64>>();
    let axes = [0, 1, 2].map(per_axis);
    let rms_of = |of: fn(&[f64]) -> f64| axes.iter().map(|axis| of(axis).powi(2)).sum::<f64>().sqrt();
    let (left, noise) = (rms_of(rms), rms_of(second_difference_sigma));
    left < NOISE_AT_REST * noise || left / 3.0_f64.sqrt() < beside_a_sphere(samples)
}

/// Rms of the readings' distance from the sphere that fits them best, µT.
fn beside_a_sphere(samples: &Samples) -> f64 {
    let Some((centre, radius)) = sphere(samples) else { return f64::INFINITY };
    let off = |m: [f64; 3]| (0..3).map(|axis| (m[axis] - centre[axis]).powi(2)).sum::<f64>().sqrt() - radius;
    rms(&samples.readings.iter().map(|reading| off(reading.measured_ut)).collect::<Vec<f64>>())
}
