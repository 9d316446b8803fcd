//! Single rows that are wrong: a code in place of a reading, every n-th row, an axis that stands still.

use super::ellipsoid::{MAX_MISFIT_SHARE, misfit, points};
use super::evidence::{Breakage, MAX_PATH_SHARE, MAX_STEP_SHARE, MIN_EVENTS, MIN_ROWS};
use super::repair::Repair;
use super::series::{half_range, path, usual_step};
use crate::samples::series::median;

/// A row is out of line if leaving it out shortens the path by this many of the steps next to it: turning points and noise do not
/// reach twice.
const MIN_SHORTCUT_STEPS: f64 = 6.0;
/// … and by this share of half the range of the readings: below, a wrong row does not matter.
const MIN_SHORTCUT_SHARE: f64 = 0.3;
/// A diagnosis covers at least this share of all rows that are out of line.
const MIN_SHARE_OF_EVENTS: f64 = 0.5;
/// Of rows that are wrong every n-th time, this share of what is out of line lies on them …
const MIN_ON_GRID: f64 = 0.8;
/// … and this share of them is out of line; some are right by chance.
const MIN_OF_GRID: f64 = 0.5;
/// The longest period that is looked for.
const MAX_PERIOD: usize = 1024;
/// Rows of which every second is wrong make this many times the path of the right ones: all rows of a sensor make at most twice the
/// path of every second, noise included.
const MIN_ALTERNATING_PATH: f64 = 6.0;
/// The wrong half of the rows is rougher than the right one by this factor.
const MIN_ROUGHER: f64 = 4.0;
/// An axis that stands still for fewer rows is one that turns slowly.
const MIN_FROZEN_ROWS: usize = 3;
/// An axis that catches up jumps by this many of its usual steps, and the others went on by as many of theirs.
const MIN_CATCH_UP_STEPS: f64 = 6.0;

/// … and by this share of half the range of the readings: coarse numbers jump by their own steps.
const MIN_CATCH_UP_SHARE: f64 = 0.1;

/// Readings without those that repeat the one before.
struct Runs<'n> {
    numbers: [&'n [f64]; 3],
    /// Axes that are looked at; the others are zero.
    axes: [bool; 3],
    /// Row at which each reading begins.
    starts: Vec<u32>,
}

impl<'n> Runs<'n> {
    fn new(numbers: [&'n [f64]; 3], axes: [bool; 3]) -> Self {
        let mut runs = Runs { numbers, axes, starts: Vec::new() };
        for row in 0..numbers[0].len() {
            if row == 0 || runs.at_row(row) != runs.at_row(row - 1) {
                runs.starts.push(row as u32);
            }
        }
        runs
    }

    fn at_row(&self, row: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| if self.axes[axis] { self.numbers[axis][row] } else { 0.0 })
    }

    /// The reading of a run; `None` before the first and after the last.
    fn reading(&self, at: usize) -> Option<[f64; 3]> {
        self.starts.get(at).map(|row| self.at_row(*row as usize))
    }
}

/// Path between two readings, along the axes: readings between two others on every axis lie on the way, and cost nothing.
fn way(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).abs() + (a[2] - b[2]).abs()
}

/// A reading that is out of line.
#[derive(Clone, Copy)]
struct Event {
    at: usize,
    /// Path through it.
    through: f64,
    /// Path past it.
    past: f64,
}

fn events(runs: &Runs, range: f64) -> Vec<Event> {
    let mut list = Vec::new();
    for at in 1..runs.starts.len().saturating_sub(1) {
        let [Some(last), Some(this), Some(next)] = [at - 1, at, at + 1].map(|at| runs.reading(at)) else {
            break;
        };
        let (through, past) = (way(&last, &this) + way(&this, &next), way(&last, &next));
        let shortcut = through - past;
        if shortcut < MIN_SHORTCUT_SHARE * range {
            continue;
        }
        let before =
            at.checked_sub(2).and_then(|at| runs.reading(at)).map_or(0.0, |other| way(&other, &last));
        let behind = runs.reading(at + 2).map_or(0.0, |other| way(&next, &other));
        if shortcut >= MIN_SHORTCUT_STEPS * before.max(behind).max(past) {
            list.push(Event { at, through, past });
        }
    }
    list
}

/// The share of the path through these that leaving them out removes, and its length.
fn explained(events: &[Event]) -> (f64, f64) {
    let (through, past) = events.iter().fold((0.0, 0.0), |sum, e| (sum.0 + e.through, sum.1 + e.past));
    (1.0 - past / through, through - past)
}

/// Rows that are set aside, the best diagnosis first: of the whole reading, and of each axis by itself.
/// With the path length that it removes.
pub fn best(numbers: [&[f64]; 3]) -> Option<(Breakage, f64)> {
    if numbers[0].len() < MIN_ROWS {
        return None;
    }
    let range = numbers.map(half_range);
    let widest = range.iter().copied().fold(0.0, f64::max);
    let subsets = [[true; 3], [true, false, false], [false, true, false], [false, false, true]];
    // The whole reading first: an axis of it shows the same, and only a part.
    for axes in subsets {
        let runs = Runs::new(numbers, axes);
        let events = events(&runs, widest);
        let found = code(numbers, &runs, axes, &events).or_else(|| every(&runs, &events, numbers[0].len()));
        if found.is_some() {
            return found;
        }
    }
    alternating(numbers).or_else(|| frozen(numbers, widest))
}

/// A value that recurs out of line.
fn code(numbers: [&[f64]; 3], runs: &Runs, axes: [bool; 3], events: &[Event]) -> Option<(Breakage, f64)> {
    if events.len() < MIN_EVENTS {
        return None;
    }
    let mut values: Vec<([f64; 3], Event)> =
        events.iter().filter_map(|e| Some((runs.reading(e.at)?, *e))).collect();
    values.sort_by(|a, b| {
        a.0.iter().zip(&b.0).fold(std::cmp::Ordering::Equal, |o, (x, y)| o.then(x.total_cmp(y)))
    });
    let most = values.chunk_by(|a, b| a.0 == b.0).max_by_key(|chunk| chunk.len())?;
    let same: Vec<Event> = most.iter().map(|(_, event)| *event).collect();
    let (share, gain) = explained(&same);
    if same.len() < MIN_EVENTS
        || (same.len() as f64) < MIN_SHARE_OF_EVENTS * events.len() as f64
        || share < 1.0 - MAX_PATH_SHARE
    {
        return None;
    }
    let code = most.first()?.0;
    let repair = Repair::ErrorCode { axes, code };
    let mut marked = vec![false; numbers[0].len()];
    repair.set_aside(numbers, &mut marked);
    of_marked(repair, &marked, share, gain)
}

fn of_marked(repair: Repair, marked: &[bool], explained: f64, gain: f64) -> Option<(Breakage, f64)> {
    let first_row = marked.iter().position(|mark| *mark)?;
    let rows = marked.iter().filter(|mark| **mark).count();
    Some((Breakage { repair, rows, first_row, explained }, gain))
}

/// Rows out of line that come every n-th time.
fn every(runs: &Runs, events: &[Event], rows: usize) -> Option<(Breakage, f64)> {
    if events.len() < MIN_EVENTS + 1 {
        return None;
    }
    let places: Vec<usize> = events.iter().map(|event| runs.starts[event.at] as usize).collect();
    for every in 3..=MAX_PERIOD.min(rows / 4) {
        // The grid of the rows is that of most of them.
        let mut counts = vec![0_usize; every];
        places.iter().for_each(|place| counts[place % every] += 1);
        let (offset, on) = counts.iter().copied().enumerate().max_by_key(|(_, count)| *count)?;
        let of_grid = (rows - offset).div_ceil(every) as f64;
        if on as f64 >= MIN_ON_GRID * places.len() as f64 && on as f64 >= MIN_OF_GRID * of_grid {
            let repair = Repair::EveryRow { every, offset };
            let mut marked = vec![false; rows];
            repair.set_aside([&[]; 3], &mut marked);
            let (share, gain) = explained(events);
            return of_marked(repair, &marked, share, gain);
        }
    }
    None
}

/// Every second row is of something else: one half of the rows is smooth, and all together are not.
fn alternating(numbers: [&[f64]; 3]) -> Option<(Breakage, f64)> {
    let rows = numbers[0].len();
    let of = |offset: usize, step: usize| -> f64 {
        numbers.iter().map(|axis| path(axis.iter().skip(offset).step_by(step).copied())).sum()
    };
    let (all, even, odd) = (of(0, 1), of(0, 2), of(1, 2));
    // The rows that are wrong: those that never change, or the rougher ones. Two halves that are alike are a sensor that turns half a
    // turn from row to row.
    let (offset, smooth) = match (even, odd) {
        (even, odd) if even == 0.0 || (odd > 0.0 && even >= MIN_ROUGHER * odd) => (0, odd),
        (even, odd) if odd == 0.0 || even * MIN_ROUGHER <= odd => (1, even),
        _ => return None,
    };
    if !(smooth > 0.0 && all >= MIN_ALTERNATING_PATH * smooth) {
        return None;
    }
    // One row that is far off makes a path as long, and is in one half of the rows: here they go there and back all along.
    let usual =
        |offset: usize, step: usize| usual_way(numbers.map(|axis| axis.iter().skip(offset).step_by(step)));
    if usual(0, 1) < 0.5 * MIN_ALTERNATING_PATH * usual(1 - offset, 2) {
        return None;
    }
    let kept: [Vec<f64>; 3] = numbers.map(|axis| axis.iter().skip(1 - offset).step_by(2).copied().collect());
    // An axis that hardly moves is noise within its own range: its steps are small next to the field's.
    let widest = kept.iter().map(|axis| half_range(axis)).fold(0.0, f64::max);
    let continuous = kept.iter().all(|axis| usual_step(axis) <= MAX_STEP_SHARE * widest);
    // Rows that turn far from one to the next are on one ellipsoid anyway. Readings in a plane have none that could tell.
    let before = misfit(&points(rows, |row, axis| numbers[axis][row]));
    let after = misfit(&points(kept[0].len(), |row, axis| kept[axis][row]));
    if before.zip(after).is_some_and(|(before, after)| after > MAX_MISFIT_SHARE * before) {
        return None;
    }
    let repair = Repair::EveryRow { every: 2, offset };
    let mut marked = vec![false; rows];
    repair.set_aside(numbers, &mut marked);
    continuous.then(|| of_marked(repair, &marked, 1.0 - smooth / all, all - smooth)).flatten()
}

/// The median way from one row to the next, over all axes.
fn usual_way<'v>([x, y, z]: [impl Iterator<Item = &'v f64>; 3]) -> f64 {
    let rows: Vec<[f64; 3]> = x.zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]).collect();
    let ways =
        rows.windows(2).map(|pair| (0..3).map(|axis| (pair[1][axis] - pair[0][axis]).abs()).sum::<f64>());
    let mut ways: Vec<f64> = ways.filter(|way| way.is_finite()).collect();
    if ways.is_empty() { 0.0 } else { median(&mut ways) }
}

/// An axis that keeps its value while the others go on, and then catches up.
fn frozen(numbers: [&[f64]; 3], widest: f64) -> Option<(Breakage, f64)> {
    let rows = numbers[0].len();
    let mut best: Option<(Breakage, f64)> = None;
    for axis in 0..3 {
        let others = [(axis + 1) % 3, (axis + 2) % 3].map(|other| numbers[other]);
        let others_step = others.map(usual_step);
        let own = numbers[axis];
        let least_jump = (MIN_CATCH_UP_STEPS * usual_step(own)).max(MIN_CATCH_UP_SHARE * widest);
        let (mut stretches, mut caught_up) = (Vec::new(), 0.0);
        let mut from = 0;
        while from < rows {
            let to = own[from..].iter().position(|value| *value != own[from]).map_or(rows, |n| from + n);
            // A spike goes back; what caught up goes on from there.
            let jump = match (own.get(to), own.get(to + 1)) {
                (Some(next), Some(behind)) => (next - own[from]).abs().min((behind - own[from]).abs()),
                _ => 0.0,
            };
            let moved = others.iter().zip(others_step).any(|(other, step)| {
                let least = MIN_CATCH_UP_STEPS * step.max(0.02 * widest);
                step > 0.0 && (other[to - 1] - other[from]).abs() >= least
            });
            if to - from >= MIN_FROZEN_ROWS && moved && jump >= least_jump {
                stretches.push((from + 1, to));
                caught_up += jump;
            }
            from = to;
        }
        if stretches.len() < MIN_EVENTS {
            continue;
        }
        let usual = stretches.len() as f64 * usual_step(own);
        let repair = Repair::FrozenAxis { axis, stretches };
        let mut marked = vec![false; rows];
        repair.set_aside(numbers, &mut marked);
        let found = of_marked(repair, &marked, 1.0 - usual / caught_up, caught_up);
        if found.as_ref().map_or(0, |(f, _)| f.rows) > best.as_ref().map_or(0, |(b, _)| b.rows) {
            best = found;
        }
    }
    best
}
