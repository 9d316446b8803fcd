//! An offset that switches between two values: an LED, a charger, a relay that nobody logged.
//!
//! The residual is `r = J δ + (u·v) s(t) + noise` with a direction of sight u that is known, a vector v that is not, and a state s of 0 or 1. States
//! are found by dynamic programming (Viterbi) for a given v, and v with the base by least squares for given states, in turn,
//! from several beginnings. What competes with it is an offset that wanders (an Ornstein–Uhlenbeck process, one for each axis or along v): the
//! same filter, and as many parameters less as it has fewer changes.

use crate::bounds::MIN_ODDS;
use crate::unlogged::linear::{BASE, Normal, Row, base_columns, memory, one_and};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use serde::Serialize;

/// Base, and the vector.
const ALL: usize = BASE + 3;
/// Rounds of states and least squares.
const ROUNDS: usize = 16;
/// Samples of a log that are looked at.
const MOST_SAMPLES: usize = 20_000;
/// Samples that the beginnings are tried on.
const MOST_BLOCKS: usize = 3000;
/// Sizes of the vector to begin with, in standard deviations of the residual: a vector that switches half of the time has two.
const SIZES: [f64; 3] = [1.0, 2.0, 4.0];
/// Fewer changes are steps, which have a name of their own.
const FEWEST_CHANGES: usize = 2;
/// Gauss–Newton steps to offsets that are linear in the samples' shares.
const STEPS: usize = 3;
/// Knots of an offset that changes steadily: up to twice as many as there can be jumps.
const KNOTS: [usize; 4] = [2, 4, 8, 16];
/// A state that lasts for fewer samples than this in the mean is a spike.
const FEWEST_SAMPLES: f64 = 3.0;

/// What switches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Switching {
    /// The offset while it is on less that while it is off, in the sensor's axes, µT. It is on for the smaller part of the log.
    pub offset_ut: [f64; 3],
    /// Standard errors of it, µT.
    pub std_errors_ut: [f64; 3],
    /// When it is on: from, to, s.
    pub on_s: Vec<[f64; 2]>,
    /// The share of the samples in which it is on.
    pub duty: f64,
    /// The error before, rms, µT, …
    pub before_rms_ut: f64,
    /// … and with it.
    pub rms_ut: f64,
    /// By how much −2 ln L, its parameters paid for, is less than that of an offset that wanders.
    pub odds: f64,
}

/// Where the fit stands: `M h − b`, less v while it is on.
#[derive(Clone, Copy)]
struct Point {
    matrix: SMatrix<f64, 3, 3>,
    offset: [f64; 3],
    vector: [f64; 3],
}

struct Fit {
    point: Point,
    states: Vec<bool>,
    squares: f64,
    covariance: SMatrix<f64, 3, 3>,
}

impl Point {
    /// The vector while it is off.
    fn off(&self, h: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.offset;
        let moved = self.matrix * SVector::from(h);
        [moved[0] - x, moved[1] - y, moved[2] - z]
    }

    /// What is left of the magnitude, µT.
    fn left(&self, h: [f64; 3], on: bool, field_ut: f64) -> f64 {
        let g = self.off(h);
        let g = if on { less(g, self.vector) } else { g };
        dot(g, g).sqrt() - field_ut
    }
}

fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// Whether an offset switches. `corrected_ut` is corrected by a calibration with this matrix and field.
pub fn switching(
    time_s: &[f64],
    corrected_ut: &[[f64; 3]],
    matrix: &[[f64; 3]; 3],
    field_ut: f64,
) -> Option<Switching> {
    let inverse = ironout::vector::inverse_3x3(matrix)?;
    if corrected_ut.len() != time_s.len() || corrected_ut.len() < 20 * ALL {
        return None;
    }
    // However long a log is, so much of it is looked at.
    let time_s: Vec<f64> = thinned(time_s, MOST_SAMPLES);
    let corrected_ut: Vec<[f64; 3]> = thinned(corrected_ut, MOST_SAMPLES);
    let (time_s, corrected_ut) = (time_s.as_slice(), corrected_ut.as_slice());
    let rows: Vec<Row> = corrected_ut.iter().filter_map(|h| Row::of(*h, field_ut)).collect();
    if rows.len() != corrected_ut.len() {
        return None;
    }
    let start = best_start(&thinned(corrected_ut, MOST_BLOCKS), field_ut)?;
    let fit = rounds(corrected_ut, field_ut, start)?;
    let n = rows.len() as f64;
    let changes = fit.states.windows(2).filter(|pair| pair[0] != pair[1]).count();
    if changes < FEWEST_CHANGES || n / (changes + 1) as f64 <= FEWEST_SAMPLES {
        return None;
    }
    let before = plain(&rows)?;
    let left: Vec<f64> =
        (corrected_ut.iter().zip(&fit.states)).map(|(h, on)| fit.point.left(*h, *on, field_ut)).collect();
    // Noise with a memory of one sample, as the rival's has a state.
    let own = autoregressive(&left) + (3.0 + 2.0 * changes as f64) * n.ln();
    let odds = wandered(corrected_ut, field_ut, time_s, fit.point.vector)? - own;
    if odds < MIN_ODDS {
        return None;
    }
    let on = fit.states.iter().filter(|on| **on).count() as f64 / n;
    let (sign, states): (f64, Vec<bool>) = match on <= 0.5 {
        true => (1.0, fit.states.clone()),
        false => (-1.0, fit.states.iter().map(|on| !on).collect()),
    };
    let to_sensor =
        |v: [f64; 3]| inverse.map(|row| row.iter().zip(v).map(|(a, b)| sign * a * b).sum::<f64>());
    let variance = fit.squares / (n - ALL as f64) * memory(left.iter().copied());
    let error = |axis: usize| {
        let row = SVector::<f64, 3>::from(inverse[axis]);
        (row.dot(&(fit.covariance * row)) * variance).max(0.0).sqrt()
    };
    Some(Switching {
        offset_ut: to_sensor(fit.point.vector),
        std_errors_ut: std::array::from_fn(error),
        on_s: spans(time_s, &states),
        duty: on.min(1.0 - on),
        before_rms_ut: (before.1 / n).sqrt(),
        rms_ut: (fit.squares / n).sqrt(),
        odds,
    })
}

/// −2 ln L of an offset that wanders, in all axes or along a vector, or that changes steadily.
pub(super) fn wandered(
    corrected_ut: &[[f64; 3]],
    field_ut: f64,
    time_s: &[f64],
    vector: [f64; 3],
) -> Option<f64> {
    let rows: Vec<Row> = corrected_ut.iter().filter_map(|h| Row::of(*h, field_ut)).collect();
    let (base, _) = plain(&rows)?;
    let free: Vec<f64> = rows.iter().map(|row| after_base(row, &base)).collect();
    let rough = wandering(&rows, time_s, &free, Some(vector)).min(wandering(&rows, time_s, &free, None));
    let steady = KNOTS.into_iter().filter_map(|knots| steady(corrected_ut, field_ut, time_s, knots));
    Some(steady.fold(rough, f64::min))
}

/// −2 ln L, its parameters paid for, of an offset that is linear in time between knots, as that of a part that warms.
fn steady(corrected_ut: &[[f64; 3]], field_ut: f64, time_s: &[f64], knots: usize) -> Option<f64> {
    let (first, last) = (*time_s.first()?, *time_s.last()?);
    let left = with_offsets(corrected_ut, field_ut, knots, |sample| {
        let place = (time_s[sample] - first) / (last - first) * knots as f64;
        let knot = (place.floor() as usize).min(knots - 1);
        let share = place - knot as f64;
        [(knot, 1.0 - share), (knot + 1, share)]
    })?;
    Some(left + 3.0 * knots as f64 * (corrected_ut.len() as f64).ln())
}

/// −2 ln L of the log with one matrix and `offsets` further offsets, of which each sample has these two shares. Number 0 is the offset
/// of the base.
pub(super) fn with_offsets(
    corrected_ut: &[[f64; 3]],
    field_ut: f64,
    offsets: usize,
    shares: impl Fn(usize) -> [(usize, f64); 2],
) -> Option<f64> {
    let width = BASE + 3 * offsets;
    let mut moved = corrected_ut.to_vec();
    for _ in 0..STEPS {
        let (mut normal, mut right) = (DMatrix::<f64>::zeros(width, width), DVector::<f64>::zeros(width));
        for (sample, h) in moved.iter().enumerate() {
            let row = Row::of(*h, field_ut)?;
            let mut columns: Vec<(usize, f64)> = row.base.iter().copied().enumerate().collect();
            for (number, share) in shares(sample).into_iter().filter(|(number, _)| *number > 0) {
                let own = |axis: usize| (BASE + 3 * (number - 1) + axis, -row.direction[axis] * share);
                columns.extend([0, 1, 2].map(own));
            }
            for (j, a) in &columns {
                columns.iter().for_each(|(k, b)| normal[(*j, *k)] += a * b);
                right[*j] -= a * row.residual_ut;
            }
        }
        let step = normal.cholesky()?.solve(&right);
        let change = one_and(std::array::from_fn(|entry| step[3 + entry]));
        for (sample, h) in moved.iter_mut().enumerate() {
            let turned = change * SVector::from(*h);
            *h = std::array::from_fn(|axis| {
                let own = shares(sample).into_iter().filter(|(number, _)| *number > 0);
                let own: f64 = own.map(|(number, share)| share * step[BASE + 3 * (number - 1) + axis]).sum();
                turned[axis] - step[axis] - own
            });
        }
    }
    let left: Vec<f64> = moved.iter().map(|h| dot(*h, *h).sqrt() - field_ut).collect();
    Some(autoregressive(&left)).filter(|score| score.is_finite())
}

/// Every so many of a series, so that there are few enough.
pub(super) fn thinned<T: Copy>(values: &[T], most: usize) -> Vec<T> {
    values.iter().step_by(values.len().div_ceil(most).max(1)).copied().collect()
}

/// The base's own least squares: its step, and what it leaves.
fn plain(rows: &[Row]) -> Option<([f64; BASE], f64)> {
    let mut normal = Normal::<BASE>::default();
    rows.iter().for_each(|row| normal.add(&row.base, row.residual_ut));
    let (step, squares) = normal.solve()?;
    Some((step.into(), squares))
}

fn after_base(row: &Row, base: &[f64; BASE]) -> f64 {
    row.residual_ut + row.base.iter().zip(base).map(|(a, b)| a * b).sum::<f64>()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where the least is left, with the changes paid for: from each direction of half a sphere and each size.
fn best_start(sample: &[[f64; 3]], field_ut: f64) -> Option<Point> {
    let rows: Vec<Row> = sample.iter().filter_map(|h| Row::of(*h, field_ut)).collect();
    let (_, squares) = plain(&rows)?;
    let n = sample.len() as f64;
    let sigma = (squares / n).sqrt();
    let mut best: Option<(f64, Point)> = None;
    for direction in half_sphere() {
        for size in SIZES {
            let vector = direction.map(|axis| axis * size * sigma * 3.0_f64.sqrt());
            // Half the vector stands in the offset already.
            let offset = vector.map(|axis| -0.5 * axis);
            let from = Point { matrix: SMatrix::identity(), offset, vector };
            let Some(fit) = rounds(sample, field_ut, from) else { continue };
            let changes = fit.states.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64;
            let score = n * fit.squares.max(f64::MIN_POSITIVE).ln() + 2.0 * changes * n.ln();
            if best.as_ref().is_none_or(|(least, _)| score < *least) {
                best = Some((score, fit.point));
            }
        }
    }
    best.map(|(_, point)| point)
}

/// Thirteen directions: axes, diagonals of faces, diagonals of the cube, one of each pair.
fn half_sphere() -> impl Iterator<Item = [f64; 3]> {
    (0..27).filter_map(|code| {
        let v = [code / 9, code / 3 % 3, code % 3].map(|digit| f64::from(digit) - 1.0);
        let first = v.into_iter().find(|axis| *axis != 0.0)?;
        let norm = dot(v, v).sqrt();
        (first > 0.0).then(|| v.map(|axis| axis / norm))
    })
}

/// States for the vector, then base and vector for the states (a Gauss–Newton step), until both stand.
fn rounds(sample: &[[f64; 3]], field_ut: f64, mut point: Point) -> Option<Fit> {
    let n = sample.len() as f64;
    let mut states: Vec<bool> = Vec::new();
    let mut variance = None;
    let mut last = None;
    for _ in 0..ROUNDS {
        let left: Vec<[f64; 2]> =
            sample.iter().map(|h| [false, true].map(|on| point.left(*h, on, field_ut))).collect();
        // Before the states are known: what is left where each sample takes the nearer of the two.
        let nearer = || left.iter().map(|[off, on]| (off * off).min(on * on)).sum::<f64>() / n;
        let next = viterbi(&left, variance.unwrap_or_else(nearer).max(f64::MIN_POSITIVE));
        let stands = next == states;
        states = next;
        let mut normal = Normal::<ALL>::default();
        for (h, on) in sample.iter().zip(&states) {
            let off = point.off(*h);
            let seen = Row::of(if *on { less(off, point.vector) } else { off }, field_ut)?;
            let mut columns = [0.0; ALL];
            columns[..BASE].copy_from_slice(&base_columns(seen.direction, off));
            if *on {
                (0..3).for_each(|axis| columns[BASE + axis] = -seen.direction[axis]);
            }
            normal.add(&columns, seen.residual_ut);
        }
        let (step, _) = normal.solve()?;
        let change = one_and(std::array::from_fn(|entry| step[3 + entry]));
        let offset = change * SVector::from(point.offset);
        point = Point {
            matrix: change * point.matrix,
            offset: std::array::from_fn(|axis| offset[axis] + step[axis]),
            vector: std::array::from_fn(|axis| point.vector[axis] + step[BASE + axis]),
        };
        let squares: f64 =
            (sample.iter().zip(&states)).map(|(h, on)| point.left(*h, *on, field_ut).powi(2)).sum();
        let before = variance.replace(squares / n);
        let covariance = normal.inverse()?.fixed_view::<3, 3>(BASE, BASE).into_owned();
        last = Some((squares, covariance));
        if stands && before.is_some_and(|before| (before - squares / n).abs() <= 1e-9 * before) {
            break;
        }
    }
    let (squares, covariance) = last.filter(|(squares, _)| squares.is_finite())?;
    Some(Fit { point, states, squares, covariance })
}

/// The likeliest states: squares over their variance, and 2 ln n for each change.
fn viterbi(left: &[[f64; 2]], variance: f64) -> Vec<bool> {
    let price = 2.0 * (left.len() as f64).ln();
    let mut cost = [0.0, 0.0];
    let mut came: Vec<[bool; 2]> = Vec::with_capacity(left.len());
    for both in left {
        let own = both.map(|left| left * left / variance);
        let from = [cost[1] + price < cost[0], cost[1] < cost[0] + price];
        let best = [cost[0].min(cost[1] + price), cost[1].min(cost[0] + price)];
        cost = [best[0] + own[0], best[1] + own[1]];
        came.push(from);
    }
    let mut on = cost[1] < cost[0];
    let mut states = vec![false; left.len()];
    for at in (0..left.len()).rev() {
        states[at] = on;
        on = came[at][usize::from(on)];
    }
    states
}

/// −2 ln L, but a constant, of noise whose values follow each other by ρ.
pub(super) fn autoregressive(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    let products: f64 = values.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let rho = if squares > 0.0 { (products / squares).clamp(-0.99, 0.99) } else { 0.0 };
    let n = values.len() as f64;
    n * (squares * (1.0 - rho * rho) / n).max(f64::MIN_POSITIVE).ln() + 2.0 * n.ln()
}

/// −2 ln L of white noise and an offset that wanders, with its parameters paid for: of the best of a grid of sizes and time constants.
fn wandering(rows: &[Row], time_s: &[f64], residual: &[f64], along: Option<[f64; 3]>) -> f64 {
    let n = rows.len() as f64;
    let length = time_s[rows.len() - 1] - time_s[0];
    let step = length / (n - 1.0);
    let mut best = f64::INFINITY;
    let mut tau = 2.0 * step;
    while tau < length {
        for ratio in [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0] {
            best = best.min(kalman(rows, time_s, residual, tau, ratio, along));
        }
        tau *= 2.0;
    }
    best + 2.0 * n.ln() + if along.is_some() { 2.0 * n.ln() } else { 0.0 }
}

/// −2 ln L, but a constant, of `r = u·e + white`, e an Ornstein–Uhlenbeck vector whose variance is `ratio` times that of the white noise.
fn kalman(
    rows: &[Row],
    time_s: &[f64],
    residual: &[f64],
    tau: f64,
    ratio: f64,
    along: Option<[f64; 3]>,
) -> f64 {
    type Three = SMatrix<f64, 3, 3>;
    let stationary: Three = match along {
        None => Three::identity() * ratio,
        Some(v) => {
            let v = SVector::<f64, 3>::from(v) / dot(v, v).sqrt().max(f64::MIN_POSITIVE);
            // In the mean over the directions a vector shows by a third of its square.
            v * v.transpose() * (3.0 * ratio)
        }
    };
    let (mut state, mut p) = (SVector::<f64, 3>::zeros(), stationary);
    let (mut logs, mut squares) = (0.0, 0.0);
    for at in 0..rows.len() {
        if at > 0 {
            let decay = (-(time_s[at] - time_s[at - 1]).max(0.0) / tau).exp();
            state *= decay;
            p = p * (decay * decay) + stationary * (1.0 - decay * decay);
        }
        let u = SVector::<f64, 3>::from(rows[at].direction);
        let seen = p * u;
        let variance = u.dot(&seen) + 1.0;
        let innovation = residual[at] - u.dot(&state);
        logs += variance.ln();
        squares += innovation * innovation / variance;
        state += seen * (innovation / variance);
        p -= seen * seen.transpose() / variance;
    }
    let n = rows.len() as f64;
    logs + n * (squares / n).max(f64::MIN_POSITIVE).ln()
}

/// The stretches in which it is on.
fn spans(time_s: &[f64], states: &[bool]) -> Vec<[f64; 2]> {
    let mut spans: Vec<[f64; 2]> = Vec::new();
    let mut before = false;
    for (time, on) in time_s.iter().zip(states) {
        match (before, on) {
            (false, true) => spans.push([*time, *time]),
            (true, true) => {
                if let Some(last) = spans.last_mut() {
                    last[1] = *time;
                }
            }
            _ => (),
        }
        before = *on;
    }
    spans
}
