//! A scale that changed while the log ran, and an axis that is of another time than the others.

use super::ellipsoid::{MAX_MISFIT_SHARE, misfit, points, usual_misfit};
use super::evidence::{Breakage, MIN_ROWS};
use super::repair::Repair;
use super::series::is_continuous;

/// Nearer to an ellipsoid than this share of its size, readings need no repair.
const MIN_MISFIT: f64 = 0.01;
/// Sensors' ranges differ by more than this factor.
const MIN_FACTOR: f64 = 1.2;
/// Where the scale changes, the reading jumps by this many of the steps next to it …
const MIN_JUMP_STEPS: f64 = 4.0;
/// … and all but this many of them along its own direction.
const MAX_ASIDE_STEPS: f64 = 2.5;
/// More changes in one log are disturbances …
const MAX_CHANGES: usize = 12;
/// … and more than so many are of one other range, or each would fit whatever it is at.
const MAX_FREE_CHANGES: usize = 2;
/// Factors of one range differ by less than this share of themselves, as one jump shows them.
const SAME_FACTOR: f64 = 0.2;
/// The ellipsoid of a moved axis leaves out hardly more readings than that of the axis where it was.
const MIN_READINGS_KEPT: f64 = 0.98;
/// Rows that an axis may be late.
const SHIFTS: [isize; 16] = [1, -1, 2, -2, 3, -3, 4, -4, 6, -6, 8, -8, 12, -12, 16, -16];

/// A change of scale, or a late axis.
pub fn find(numbers: [&[f64]; 3]) -> Option<Breakage> {
    let rows = numbers[0].len();
    if rows < MIN_ROWS {
        return None;
    }
    let before = misfit(&points(rows, |row, axis| numbers[axis][row]))?;
    if before < MIN_MISFIT {
        return None;
    }
    change(numbers, before).or_else(|| late(numbers))
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

fn change(numbers: [&[f64]; 3], before: f64) -> Option<Breakage> {
    let rows = numbers[0].len();
    // The first row of each reading that does not repeat the one before.
    let reading = |row: usize| [0, 1, 2].map(|axis| numbers[axis][row]);
    let starts: Vec<usize> = (0..rows).filter(|&row| row == 0 || reading(row) != reading(row - 1)).collect();
    let way = |a: [f64; 3], b: [f64; 3]| length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    let mut factors: Vec<(usize, f64)> = Vec::new();
    for w in starts.windows(4) {
        let [last, a, b, next] = [w[0], w[1], w[2], w[3]].map(reading);
        let square = a.iter().map(|v| v * v).sum::<f64>();
        let factor = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / square;
        if !(factor >= MIN_FACTOR || (factor > 0.0 && factor <= 1.0 / MIN_FACTOR)) {
            continue;
        }
        // The steps on both sides, in the scale before.
        let step = way(last, a).max(way(b, next) / factor);
        let aside = way(b, a.map(|v| v * factor)) / factor;
        if way(a, b) / factor.max(1.0) >= MIN_JUMP_STEPS * step && aside <= MAX_ASIDE_STEPS * step {
            factors.push((w[2], factor));
        }
    }
    if factors.is_empty() || factors.len() > MAX_CHANGES {
        return None;
    }
    let mut level = 1.0;
    let mut changes: Vec<(usize, f64)> = Vec::new();
    for (row, factor) in factors {
        level *= factor;
        // Back to where it began.
        if (level - 1.0_f64).abs() < 1.0 - 1.0 / MIN_FACTOR {
            level = 1.0;
        }
        changes.push((row, level));
    }
    if changes.len() > MAX_FREE_CHANGES {
        let other = changes.iter().map(|(_, level)| *level).find(|level| *level != 1.0)?;
        for (_, level) in &mut changes {
            if *level != 1.0 && (*level / other - 1.0).abs() > SAME_FACTOR {
                return None;
            }
            *level = if *level == 1.0 { 1.0 } else { other };
        }
    }
    let mended = |changes: &[(usize, f64)]| {
        let factor =
            |row: usize| changes.iter().rev().find(|(from, _)| *from <= row).map_or(1.0, |(_, f)| *f);
        misfit(&points(rows, |row, axis| numbers[axis][row] / factor(row)))
    };
    // One jump knows the factor roughly; the ellipsoid knows it better.
    let with = |share: f64| -> Vec<(usize, f64)> {
        changes.iter().map(|(row, f)| (*row, if *f == 1.0 { 1.0 } else { f.powf(share) })).collect()
    };
    let mut best = (f64::INFINITY, 1.0);
    for width in [0.3, 0.1, 0.03, 0.01, 0.003] {
        let about = best.1;
        for step in -3..=3 {
            let share = about + width * f64::from(step) / 3.0;
            if let Some(left) = mended(&with(share)).filter(|left| *left < best.0) {
                best = (left, share);
            }
        }
    }
    let (mut left, mut changes) = (best.0, with(best.1));
    // A whole factor, or one over a whole, where that is as good.
    let rounded: Vec<(usize, f64)> = changes.iter().map(|(row, factor)| (*row, whole(*factor))).collect();
    if let Some(of_rounded) = mended(&rounded).filter(|of| *of <= 1.1 * left) {
        (left, changes) = (of_rounded, rounded);
    }
    if left > MAX_MISFIT_SHARE * before {
        return None;
    }
    let first_row = changes.first()?.0;
    let other =
        |row: &usize| changes.iter().rev().find(|(from, _)| from <= row).is_some_and(|(_, f)| *f != 1.0);
    let concerned = (0..rows).filter(other).count();
    Some(Breakage {
        repair: Repair::RangeChange { changes },
        rows: concerned,
        first_row,
        explained: 1.0 - left / before,
    })
}

fn whole(factor: f64) -> f64 {
    let round = |value: f64| if (value / value.round() - 1.0).abs() < 0.03 { value.round() } else { value };
    if factor >= 1.0 { round(factor) } else { 1.0 / round(1.0 / factor) }
}

fn late(numbers: [&[f64]; 3]) -> Option<Breakage> {
    let rows = numbers[0].len();
    let (before, readings) = usual_misfit(&points(rows, |row, axis| numbers[axis][row]))?;
    if before < MIN_MISFIT {
        return None;
    }
    if !numbers.iter().all(|axis| is_continuous(axis)) {
        return None;
    }
    let mut best = (before, 0, 0_isize);
    for axis in 0..3 {
        for shift in SHIFTS {
            let of = |row: usize, a: usize| {
                let row = if a == axis { row.saturating_add_signed(shift).min(rows - 1) } else { row };
                numbers[a][row]
            };
            // Nearer to an ellipsoid, and not merely of fewer readings.
            let of_as_many = |(left, kept): &(f64, usize)| {
                *left < best.0 && *kept as f64 >= MIN_READINGS_KEPT * readings as f64
            };
            if let Some((left, _)) = usual_misfit(&points(rows, of)).filter(of_as_many) {
                best = (left, axis, shift);
            }
        }
    }
    let (left, axis, shift) = best;
    (left <= MAX_MISFIT_SHARE * before).then_some(Breakage {
        repair: Repair::LateAxis { axis, rows: shift },
        rows,
        first_row: 0,
        explained: 1.0 - left / before,
    })
}
