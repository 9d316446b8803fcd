//! Repairs that give each number another value: unsigned, wrapped, bytes in the wrong order.

use super::evidence::{Breakage, MAX_PATH_SHARE, MIN_EVENTS};
use super::repair::{Repair, swapped, unsigned_low, unwrap, window};
use super::series::{count_step, ends, is_continuous, path};

/// Numbers of fewer bits than a byte are not counts that wrapped.
const MIN_COUNTS: f64 = 256.0;
/// The part of a modulus that no reading lies in, at least: otherwise the readings' own range is larger than the modulus.
const MIN_FREE_SHARE: f64 = 0.05;

/// What a repair does to an axis.
pub struct OfAxis {
    repair: Repair,
    rows: usize,
    first: usize,
    before: f64,
    after: f64,
}

impl OfAxis {
    /// The repair as a diagnosis.
    pub fn breakage(self) -> Breakage {
        Breakage {
            repair: self.repair,
            rows: self.rows,
            first_row: self.first,
            explained: 1.0 - self.after / self.before,
        }
    }

    /// Path length that the repair removes.
    pub fn gain(&self) -> f64 {
        self.before - self.after
    }
}

/// The best of these repairs for one axis.
pub fn best(values: &[f64], axis: usize) -> Option<OfAxis> {
    let step = count_step(values)?;
    let axes = [0, 1, 2].map(|a| a == axis);
    let (low, high) = ends(values);
    if high - low < (MIN_COUNTS - 1.0) / 2.0 * step {
        return None;
    }
    let mapped = |repair: Repair, map: fn(f64) -> f64| {
        let fits = low >= -32_768.5 * step && high <= 65_535.5 * step;
        if fits { of_map(values, repair, |v| map(v / step) * step) } else { None }
    };
    let all = [
        wrapped(values, axis, step),
        mapped(Repair::SwappedBytes { axes, step }, swapped),
        mapped(Repair::SignedLowByte { axes, step }, unsigned_low),
    ];
    all.into_iter().flatten().max_by(|a, b| a.gain().total_cmp(&b.gain()))
}

/// A map of each number by itself: judged at the steps that it changes.
fn of_map(values: &[f64], repair: Repair, map: impl Fn(f64) -> f64) -> Option<OfAxis> {
    let (mut before, mut after, mut steps) = (0.0, 0.0, 0_usize);
    for pair in values.windows(2) {
        let (raw, mended) = ((pair[1] - pair[0]).abs(), (map(pair[1]) - map(pair[0])).abs());
        if raw != mended {
            (before, after, steps) = (before + raw, after + mended, steps + 1);
        }
    }
    if steps < 2 * MIN_EVENTS || after > MAX_PATH_SHARE * before {
        return None;
    }
    let mended: Vec<f64> = values.iter().map(|value| map(*value)).collect();
    let changed = || values.iter().zip(&mended).enumerate().filter(|(_, (a, b))| a != b);
    let first = changed().next().map_or(0, |(at, _)| at);
    // A map that makes a smooth axis of a rough one, not one that shrinks it.
    is_continuous(&mended).then(|| OfAxis { repair, rows: changed().count(), first, before, after })
}

/// Numbers that ran over the end of their bits, or that were signed and are read as unsigned.
fn wrapped(values: &[f64], axis: usize, step: f64) -> Option<OfAxis> {
    let (low, high) = ends(values);
    let mut modulus = MIN_COUNTS * step;
    while modulus < high - low + 0.5 * step {
        modulus *= 2.0;
    }
    let (mut before, mut after, mut jumps, mut first) = (0.0, 0.0, 0_usize, None);
    for (at, pair) in values.windows(2).enumerate() {
        let jump = (pair[1] - pair[0]).abs();
        if jump > 0.5 * modulus {
            (before, after, jumps) = (before + jump, after + (modulus - jump).abs(), jumps + 1);
            first = first.or(Some(at + 1));
        }
    }
    // A spike jumps twice, there and back, and one of any height meets the modulus within this share by chance: fewer events must
    // meet it better, to be as improbable as three.
    let events = jumps.div_ceil(2).clamp(1, MIN_EVENTS);
    let share = MAX_PATH_SHARE.powf(MIN_EVENTS as f64 / events as f64);
    if jumps == 0 || after > share * before {
        return None;
    }
    let mut continued = values.to_vec();
    unwrap(&mut continued, modulus);
    if !is_continuous(&continued) || path(continued.iter().copied()) > path(values.iter().copied()) {
        return None;
    }
    let free = free_arc(values, modulus);
    let axes = [0, 1, 2].map(|a| a == axis);
    let half = 0.5 * modulus;
    let (repair, mended): (Repair, Vec<f64>) = match free {
        // Nothing lies at the end of the signed numbers, and none is negative: they were signed.
        Some((from, to)) if low >= 0.0 && from <= half && half <= to => (
            Repair::Unsigned { axes, modulus },
            values.iter().map(|v| if *v >= half { v - modulus } else { *v }).collect(),
        ),
        Some((from, to)) => {
            // The branch that leaves most numbers as they are.
            let cut = 0.5 * (from + to);
            let base = window(cut, low - modulus, modulus);
            let kept = |from: f64| values.iter().filter(|v| window(**v, from, modulus) == **v).count();
            let from = if kept(base) >= kept(base + modulus) { base } else { base + modulus };
            let from = (from / step).round() * step;
            (
                Repair::Unwrap { axis, modulus, from: Some(from) },
                values.iter().map(|v| window(*v, from, modulus)).collect(),
            )
        }
        None => (Repair::Unwrap { axis, modulus, from: None }, continued),
    };
    let rows = values.iter().zip(&mended).filter(|(a, b)| (*a - *b).abs() > 0.5 * step).count();
    Some(OfAxis { repair, rows, first: first.unwrap_or(0), before, after })
}

/// The widest part of the circle of a modulus that no value lies in: where it begins and ends, the beginning within 0 and the modulus.
fn free_arc(values: &[f64], modulus: f64) -> Option<(f64, f64)> {
    let mut around: Vec<f64> = values.iter().map(|value| value.rem_euclid(modulus)).collect();
    around.sort_by(f64::total_cmp);
    let (first, last) = (*around.first()?, *around.last()?);
    let inner = around.windows(2).map(|pair| (pair[0], pair[1]));
    let arcs = inner.chain(std::iter::once((last, first + modulus)));
    let widest = arcs.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    (widest.1 - widest.0 >= MIN_FREE_SHARE * modulus).then_some(widest)
}
