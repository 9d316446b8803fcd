//! Samples that no model of the sensor can explain: clipped ones, and gross outliers of the fit.
//!
//! They are set aside before anything is concluded, counted, and reported. Structure is not a fault: if more than
//! [`MOST`] of the samples would go, none goes.

use super::{Data, fit_rows};
use ironout::calibration::norm;
use ironout::fit::{FitOptions, FitReport};

/// Residuals beyond this many robust standard deviations are gross.
const GROSS: f64 = 5.0;
/// Of a normal distribution, σ over the median absolute deviation.
const SIGMA_PER_MAD: f64 = 1.4826;
/// More than this share is not a fault of single samples.
const MOST: f64 = 0.15;
/// Rounds of fit and test.
const ROUNDS: usize = 12;
/// A clipped axis sits at its extreme at least this often, …
const CLIPPED_SAMPLES: usize = 10;
/// … and this many times as often as at the levels next to it.
const CLIPPED_RATIO: f64 = 8.0;
/// Levels next to the extreme that are compared with it.
const NEXT_LEVELS: f64 = 10.0;

/// Why a sample was set aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The axis was at the end of its range.
    Clipping {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// The corrected magnitude was far from all others: a magnet passing, a corrupted reading.
    Outlier,
    /// The reading stood still while the board turned.
    Stuck,
}

/// What was set aside, with the reason.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SetAside {
    /// Samples and reasons, in the order of the samples.
    pub samples: Vec<(u32, FaultKind)>,
    /// Set where outliers were so many that they were kept.
    pub too_many: Option<usize>,
}

/// Divides `samples` into those to use and those set aside.
pub fn set_aside(data: &Data, samples: &[u32], options: &FitOptions) -> (Vec<u32>, SetAside) {
    let clipped = clipped(data, samples);
    let is_clipped = |sample: &u32| clipped.iter().find(|(at, _)| at == sample);
    let candidates: Vec<u32> = if clipped.is_empty() { samples.to_vec() } else { without(samples, &clipped) };
    let (mut used, too_many) = without_outliers(data, &candidates, options);
    let mut aside = SetAside { samples: Vec::new(), too_many };
    if !clipped.is_empty() && !clipping_shows(data, &used, &clipped, options) {
        // The extreme is where the sensor rested longest, not the end of its range.
        let (all, too_many) = without_outliers(data, samples, options);
        used = all;
        aside.too_many = too_many;
    }
    let mut kept = used.iter().peekable();
    for sample in samples {
        if kept.peek() == Some(&sample) {
            kept.next();
        } else {
            let kind = is_clipped(sample)
                .map_or(FaultKind::Outlier, |(_, axis)| FaultKind::Clipping { axis: *axis });
            aside.samples.push((*sample, kind));
        }
    }
    (used, aside)
}

fn without(samples: &[u32], aside: &[(u32, usize)]) -> Vec<u32> {
    let mut aside = aside.iter().peekable();
    let mut kept = Vec::with_capacity(samples.len());
    for sample in samples {
        while aside.next_if(|(at, _)| at < sample).is_some() {}
        if aside.peek().is_none_or(|(at, _)| at != sample) {
            kept.push(*sample);
        }
    }
    kept
}

/// Samples at an extreme value of an axis that occurs far more often than its neighbours.
fn clipped(data: &Data, samples: &[u32]) -> Vec<(u32, usize)> {
    let mut found = Vec::new();
    for axis in 0..3 {
        let value = |sample: &u32| data.field(*sample)[axis];
        let low = samples.iter().map(value).fold(f64::INFINITY, f64::min);
        let high = samples.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
        if low >= high {
            // Never moved: that is not the end of a range.
            continue;
        }
        let band = data.step_ut[axis] * (NEXT_LEVELS + 0.5);
        for extreme in [low, high] {
            let at: Vec<u32> = samples.iter().copied().filter(|sample| value(sample) == extreme).collect();
            let near =
                samples.iter().filter(|s| value(s) != extreme && (value(s) - extreme).abs() <= band).count();
            if at.len() >= CLIPPED_SAMPLES && at.len() as f64 > CLIPPED_RATIO * near as f64 / NEXT_LEVELS {
                found.extend(at.into_iter().map(|sample| (sample, axis)));
            }
        }
    }
    found.sort_unstable_by_key(|(sample, _)| *sample);
    found.dedup_by_key(|(sample, _)| *sample);
    found
}

/// A clipped reading is shorter than the true one or longer, but off to one side: whether the supposedly clipped
/// samples disagree with the fit of the others.
fn clipping_shows(data: &Data, used: &[u32], clipped: &[(u32, usize)], options: &FitOptions) -> bool {
    let Ok(report) = fit_rows(data, used, options) else { return true };
    let spread = spread(&mut data.residual(used, &report.calibration)).1;
    let samples: Vec<u32> = clipped.iter().map(|(sample, _)| *sample).collect();
    let mut residual = data.residual(&samples, &report.calibration);
    residual.iter_mut().for_each(|r| *r = r.abs());
    median(&mut residual) > 2.0 * spread
}

/// Refits without gross outliers until the same samples remain. Nine parameters where they can be had: a lower order
/// would call the difference between the axes an outlier.
fn without_outliers(data: &Data, samples: &[u32], options: &FitOptions) -> (Vec<u32>, Option<usize>) {
    let full = FitOptions { lower_orders: false, ..*options };
    let refit =
        |samples: &[u32]| fit_rows(data, samples, &full).or_else(|_| fit_rows(data, samples, options)).ok();
    let Some(mut report) = start(data, samples, refit) else { return (samples.to_vec(), None) };
    let step = data.step_ut.iter().copied().fold(0.0, f64::max);
    let mut used = samples.to_vec();
    for _ in 0..ROUNDS {
        let residual = data.residual(samples, &report.calibration);
        let (middle, sigma) = spread(&mut residual.clone());
        // A spread below the sensor's step says nothing about single samples.
        let limit = GROSS * sigma.max(step / 2.0);
        let kept: Vec<u32> = samples
            .iter()
            .zip(&residual)
            .filter(|(_, r)| (*r - middle).abs() <= limit)
            .map(|(s, _)| *s)
            .collect();
        if (kept.len() as f64) < (1.0 - MOST) * samples.len() as f64 {
            return (samples.to_vec(), Some(samples.len() - kept.len()));
        }
        let settled = kept == used;
        used = kept;
        if settled {
            break;
        }
        match refit(&used) {
            Some(better) => report = better,
            None => break,
        }
    }
    (used, None)
}

/// A first fit, of what is not suspicious: neither far from the middle of everything nor far from its neighbours in time. A
/// single wild reading would turn the fit of everything into nonsense, and then all others into outliers. What is left
/// out here by mistake comes back in the rounds that follow.
fn start(data: &Data, samples: &[u32], refit: impl Fn(&[u32]) -> Option<FitReport>) -> Option<FitReport> {
    let values: Vec<[f64; 3]> = samples.iter().map(|s| data.field(*s)).collect();
    let middle = [0, 1, 2].map(|axis| median(&mut values.iter().map(|v| v[axis]).collect::<Vec<_>>()));
    let between = |a: [f64; 3], b: [f64; 3]| norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    let far: Vec<f64> = values.iter().map(|v| between(*v, middle)).collect();
    let far_limit = 4.0 * median(&mut far.clone());
    let jumps: Vec<f64> = (0..values.len())
        .map(|at| {
            let near = &values[at.saturating_sub(2)..(at + 3).min(values.len())];
            let local = [0, 1, 2].map(|axis| median(&mut near.iter().map(|v| v[axis]).collect::<Vec<_>>()));
            between(values[at], local)
        })
        .collect();
    let step = norm(data.step_ut);
    let jump_limit = 8.0 * median(&mut jumps.clone()).max(step);
    let quiet: Vec<u32> = (0..samples.len())
        .filter(|&i| far[i] <= far_limit && jumps[i] <= jump_limit)
        .map(|i| samples[i])
        .collect();
    let enough = quiet.len() as f64 >= (1.0 - 2.0 * MOST) * samples.len() as f64;
    enough.then(|| refit(&quiet)).flatten().or_else(|| refit(samples))
}

/// Median and robust standard deviation.
fn spread(values: &mut [f64]) -> (f64, f64) {
    let middle = median(values);
    values.iter_mut().for_each(|value| *value = (*value - middle).abs());
    (middle, SIGMA_PER_MAD * median(values))
}

fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let half = values.len() / 2;
    *values.select_nth_unstable_by(half, f64::total_cmp).1
}
