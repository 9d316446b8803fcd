//! The paper's simulation, eq. (16), beside the paper's own result, eq. (17).

use super::solvers::{SOLVERS, solve};
use ironout_simulation::paper::{Sampler, Truth, eq_16, eq_17};
use nalgebra::Vector3;

/// One line: rms errors of the offset and of the matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Noise on each axis, fields.
    pub sigma: f64,
    /// Samples.
    pub n: usize,
    /// The method.
    pub who: &'static str,
    /// Rms of ‖b̂ − b‖, fields; `None` where every log was refused.
    pub b: Option<f64>,
    /// Rms of ‖Â − A‖.
    pub a: Option<f64>,
    /// Part of the logs that were refused.
    pub refused: f64,
}

/// Counts in a field: the simulated sensor's steps are far below its noise.
const COUNTS_PER_FIELD: f64 = 8000.0;

/// All lines; the last is the paper's own estimate.
pub fn rows(seeds: u64) -> Vec<Row> {
    let truth = eq_16();
    let mut rows = vec![];
    for (sigma, n) in [(0.01, 500), (0.05, 500), (0.05, 5000), (0.05f64.sqrt(), 5000)] {
        let mut sums = [(0.0, 0.0, 0u64); SOLVERS.len()];
        for seed in 0..seeds {
            let samples = truth.samples(&mut Sampler::new(1000 + seed), n, sigma, Vector3::z(), 1.0);
            let counts: Vec<[i16; 3]> =
                samples.iter().map(|s| s.map(|v| (v * COUNTS_PER_FIELD).round() as i16)).collect();
            for (solver, (b, a, solved)) in SOLVERS.iter().zip(&mut sums) {
                let Some(found) = solve(*solver, &counts, 1.0 / COUNTS_PER_FIELD, 1.0) else { continue };
                let Some(inverse) = found.c.try_inverse() else { continue };
                *b += (found.b - truth.b).norm_squared();
                *a += (inverse - truth.a).norm_squared();
                *solved += 1;
            }
        }
        rows.extend(SOLVERS.iter().zip(sums).map(|(solver, (b, a, solved))| {
            let rms = |sum: f64| (solved > 0).then(|| (sum / solved as f64).sqrt());
            let refused = 1.0 - solved as f64 / seeds as f64;
            Row { sigma, n, who: solver.name(), b: rms(b), a: rms(a), refused }
        }));
        // The bound of the two parts together says what there is to be had.
        rows.push(Row { sigma, n, who: "bound", b: None, a: Some(bound(&truth, n, sigma)), refused: 0.0 });
    }
    let own = eq_17();
    rows.push(Row {
        sigma: 0.05f64.sqrt(),
        n: 0,
        who: "eq. (17)",
        b: Some((own.b - truth.b).norm()),
        a: Some((own.a - truth.a).norm()),
        refused: 0.0,
    });
    rows
}

fn bound(truth: &Truth, n: usize, sigma: f64) -> f64 {
    truth.bound(n, sigma, Vector3::z(), 1.0)
}

fn number(value: Option<f64>) -> String {
    value.map_or("refused".into(), |v| format!("{v:.4}"))
}

/// As a table.
pub fn text(rows: &[Row]) -> String {
    let mut text = String::from("noise    samples  method       |b^-b|   |A^-A|  refused\n");
    for r in rows {
        let n = if r.n > 0 { r.n.to_string() } else { "?".into() };
        let b = if r.who == "bound" { "both".into() } else { number(r.b) };
        text += &format!(
            "{:<8.4} {:>7}  {:<10} {:>8} {:>8} {:>7.0} %\n",
            r.sigma,
            n,
            r.who,
            b,
            number(r.a),
            r.refused * 100.0
        );
    }
    text
}
