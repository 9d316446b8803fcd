//! Errors over the Cramér–Rao bound, bias and honesty of the standard errors, over noise × samples × coverage × hard iron.

use super::solvers::{SOLVERS, Solver, solve};
use ironout_simulation::paper::{Sampler, Truth};
use nalgebra::{SVector, Vector3};

/// One cell of the sweep; lengths in fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Noise on each axis.
    pub sigma: f64,
    /// Samples.
    pub n: usize,
    /// Part of the sphere covered: a cap.
    pub coverage: f64,
    /// Length of the offset.
    pub hard_iron: f64,
}

/// What a solver makes of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Rms norm of the error of the nine numbers b, A over the bound.
    pub over_bound: f64,
    /// Norm of their mean error over the bound.
    pub bias: f64,
    /// Fraction of the errors of b and C that are inside one standard error, where there are any.
    pub inside: Option<f64>,
    /// Fraction of the logs that were refused.
    pub refused: f64,
}

/// The sweep: each parameter varied about a middle case.
pub fn cells() -> Vec<Cell> {
    let middle = Cell { sigma: 0.01, n: 2000, coverage: 1.0, hard_iron: 0.5 };
    let mut cells = vec![];
    for sigma in [0.001, 0.003, 0.01, 0.03, 0.05] {
        cells.push(Cell { sigma, ..middle });
    }
    for n in [100, 500, 10_000] {
        cells.push(Cell { n, ..middle });
    }
    for coverage in [0.7, 0.5, 0.35, 0.25, 0.15] {
        cells.push(Cell { coverage, ..middle });
        cells.push(Cell { coverage, sigma: 0.003, ..middle });
    }
    for hard_iron in [0.0, 1.0, 2.0, 5.0] {
        cells.push(Cell { hard_iron, ..middle });
        cells.push(Cell { hard_iron, coverage: 0.5, ..middle });
    }
    cells
}

/// Counts in a field: a 16-bit sensor of 0.025 µT a count in 50 µT.
const COUNTS_PER_FIELD: f64 = 2000.0;

/// Runs a cell over `seeds` logs. The truth is one for the cell, so that a bias shows; soft iron within 10 %.
pub fn run(cell: &Cell, seeds: u64) -> Vec<(Solver, Accuracy)> {
    let mut sampler = Sampler::new(0x51ee);
    let mut truth = sampler.mild_truth(0.1);
    truth.b = sampler.direction(Vector3::z(), 1.0) * cell.hard_iron;
    let pole = sampler.direction(Vector3::z(), 1.0);
    let bound = truth.bound(cell.n, cell.sigma, pole, cell.coverage);
    let c = truth.a.try_inverse().expect("the truth is invertible");
    let mut sums = vec![(0.0, SVector::<f64, 9>::zeros(), 0usize, 0usize, 0usize); SOLVERS.len()];
    for seed in 0..seeds {
        let mut sampler = Sampler::new(0xacc0 + seed);
        let counts: Vec<[i16; 3]> = truth
            .samples(&mut sampler, cell.n, cell.sigma, pole, cell.coverage)
            .iter()
            .map(|s| s.map(|v| (v * COUNTS_PER_FIELD).round() as i16))
            .collect();
        for (solver, (square, mean, inside, total, solved)) in SOLVERS.iter().zip(&mut sums) {
            let Some(found) = solve(*solver, &counts, 1.0 / COUNTS_PER_FIELD, 1.0) else { continue };
            let Some(a) = found.c.try_inverse() else { continue };
            let error = Truth { b: found.b, a }.nine() - truth.nine();
            *solved += 1;
            *square += error.norm_squared();
            *mean += error;
            if let Some((sb, sc)) = found.std_errors {
                for i in 0..3 {
                    *inside += usize::from((found.b[i] - truth.b[i]).abs() < sb[i]);
                    for k in i..3 {
                        *inside += usize::from((found.c[(i, k)] - c[(i, k)]).abs() < sc[(i, k)]);
                    }
                }
                *total += 9;
            }
        }
    }
    SOLVERS
        .iter()
        .zip(sums)
        .map(|(solver, (square, mean, inside, total, solved))| {
            let n = solved.max(1) as f64;
            let accuracy = Accuracy {
                over_bound: (square / n).sqrt() / bound,
                bias: mean.norm() / n / bound,
                inside: (total > 0).then(|| inside as f64 / total as f64),
                refused: 1.0 - solved as f64 / seeds as f64,
            };
            (*solver, accuracy)
        })
        .collect()
}
