//! How a turning board shows the noise of its sensor.
//!
//! The magnitude sees the noise along the field. So its memory is that of the noise times how alike the directions are
//! then and now, and what a fit of offset and matrix takes out of it lies where the directions and their products vary.

use crate::noise::power::{add_power, padded, transforms};
use crate::samples::fft;
use ironout::calibration::{Calibration, norm};
use nalgebra::DMatrix;

/// A resting board reads the field to this share of it.
const NEAR: f64 = 0.2;

/// The directions of a log as its noise meets them.
#[derive(Debug, Clone)]
pub struct Turning {
    /// Sum of the products of directions `k` samples apart, over their number.
    pub alike: Vec<f64>,
    /// Share of white noise that a fit of offset and matrix takes out, by bin of the half spectrum.
    pub absorbed: Vec<f64>,
    /// Whether the residual is that of a magnitude on a board that turns.
    pub of_magnitude: bool,
    /// By how much each axis of the sensor shows in each residual; empty where nothing turns.
    pub weights: Vec<[f64; 3]>,
    /// Residuals of the resting board, in stretches of as many samples a second.
    pub rest: Vec<Rest>,
}

/// A stretch in which the board rested.
#[derive(Debug, Clone)]
pub struct Rest {
    /// Residuals.
    pub residuals: Vec<f64>,
    /// How the variance of the sensor's axes shows in them.
    pub gain: f64,
}

impl Turning {
    /// Where nothing turns: a residual that is no magnitude.
    pub fn none(n: usize) -> Self {
        let alike = (0..n).map(|lag| 1.0 - lag as f64 / n.max(1) as f64).collect();
        Turning {
            alike,
            absorbed: vec![0.0; padded(n) / 2 + 1],
            of_magnitude: false,
            weights: Vec::new(),
            rest: Vec::new(),
        }
    }

    /// Of the field's directions in the frame of the board, one a sample (of any length but zero), and the matrix that brings
    /// readings there.
    pub fn of(directions: impl Iterator<Item = [f64; 3]>, matrix: &[[f64; 3]; 3]) -> Self {
        let units: Vec<[f64; 3]> = directions
            .map(|v| {
                let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                if norm > 0.0 && norm.is_finite() { v.map(|x| x / norm) } else { [0.0; 3] }
            })
            .collect();
        let weights: Vec<[f64; 3]> = units
            .iter()
            .map(|u| std::array::from_fn(|j| (0..3).map(|i| matrix[i][j] * u[i]).sum()))
            .collect();
        let n = units.len();
        let size = padded(n);
        let axes = |list: &[[f64; 3]]| -> Vec<Vec<f64>> {
            (0..3).map(|i| list.iter().map(|u| u[i]).collect()).collect()
        };
        let alike = alike(&axes(&weights), n);
        let mut columns = axes(&units);
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            columns.push(units.iter().map(|u| u[i] * u[j]).collect());
        }
        let mut absorbed = vec![0.0; size / 2 + 1];
        add_power(&mut absorbed, &transforms(&orthogonal(columns), size), n);
        Turning { alike, absorbed, of_magnitude: true, weights, rest: Vec::new() }
    }

    /// The same beside readings of the resting board, of which every `stride`th is of the series, as a calibration shows them.
    pub fn beside(mut self, rest: &[Vec<[f64; 3]>], stride: usize, calibration: &Calibration<f64>) -> Self {
        let of = |stretch: &Vec<[f64; 3]>| {
            let fields = || stretch.iter().step_by(stride.max(1)).map(|reading| calibration.apply(*reading));
            let residuals: Vec<f64> = fields().map(|h| norm(h) - calibration.field_ut).collect();
            let gains = fields().map(|h| {
                let shown =
                    |axis: usize| (0..3).map(|i| calibration.matrix[i][axis] * h[i]).sum::<f64>() / norm(h);
                (0..3).map(|axis| shown(axis).powi(2)).sum::<f64>()
            });
            Rest { gain: gains.sum::<f64>() / residuals.len().max(1) as f64, residuals }
        };
        // Readings that are not of the field (a magnet beside the board, a sensor that is off) tell nothing of its noise.
        let is_of_the_field = |rest: &Rest| {
            let mean = rest.residuals.iter().sum::<f64>() / rest.residuals.len().max(1) as f64;
            mean.abs() < NEAR * calibration.field_ut && rest.gain.is_finite()
        };
        self.rest = rest.iter().map(of).filter(is_of_the_field).collect();
        self
    }
}

fn alike(axes: &[Vec<f64>], n: usize) -> Vec<f64> {
    let size = (2 * n).next_power_of_two();
    let mut power = vec![(0.0, 0.0); size];
    for axis in axes {
        let mut data: Vec<(f64, f64)> = axis.iter().map(|v| (*v, 0.0)).collect();
        data.resize(size, (0.0, 0.0));
        fft::forward(&mut data);
        for (sum, value) in power.iter_mut().zip(&data) {
            sum.0 += value.0 * value.0 + value.1 * value.1;
        }
    }
    fft::forward(&mut power);
    let whole = power.first().map_or(1.0, |first| first.0).max(f64::MIN_POSITIVE);
    power.iter().take(n).map(|value| value.0 / whole).collect()
}

/// Columns of length one that span the same, those that add nothing left out.
fn orthogonal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let p = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let normal = DMatrix::from_fn(p, p, |i, j| dot(&columns[i], &columns[j]));
    let eigen = normal.symmetric_eigen();
    let largest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
    let n = columns.first().map_or(0, Vec::len);
    (0..p)
        .filter(|k| eigen.eigenvalues[*k] > 1e-9 * largest)
        .map(|k| {
            let scale = eigen.eigenvalues[k].sqrt().recip();
            (0..n)
                .map(|t| (0..p).map(|i| columns[i][t] * eigen.eigenvectors[(i, k)]).sum::<f64>() * scale)
                .collect()
        })
        .collect()
}
