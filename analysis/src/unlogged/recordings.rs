//! Several recordings of one board: one matrix, and an offset for each.
//!
//! Gauss–Newton on the magnitude with the six entries of a symmetric matrix that all recordings share and three of an offset for each: the
//! offsets are eliminated block by block (Schur), so that the cost is linear in the recordings.

use crate::bounds::FEWEST_SAMPLES;
use crate::unlogged::linear::{BASE, Normal, Row, memory, one_and};
use ironout::study::f_tail;
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Steps of the Gauss–Newton iteration at most: it begins at the common calibration, next to its end.
const MOST_STEPS: usize = 30;
/// It has arrived when no offset moves by more, µT.
const STANDS_UT: f64 = 1e-7;

/// One recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Its place among those that were given, from 0.
    pub index: usize,
    /// Samples that were used.
    pub samples: usize,
    /// Its own offset less that of all together, in the sensor's axes, µT.
    pub offset_change_ut: [f64; 3],
    /// Standard errors of it, µT.
    pub std_errors_ut: [f64; 3],
    /// What its own offset leaves, rms, µT.
    pub rms_ut: f64,
}

/// All of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recordings {
    /// In their order; one with too few samples is missing.
    pub recordings: Vec<Recording>,
    /// The change of the offset from one to the next along a straight line through all, µT.
    pub per_recording_ut: [f64; 3],
    /// Standard errors of it with what scatters about the line, µT; `None` for two recordings, which always lie on one.
    pub per_recording_errors_ut: Option<[f64; 3]>,
    /// The error with one offset for all, rms, µT, …
    pub common_rms_ut: f64,
    /// … and with one for each.
    pub rms_ut: f64,
    /// p-value of the hypothesis that all recordings have one offset.
    pub p_value: f64,
}

/// The offsets of recordings. `corrected_ut` holds each recording's samples, corrected by one calibration of `field_ut` whose matrix is `matrix`. `None`
/// where fewer than two carry an offset.
pub fn offsets(corrected_ut: &[Vec<[f64; 3]>], matrix: &[[f64; 3]; 3], field_ut: f64) -> Option<Recordings> {
    let inverse = ironout::vector::inverse_3x3(matrix)?;
    let used: Vec<usize> =
        (0..corrected_ut.len()).filter(|&i| corrected_ut[i].len() >= FEWEST_SAMPLES).collect();
    if used.len() < 2 {
        return None;
    }
    let logs: Vec<&[[f64; 3]]> = used.iter().map(|&i| corrected_ut[i].as_slice()).collect();
    let common = solve(&logs, field_ut, false)?;
    let own = solve(&logs, field_ut, true)?;
    let n: f64 = logs.iter().map(|log| log.len() as f64).sum();
    let independent = n / own.memory;
    let (more, left) = (3.0 * (logs.len() - 1) as f64, independent - 6.0 - 3.0 * logs.len() as f64);
    if left < 1.0 {
        return None;
    }
    // Noise with a memory raises both squares alike; it is the degrees of freedom that it lowers.
    let f = ((common.squares - own.squares) / more) / (own.squares / left);
    let to_sensor = |v: [f64; 3]| inverse.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>());
    let variance = own.squares / (n - 6.0 - 3.0 * logs.len() as f64).max(1.0) * own.memory;
    let recordings: Vec<Recording> = (0..logs.len())
        .map(|at| {
            let change: [f64; 3] =
                std::array::from_fn(|axis| own.offsets[at][axis] - common.offsets[at][axis]);
            let covariance = own.covariances[at] * variance;
            let in_sensor = |axis: usize| {
                let row = SVector::<f64, 3>::from(inverse[axis]);
                (row.dot(&(covariance * row))).max(0.0).sqrt()
            };
            Recording {
                index: used[at],
                samples: logs[at].len(),
                offset_change_ut: to_sensor(change),
                std_errors_ut: std::array::from_fn(in_sensor),
                rms_ut: (own.own_squares[at] / logs[at].len() as f64).sqrt(),
            }
        })
        .collect();
    let (per_recording_ut, per_recording_errors_ut) = line(&recordings);
    Some(Recordings {
        recordings,
        per_recording_ut,
        per_recording_errors_ut,
        common_rms_ut: (common.squares / n).sqrt(),
        rms_ut: (own.squares / n).sqrt(),
        p_value: f_tail(f.max(0.0), more, left),
    })
}

/// The weighted line through the offsets over their place, and the errors of its slope.
fn line(recordings: &[Recording]) -> ([f64; 3], Option<[f64; 3]>) {
    let mut slope = [0.0; 3];
    let mut errors = [0.0; 3];
    for axis in 0..3 {
        let points: Vec<[f64; 3]> = recordings
            .iter()
            .map(|one| {
                let error = one.std_errors_ut[axis].max(1e-12);
                [one.index as f64, one.offset_change_ut[axis], 1.0 / (error * error)]
            })
            .collect();
        let weight: f64 = points.iter().map(|[_, _, w]| w).sum();
        let mean = |of: usize| points.iter().map(|point| point[2] * point[of]).sum::<f64>() / weight;
        let (x, y) = (mean(0), mean(1));
        let spread: f64 = points.iter().map(|[a, _, w]| w * (a - x) * (a - x)).sum();
        slope[axis] = points.iter().map(|[a, b, w]| w * (a - x) * (b - y)).sum::<f64>() / spread;
        let left: f64 = points
            .iter()
            .map(|[a, b, w]| {
                let off = b - y - slope[axis] * (a - x);
                w * off * off
            })
            .sum();
        // Where offsets scatter about the line by more than their errors, the scatter counts.
        let free = points.len().saturating_sub(2).max(1) as f64;
        errors[axis] = ((left / free).max(1.0) / spread).sqrt();
    }
    (slope, (recordings.len() > 2).then_some(errors))
}

struct Solved {
    offsets: Vec<[f64; 3]>,
    /// Covariances of the offsets, the matrix projected out, in units of the residual's variance.
    covariances: Vec<SMatrix<f64, 3, 3>>,
    squares: f64,
    own_squares: Vec<f64>,
    memory: f64,
}

/// The least squares, with an offset for each recording or one for all.
fn solve(logs: &[&[[f64; 3]]], field_ut: f64, each: bool) -> Option<Solved> {
    let mut shared = SMatrix::<f64, 3, 3>::identity();
    let mut offsets = vec![[0.0; 3]; logs.len()];
    for _ in 0..MOST_STEPS {
        let normals = sums(logs, &shared, &offsets, field_ut);
        let (step, own) = step(&normals, each)?;
        let mut largest = 0.0_f64;
        let change = one_and(step.into());
        // h' = (1 + S)(C (x − b) ) − d: the offset stands behind the matrix, and moves with it.
        shared = change * shared;
        for (offset, own) in offsets.iter_mut().zip(&own) {
            let turned = change * SVector::from(*offset) + own;
            largest = largest.max((turned - SVector::from(*offset)).amax());
            *offset = turned.into();
        }
        if largest < STANDS_UT {
            break;
        }
    }
    let normals = sums(logs, &shared, &offsets, field_ut);
    let residuals = |at: usize| {
        let (shared, offset) = (shared, offsets[at]);
        let log = logs[at];
        log.iter().filter_map(move |h| Some(row(*h, &shared, &offset, field_ut)?.residual_ut))
    };
    let memories = (0..logs.len())
        .map(|at| memory(residuals(at).collect::<Vec<_>>().into_iter()) * logs[at].len() as f64);
    let n: f64 = logs.iter().map(|log| log.len() as f64).sum();
    let memory = memories.sum::<f64>() / n;
    let covariances = covariances(&normals)?;
    let own_squares: Vec<f64> = normals.iter().map(|normal| normal.squares).collect();
    // Back into the axes before the shared matrix: the offset of the vectors that were given.
    let back = shared.try_inverse()?;
    Some(Solved {
        offsets: offsets.iter().map(|offset| (back * SVector::from(*offset)).into()).collect(),
        covariances: covariances.iter().map(|c| back * c * back.transpose()).collect(),
        squares: own_squares.iter().sum(),
        own_squares,
        memory,
    })
}

fn row(h: [f64; 3], shared: &SMatrix<f64, 3, 3>, offset: &[f64; 3], field_ut: f64) -> Option<Row> {
    let h = shared * SVector::from(h) - SVector::from(*offset);
    Row::of(h.into(), field_ut)
}

fn sums(
    logs: &[&[[f64; 3]]],
    shared: &SMatrix<f64, 3, 3>,
    offsets: &[[f64; 3]],
    field_ut: f64,
) -> Vec<Normal<BASE>> {
    let of = |(log, offset): (&&[[f64; 3]], &[f64; 3])| {
        let mut normal = Normal::<BASE>::default();
        for row in log.iter().filter_map(|h| row(*h, shared, offset, field_ut)) {
            normal.add(&row.base, row.residual_ut);
        }
        normal
    };
    logs.iter().zip(offsets).map(of).collect()
}

/// One step: of the shared matrix, and of each offset.
fn step(normals: &[Normal<BASE>], each: bool) -> Option<(SVector<f64, 6>, Vec<SVector<f64, 3>>)> {
    if !each {
        let mut all = Normal::<BASE>::default();
        for normal in normals {
            all.matrix += normal.matrix;
            all.right += normal.right;
            all.squares += normal.squares;
        }
        let (step, _) = all.solve()?;
        let own = step.fixed_rows::<3>(0).into_owned();
        return Some((step.fixed_rows::<6>(3).into_owned(), vec![own; normals.len()]));
    }
    let (shared, blocks) = eliminated(normals)?;
    let (step, _) = shared.solve()?;
    let own = blocks.iter().map(|block| -block.inverse * (block.right + block.cross * step)).collect();
    Some((step, own))
}

/// The normal equations of one recording's offset, and how they hang on the matrix.
pub(super) struct Block {
    inverse: SMatrix<f64, 3, 3>,
    cross: SMatrix<f64, 3, 6>,
    right: SVector<f64, 3>,
}

impl Block {
    /// What this offset takes off the squares while the matrix stays.
    pub(super) fn taken(&self) -> f64 {
        self.right.dot(&(self.inverse * self.right))
    }
}

/// The normal equations of the matrix with the offsets eliminated, and what gives these back.
pub(super) fn eliminated(normals: &[Normal<BASE>]) -> Option<(Normal<6>, Vec<Block>)> {
    let mut shared = Normal::<6>::default();
    let mut blocks = Vec::with_capacity(normals.len());
    for normal in normals {
        let mut full = normal.matrix;
        full.fill_lower_triangle_with_upper_triangle();
        let inverse = full.fixed_view::<3, 3>(0, 0).into_owned().cholesky()?.inverse();
        let cross = full.fixed_view::<3, 6>(0, 3).into_owned();
        let right = normal.right.fixed_rows::<3>(0).into_owned();
        shared.matrix += full.fixed_view::<6, 6>(3, 3) - cross.transpose() * inverse * cross;
        shared.right += normal.right.fixed_rows::<6>(3) - cross.transpose() * inverse * right;
        blocks.push(Block { inverse, cross, right });
    }
    Some((shared, blocks))
}

/// Covariances of the offsets with the matrix unknown.
fn covariances(normals: &[Normal<BASE>]) -> Option<Vec<SMatrix<f64, 3, 3>>> {
    let (shared, blocks) = eliminated(normals)?;
    let of_matrix = shared.inverse()?;
    let of = |Block { inverse, cross, .. }: &Block| {
        let gain = inverse * cross;
        inverse + gain * of_matrix * gain.transpose()
    };
    Some(blocks.iter().map(of).collect())
}
