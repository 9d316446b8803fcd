//! Columns that cause nothing: what else a logger writes, and what moves with a true cause.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What a column that causes nothing does.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoy {
    /// A random walk: a pressure, a counter's drift.
    Walk,
    /// A mode: whole numbers, each for a while.
    Mode,
    /// A switch: off or on.
    Switch,
    /// A battery that sags as it empties and under loads of its own.
    Battery,
    /// It moves with another column, with this correlation.
    Alike {
        /// The other column.
        column: String,
        /// Their correlation.
        correlation: f64,
    },
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Zero mean, unit variance; all zeros where nothing changes.
fn standardised(values: &[f64]) -> Vec<f64> {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    values.iter().map(|v| if spread > 0.0 { (v - mean) / spread } else { 0.0 }).collect()
}

/// Levels from `0` to `levels - 1`, each held for some seconds.
fn held(
    levels: u32,
    rows: usize,
    row_s: f64,
    seconds: core::ops::Range<f64>,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let mut out = Vec::with_capacity(rows);
    let mut level = rng.random_range(0..levels);
    while out.len() < rows {
        let stay = (rng.random_range(seconds.clone()) / row_s).max(1.0) as usize;
        out.extend(core::iter::repeat_n(f64::from(level), stay.min(rows - out.len())));
        level = (level + rng.random_range(1..levels)) % levels;
    }
    out
}

/// A random walk without its mean.
fn walk(rows: usize, row_s: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut at = 0.0;
    (0..rows)
        .map(|_| {
            at += row_s.sqrt() * normal(rng);
            at
        })
        .collect()
}

impl Decoy {
    /// Its values beside `other`, the column that it moves with.
    pub(crate) fn values(
        &self,
        rows: usize,
        row_s: f64,
        other: Option<&[f64]>,
        rng: &mut ChaCha8Rng,
    ) -> Vec<f64> {
        match self {
            Decoy::Walk => walk(rows, row_s, rng),
            Decoy::Mode => held(4, rows, row_s, 3.0..20.0, rng),
            Decoy::Switch => held(2, rows, row_s, 2.0..15.0, rng),
            Decoy::Battery => {
                let load = held(3, rows, row_s, 1.5..8.0, rng);
                let sag = rng.random_range(0.5..1.5);
                (0..rows)
                    .map(|row| {
                        let spent = row as f64 / rows.max(1) as f64;
                        12.6 - sag * spent - 0.15 * load[row] + 0.01 * normal(rng)
                    })
                    .collect()
            }
            Decoy::Alike { correlation, .. } => {
                let own = match rng.random_range(0..2) {
                    0 => standardised(&held(5, rows, row_s, 1.5..7.0, rng)),
                    _ => standardised(&walk(rows, row_s, rng)),
                };
                let other = standardised(other.unwrap_or_default());
                let rest = (1.0 - correlation * correlation).max(0.0).sqrt();
                own.iter().zip(&other).map(|(own, other)| correlation * other + rest * own).collect()
            }
        }
    }
}

/// Empties cells of a column in stretches of 0.2 to 4 s, until `share` of it is missing.
pub(crate) fn empty(column: &mut [f64], share: f64, row_s: f64, rng: &mut ChaCha8Rng) {
    let rows = column.len();
    let wanted = (share.clamp(0.0, 0.9) * rows as f64) as usize;
    let mut missing = column.iter().filter(|value| value.is_nan()).count();
    while missing < wanted {
        let length = ((rng.random_range(0.2..4.0) / row_s) as usize).clamp(1, rows);
        let from = rng.random_range(0..rows);
        for value in &mut column[from..(from + length).min(rows)] {
            missing += usize::from(!value.is_nan());
            *value = f64::NAN;
        }
    }
}
