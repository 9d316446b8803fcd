//! Faults of the data, found and set aside before any effect is tested.

use crate::samples::copied::copied;
use crate::samples::samples::{Samples, unique_rows};
use crate::samples::series::{median, quantum, second_difference_sigma};
use crate::table::Table;
use serde::Serialize;

/// What a sensor, a cable or a logger did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// An axis at the end of its range.
    Clipping,
    /// A magnet or iron passed, or single readings are far off.
    Burst,
    /// One reading repeated while the board turned.
    Stuck,
    /// Rows are missing.
    Gap,
    /// An axis is a copy of another.
    CopiedAxis,
    /// Readings are there a second time.
    CopiedRows,
}

impl FaultKind {
    /// The word of the contract.
    pub const fn name(self) -> &'static str {
        match self {
            FaultKind::Clipping => "clipping",
            FaultKind::Burst => "burst",
            FaultKind::Stuck => "stuck",
            FaultKind::Gap => "gap",
            FaultKind::CopiedAxis => "copied-axis",
            FaultKind::CopiedRows => "copied-rows",
        }
    }
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataFault {
    /// What.
    pub kind: FaultKind,
    /// From when, s; `None` without a time column.
    pub from_s: Option<f64>,
    /// Until when, s.
    pub to_s: Option<f64>,
    /// Samples concerned (for a gap: missing, by the log's own rate).
    pub samples: usize,
    /// Columns concerned.
    pub columns: Vec<String>,
}

/// What was found before any fit.
#[derive(Debug, Clone)]
pub struct Faults {
    /// The faults.
    pub list: Vec<DataFault>,
    /// Rows to set aside.
    pub set_aside: Vec<bool>,
    /// Axes with data of their own.
    pub axes: [bool; 3],
}

/// The columns of the magnetometer.
pub const AXES: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
/// A visit to the end of a range ends this share of the range away from it.
const VISIT_SHARE: f64 = 0.02;
/// Fewer samples than this at the end of a range are not clipping.
const CLIPPED_SAMPLES: usize = 15;
/// The end of a range is met this many times as often as the steps before it, and more; at a turning point that no noise
/// blurs it would be 3.2 times.
const CLIPPED_OVER: f64 = 4.0;
/// A reading must stand still for this long to be stuck, s.
const STUCK_S: f64 = 0.4;
/// Nor is it stuck for fewer rows than this.
const STUCK_ROWS: usize = 8;
/// Less than this is not a gap, s.
const GAP_S: f64 = 0.4;
/// A burst stands out of the residual this many robust standard deviations.
const BURST_PEAK: f64 = 9.0;
/// ... and ends where it no longer does by this many.
const BURST_EDGE: f64 = 2.5;
/// On both sides of a burst the residual is usual: its median stays below this many robust standard deviations (0.67 for
/// noise alone; the burst itself has bent the fit a little).
const BURST_SIDE: f64 = 3.5;
/// A spike stands out of its neighbourhood this many robust standard deviations: chance does so once in 500 million samples.
const SPIKE: f64 = 6.0;
/// Neighbours on either side; a spike is shorter than that.
const NEIGHBOURS: usize = 3;
/// A glitch lies outside the middle 96 % of an axis' readings by more than this many times their range.
const GLITCH_REACH: f64 = 1.0;
/// An outlier is further off than this many robust standard deviations.
const OUTLIER: f64 = 5.0;
/// More than this share of a log is not a burst.
pub const BURST_SHARE: f64 = 0.05;

fn span(
    table: &Table,
    kind: FaultKind,
    from: usize,
    to: usize,
    samples: usize,
    columns: &[usize],
) -> DataFault {
    DataFault {
        kind,
        from_s: table.time_s.map(|t| t[from]),
        to_s: table.time_s.map(|t| t[to]),
        samples,
        columns: columns.iter().map(|axis| AXES[*axis].to_string()).collect(),
    }
}

/// Finds what shows without a model.
pub fn find(table: &Table) -> Faults {
    let rows = table.rows();
    let mut faults = Faults { list: Vec::new(), set_aside: vec![false; rows], axes: [true; 3] };
    if rows < 20 {
        return faults;
    }
    copied_axis(table, &mut faults);
    let unique = unique_rows(table);
    stuck(table, &unique, &mut faults);
    gap(table, &unique, &mut faults);
    copied_rows(table, &unique, &mut faults);
    glitches(table, &unique, &mut faults);
    for axis in 0..3 {
        clipping(table, &unique, axis, &mut faults);
    }
    faults
}

/// Readings that the log holds already.
fn copied_rows(table: &Table, unique: &[usize], faults: &mut Faults) {
    let readings: Vec<[f64; 3]> = unique.iter().map(|&row| table.field(row)).collect();
    for (from, to) in copied(&readings) {
        let rows = (unique[from], unique[to]);
        faults.set_aside[rows.0..=rows.1].fill(true);
        faults.list.push(span(table, FaultKind::CopiedRows, rows.0, rows.1, to - from + 1, &[0, 1, 2]));
    }
}

fn copied_axis(table: &Table, faults: &mut Faults) {
    let rows = table.rows();
    for (first, second) in [(0, 1), (0, 2), (1, 2)] {
        let (a, b) = (table.field_ut[first], table.field_ut[second]);
        if a.iter().all(|value| *value == a[0]) {
            continue;
        }
        for sign in [1.0, -1.0] {
            let same = a.iter().zip(b).filter(|(x, y)| **x == sign * **y).count();
            if same * 10 < rows * 8 || !faults.axes[second] {
                continue;
            }
            // A copy may have been rounded once more: one step of the column off, and mostly not even that.
            let step = quantum(a);
            let near = a.iter().zip(b).filter(|(x, y)| (**x - sign * **y).abs() <= 1.01 * step).count();
            if near * 1000 >= rows * 995 {
                faults.axes[second] = false;
                faults.list.push(span(table, FaultKind::CopiedAxis, 0, rows - 1, same, &[first, second]));
            }
        }
    }
}

/// Readings far outside the range of all others: corrupted, or a magnet at the sensor. They would drown any fit.
fn glitches(table: &Table, unique: &[usize], faults: &mut Faults) {
    let n = unique.len();
    let mut out = vec![false; n];
    for axis in 0..3 {
        let values: Vec<f64> = unique.iter().map(|&row| table.field_ut[axis][row]).collect();
        let mut some = values.clone();
        let low = *some.select_nth_unstable_by(n * 2 / 100, f64::total_cmp).1;
        let high = *some.select_nth_unstable_by(n - 1 - n * 2 / 100, f64::total_cmp).1;
        let reach = GLITCH_REACH * (high - low);
        for (flag, value) in out.iter_mut().zip(&values) {
            *flag |= *value > high + reach || *value < low - reach;
        }
    }
    let count = out.iter().filter(|flag| **flag).count();
    if count == 0 || count * 50 > n {
        return;
    }
    let mut at = 0;
    while at < n {
        if !out[at] {
            at += 1;
            continue;
        }
        let from = at;
        while at + 1 < n && out[at + 1] {
            at += 1;
        }
        for &row in &unique[from..=at] {
            faults.set_aside[row] = true;
        }
        faults.list.push(span(table, FaultKind::Burst, unique[from], unique[at], at - from + 1, &[0, 1, 2]));
        at += 1;
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn stuck(table: &Table, unique: &[usize], faults: &mut Faults) {
    let rows = table.rows();
    let ends = unique.iter().skip(1).copied().chain([rows]);
    let mut lengths: Vec<usize> = unique.iter().zip(ends.clone()).map(|(from, to)| to - from).collect();
    let mut moves: Vec<f64> =
        unique.windows(2).map(|pair| distance(table.field(pair[0]), table.field(pair[1]))).collect();
    let usual_move = median(&mut moves);
    let most = lengths.len() * 95 / 100;
    let usual = if most < lengths.len() { *lengths.select_nth_unstable(most).1 } else { 1 };
    for (from, to) in unique.iter().copied().zip(ends) {
        let length = to - from;
        let seconds = table.time_s.map(|t| t[to - 1] - t[from]);
        if length < STUCK_ROWS.max(5 * usual) || seconds.is_some_and(|s| s < STUCK_S) || to >= rows {
            continue;
        }
        // A resting board repeats its reading too: a stuck one comes back somewhere else, or turns meanwhile.
        let jumped = distance(table.field(from), table.field(to)) > 8.0 * usual_move;
        let turned = table.gyro_radps.as_ref().is_some_and(|gyro| {
            let turn: f64 =
                (from..to).map(|row| gyro.iter().map(|axis| axis[row].powi(2)).sum::<f64>().sqrt()).sum();
            turn / length as f64 > 0.2
        });
        if jumped || turned {
            faults.set_aside[from + 1..to].fill(true);
            faults.list.push(span(table, FaultKind::Stuck, from, to - 1, length, &[0, 1, 2]));
        }
    }
}

fn gap(table: &Table, unique: &[usize], faults: &mut Faults) {
    let Some(time) = table.time_s else { return };
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let most = steps.len() * 99 / 100;
    let usual = *steps.select_nth_unstable_by(most, f64::total_cmp).1;
    let seconds = time[time.len() - 1] - time[0];
    let mean = seconds / unique.len().max(2) as f64;
    for row in 1..table.rows() {
        let step = time[row] - time[row - 1];
        if step > GAP_S.max(8.0 * usual) && step > 15.0 * mean {
            let missing = (step / mean).round() as usize;
            faults.list.push(span(table, FaultKind::Gap, row - 1, row, missing, &[]));
        }
    }
}

fn clipping(table: &Table, unique: &[usize], axis: usize, faults: &mut Faults) {
    let unique: Vec<usize> = unique.iter().copied().filter(|row| !faults.set_aside[*row]).collect();
    let values: Vec<f64> = unique.iter().map(|&row| table.field_ut[axis][row]).collect();
    let step = quantum(&values);
    if step <= 0.0 {
        return;
    }
    // A board that rests at its extreme, or passes it once, leaves it by noise and tremor alone: a visit ends beyond that.
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let away = (4.0 * second_difference_sigma(&values)).max(4.1 * step).max(VISIT_SHARE * (high - low));
    for extreme in [high, low] {
        let is_at = |value: f64| (value - extreme).abs() < 0.5 * step;
        let at: Vec<usize> = unique.iter().copied().filter(|&row| is_at(table.field_ut[axis][row])).collect();
        // How often the next steps inward are met: the end of a range stands out, a turning point rises to it.
        let near =
            values.iter().filter(|value| !is_at(**value) && (*value - extreme).abs() < 4.5 * step).count();
        let usual = near as f64 / 4.0;
        let (mut visits, mut inside) = (0, false);
        for value in &values {
            if is_at(*value) && !inside {
                (visits, inside) = (visits + 1, true);
            } else if (value - extreme).abs() > away {
                inside = false;
            }
        }
        let count = at.len() as f64;
        let stands_out = count - CLIPPED_OVER * usual > 3.0 * count.sqrt();
        if at.len() >= CLIPPED_SAMPLES && stands_out && visits >= 2 {
            for &row in &at {
                faults.set_aside[row] = true;
            }
            faults.list.push(span(table, FaultKind::Clipping, at[0], at[at.len() - 1], at.len(), &[axis]));
        }
    }
}

/// Bursts in the residual of a fit: `(first, last)` sample of each. Empty where so much stands out that it is structure.
pub fn bursts(residuals: &[f64]) -> Vec<(usize, usize)> {
    let n = residuals.len();
    if n < 50 {
        return Vec::new();
    }
    let middle = median(&mut residuals.to_vec());
    let mut off: Vec<f64> = residuals.iter().map(|r| (r - middle).abs()).collect();
    let sigma = 1.4826 * median(&mut off.clone());
    if sigma.is_nan() || sigma <= 0.0 {
        return Vec::new();
    }
    for value in &mut off {
        *value /= sigma;
    }
    let around = |at: usize, side: usize| {
        let (from, to) = (at.saturating_sub(side), (at + side + 1).min(n));
        off[from..to].iter().sum::<f64>() / (to - from) as f64
    };
    let smooth = |at: usize| around(at, 2);
    let mut events: Vec<(usize, usize)> = Vec::new();
    let mut at = 0;
    while at < n {
        if off[at] < BURST_PEAK {
            at += 1;
            continue;
        }
        let (mut from, mut to) = (at, at);
        while from > 0 && smooth(from - 1) > BURST_EDGE {
            from -= 1;
        }
        while to + 1 < n && smooth(to + 1) > BURST_EDGE {
            to += 1;
        }
        // The flanks of a passing magnet fade into the noise.
        let flank = (to - from) / 8;
        (from, to) = (from.saturating_sub(flank), (to + flank).min(n - 1));
        match events.last_mut() {
            // The field of a magnet that turns by passes through what the magnitude does not see.
            Some(last) if from <= last.1 + 3.max((to - last.0) / 5) => last.1 = to,
            _ => events.push((from, to)),
        }
        at = to + 1;
    }
    // A burst stands alone: an effect that fades in or out, or comes in many bursts, has company on its sides.
    let loud = |from: usize, to: usize| {
        let mut part = off[from..to].to_vec();
        part.len() > 5 && median(&mut part) > BURST_SIDE
    };
    events.retain(|&(from, to)| {
        let side = (to - from + 1).max(25);
        !loud(from.saturating_sub(side), from) && !loud(to + 1, (to + 1 + side).min(n))
    });
    let flagged: usize = events.iter().map(|(from, to)| to - from + 1).sum();
    if flagged as f64 > BURST_SHARE * n as f64 { Vec::new() } else { events }
}

/// Whether some residual of `from..=to` stands out of all of them as the peak of a burst does.
pub fn stands_out(residuals: &[f64], from: usize, to: usize) -> bool {
    let middle = median(&mut residuals.to_vec());
    let mut off: Vec<f64> = residuals.iter().map(|r| (r - middle).abs()).collect();
    let limit = BURST_PEAK * 1.4826 * median(&mut off.clone());
    off.truncate(to + 1);
    off.iter().skip(from).any(|value| *value > limit)
}

/// Which residuals stand out of the others, and should not bend the fit that bursts are looked for with.
pub fn outliers(residuals: &[f64]) -> Vec<bool> {
    let middle = median(&mut residuals.to_vec());
    let mut off: Vec<f64> = residuals.iter().map(|r| (r - middle).abs()).collect();
    let limit = OUTLIER * 1.4826 * median(&mut off.clone());
    off.drain(..).map(|value| value > limit).collect()
}

/// The median of a few neighbours; NaN of none.
fn median_of(near: &[f64]) -> f64 {
    let mut copy = [0.0; NEIGHBOURS];
    let copy = &mut copy[..near.len()];
    copy.copy_from_slice(near);
    median(copy)
}

/// Single readings far from those next to them in the residual of a fit: `(first, last)` sample of each. Whatever effect is
/// missing from the model changes slowly next to them. Empty where so many stand out that it is the noise.
pub fn spikes(residuals: &[f64]) -> Vec<(usize, usize)> {
    let n = residuals.len();
    if n < 50 {
        return Vec::new();
    }
    // From the neighbours before and from those after. A level that changes for good lies with one of the two.
    let off = |at: usize| {
        let before = median_of(&residuals[at.saturating_sub(NEIGHBOURS)..at]);
        let after = median_of(&residuals[at + 1..(at + 1 + NEIGHBOURS).min(n)]);
        let [before, after] = match (before.is_nan(), after.is_nan()) {
            (true, _) => [after; 2],
            (_, true) => [before; 2],
            _ => [before, after],
        };
        [residuals[at] - before, residuals[at] - after]
    };
    let size = |at: usize| {
        let [before, after] = off(at);
        0.5 * (before + after).abs()
    };
    let mut sizes: Vec<f64> = (0..n).map(size).collect();
    let limit = SPIKE * 1.4826 * median(&mut sizes);
    if limit.is_nan() || limit <= 0.0 {
        return Vec::new();
    }
    let stands = |at: usize| {
        let [before, after] = off(at);
        before * after > 0.0 && before.abs().min(after.abs()) > limit
    };
    let mut events: Vec<(usize, usize)> = Vec::new();
    for at in (0..n).filter(|&at| stands(at)) {
        match events.last_mut() {
            Some(last) if at == last.1 + 1 => last.1 = at,
            _ => events.push((at, at)),
        }
    }
    let flagged: usize = events.iter().map(|(from, to)| to - from + 1).sum();
    if flagged as f64 > BURST_SHARE * n as f64 { Vec::new() } else { events }
}

/// The fault that a burst between two rows is.
pub fn burst_fault(table: &Table, (from, to): (usize, usize), samples: usize) -> DataFault {
    span(table, FaultKind::Burst, from, to, samples, &[0, 1, 2])
}

/// Bursts that touch are one.
pub fn merge_bursts(list: &mut Vec<DataFault>) {
    let mut merged: Vec<DataFault> = Vec::new();
    let bursts = list.iter().filter(|fault| fault.kind == FaultKind::Burst).cloned();
    let mut sorted: Vec<DataFault> = bursts.collect();
    sorted.sort_by(|a, b| a.from_s.unwrap_or(0.0).total_cmp(&b.from_s.unwrap_or(0.0)));
    for fault in sorted {
        match merged.last_mut() {
            Some(last) if fault.from_s.zip(last.to_s).is_some_and(|(from, to)| from <= to + 0.3) => {
                last.to_s = fault.to_s.zip(last.to_s).map(|(a, b)| a.max(b));
                last.samples += fault.samples;
            }
            _ => merged.push(fault),
        }
    }
    list.retain(|fault| fault.kind != FaultKind::Burst);
    list.extend(merged);
}

/// Whether a column of the log does something during bursts that it does not do elsewhere: then they are not a fault but
/// something to explain.
pub fn have_company(samples: &Samples, bursts: &[(usize, usize)]) -> bool {
    let inside = |at: usize| bursts.iter().any(|(from, to)| (*from..=*to).contains(&at));
    samples.columns.iter().filter(|column| column.problem.is_none()).any(|column| {
        let mut sums = [[0.0; 3]; 2];
        for (at, value) in column.values.iter().enumerate() {
            let sum = &mut sums[usize::from(inside(at))];
            sum[0] += 1.0;
            sum[1] += value;
            sum[2] += value * value;
        }
        let [[count, sum, square], [count_in, sum_in, _]] = sums;
        if count < 1.0 || count_in < 1.0 {
            return false;
        }
        let mean = sum / count;
        let spread = (square / count - mean * mean).max(0.0).sqrt();
        (sum_in / count_in - mean).abs() > 3.0 * spread
    })
}
