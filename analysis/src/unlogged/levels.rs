//! An offset that jumps more often than a calibration has steps: the times and the offset of each stretch between two jumps.
//!
//! The jumps are found one by one on a grid of cells, each where it lowers the squares most, with the matrix and the offsets of all
//! stretches free; after each, all of them are moved to their best places. What competes with them is an offset that wanders.

use crate::bounds::MIN_ODDS;
use crate::unlogged::linear::{BASE, Normal, Row};
use crate::unlogged::recordings::{eliminated, offsets};
use crate::unlogged::switching::{thinned, wandered, with_offsets};
use serde::Serialize;

/// Jumps at most.
const MOST_JUMPS: usize = 8;
/// Cells of the grid: a jump within a cell looks like two.
const CELLS: usize = 4000;
/// Every so many cells a jump is looked for at first.
const COARSE: usize = 20;
/// Cells of a stretch at least: fewer samples determine no offset.
const FEWEST_CELLS: usize = 60;
/// Fewer samples say little of several offsets.
const FEWEST_SAMPLES: usize = 500;
/// Samples of a log that are looked at.
const MOST_SAMPLES: usize = 20_000;
/// Samples that jumps are dropped by.
const MOST_TO_PRUNE: usize = 4000;
/// Rounds in which the jumps move to their best places.
const ROUNDS: usize = 3;

/// An offset with jumps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Levels {
    /// When it jumps, s.
    pub at_s: Vec<f64>,
    /// By how much it changes at each of them, in the sensor's axes, µT.
    pub change_ut: Vec<[f64; 3]>,
    /// Standard errors of the changes, µT.
    pub std_errors_ut: Vec<[f64; 3]>,
    /// The error before, rms, µT, …
    pub before_rms_ut: f64,
    /// … and with an offset for each stretch.
    pub rms_ut: f64,
}

/// Sums up to each bound of a cell.
struct Cells(Vec<Normal<BASE>>);

impl Cells {
    fn of(rows: &[Row]) -> Self {
        let mut sum = Normal::default();
        let mut list = vec![sum.clone()];
        for cell in 0..CELLS {
            for row in &rows[bound(cell, rows.len())..bound(cell + 1, rows.len())] {
                sum.add(&row.base, row.residual_ut);
            }
            list.push(sum.clone());
        }
        Cells(list)
    }

    fn between(&self, from: usize, to: usize) -> Normal<BASE> {
        let (low, high) = (&self.0[from], &self.0[to]);
        Normal {
            matrix: high.matrix - low.matrix,
            right: high.right - low.right,
            squares: high.squares - low.squares,
        }
    }

    /// The squares that remain with an offset for each stretch and one matrix; infinite where a stretch determines none.
    fn left(&self, cuts: &[usize]) -> f64 {
        let mut bounds = cuts.to_vec();
        bounds.sort_unstable();
        bounds.insert(0, 0);
        bounds.push(CELLS);
        if bounds.windows(2).any(|pair| pair[1] < pair[0] + FEWEST_CELLS) {
            return f64::INFINITY;
        }
        let stretches: Vec<Normal<BASE>> =
            bounds.windows(2).map(|pair| self.between(pair[0], pair[1])).collect();
        let squares = || {
            let (shared, blocks) = eliminated(&stretches)?;
            let own: f64 = blocks.iter().map(|block| block.taken()).sum();
            let whole: f64 = stretches.iter().map(|one| one.squares).sum();
            let step = shared.solve()?.0;
            Some(whole - own + shared.right.dot(&step))
        };
        squares().filter(|left| left.is_finite() && *left > 0.0).unwrap_or(f64::INFINITY)
    }

    /// The best place for one of the cuts, the others held.
    fn best(&self, cuts: &[usize], place: usize) -> (f64, usize) {
        let mut cuts = cuts.to_vec();
        let mut best = (f64::INFINITY, cuts[place]);
        let mut look = |cells: &mut dyn Iterator<Item = usize>| {
            for cell in cells {
                cuts[place] = cell;
                let left = self.left(&cuts);
                if left < best.0 {
                    best = (left, cell);
                }
            }
            best.1
        };
        let near = look(&mut (FEWEST_CELLS..CELLS - FEWEST_CELLS).step_by(COARSE));
        look(&mut (near.saturating_sub(COARSE)..(near + COARSE).min(CELLS)));
        best
    }
}

fn bound(cell: usize, samples: usize) -> usize {
    samples * cell / CELLS
}

/// Where the offset jumps, if it jumps more than `known` times. `corrected_ut` is corrected by a calibration with this matrix and field.
pub fn levels(
    time_s: &[f64],
    corrected_ut: &[[f64; 3]],
    matrix: &[[f64; 3]; 3],
    field_ut: f64,
    known: usize,
) -> Option<Levels> {
    if corrected_ut.len() != time_s.len() || corrected_ut.len() < FEWEST_SAMPLES {
        return None;
    }
    let (time_s, corrected_ut) = (thinned(time_s, MOST_SAMPLES), thinned(corrected_ut, MOST_SAMPLES));
    let rows: Vec<Row> = corrected_ut.iter().filter_map(|h| Row::of(*h, field_ut)).collect();
    if rows.len() != corrected_ut.len() {
        return None;
    }
    let cells = Cells::of(&rows);
    let n = rows.len() as f64;
    // Three coefficients, and a place among the cells.
    let price = 3.0 * n.ln() + 2.0 * (CELLS as f64).ln();
    let mut cuts: Vec<usize> = Vec::new();
    let mut left = cells.left(&cuts);
    while cuts.len() < MOST_JUMPS {
        let mut next = cuts.clone();
        next.push(0);
        let mut squares = left;
        for round in 0..ROUNDS {
            // The new one first.
            for place in (0..next.len()).rev() {
                if round > 0 || place + 1 == next.len() {
                    (squares, next[place]) = cells.best(&next, place);
                }
            }
        }
        if !(n * (left / squares).ln() > price + MIN_ODDS) {
            break;
        }
        (cuts, left) = (next, squares);
    }
    cuts.sort_unstable();
    let few = thinned(&corrected_ut, MOST_TO_PRUNE);
    prune(&mut cuts, &few, (matrix, field_ut), (price + MIN_ODDS) / n);
    if cuts.len() <= known || cuts.len() < 2 {
        return None;
    }
    let mut bounds: Vec<usize> = cuts.iter().map(|cell| bound(*cell, rows.len())).collect();
    let mut found = offsets(&stretches(&corrected_ut, &bounds), matrix, field_ut)?;
    if found.recordings.len() != bounds.len() + 1 {
        return None;
    }
    // To the sample: each on the side whose offset fits it better.
    let change = |at: usize| {
        let own = found.recordings[at].offset_change_ut;
        matrix.each_ref().map(|row| dot(*row, own))
    };
    let width = (rows.len() / CELLS).max(1);
    for (at, place) in bounds.iter_mut().enumerate() {
        let [before, after] = [change(at), change(at + 1)].map(|offset| {
            move |h: &[f64; 3]| {
                let moved = minus(*h, offset);
                (dot(moved, moved).sqrt() - field_ut).powi(2)
            }
        });
        let (low, high) = (place.saturating_sub(2 * width), (*place + 2 * width).min(rows.len()));
        let mut gain = 0.0;
        let mut best = (f64::INFINITY, *place);
        for sample in low..high {
            if gain < best.0 {
                best = (gain, sample);
            }
            gain += before(&corrected_ut[sample]) - after(&corrected_ut[sample]);
        }
        *place = best.1;
    }
    let parts = stretches(&corrected_ut, &bounds);
    if let Some(finer) =
        offsets(&parts, matrix, field_ut).filter(|finer| finer.recordings.len() == parts.len())
    {
        found = finer;
    }
    let list = &found.recordings;
    let largest = list.windows(2).map(|pair| minus(pair[1].offset_change_ut, pair[0].offset_change_ut));
    let largest = largest.max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)))?;
    let along = matrix.each_ref().map(|row| dot(*row, largest));
    let stretch = |sample: usize| [(bounds.partition_point(|bound| *bound <= sample), 1.0), (0, 0.0)];
    let own = with_offsets(&corrected_ut, field_ut, bounds.len(), stretch)? + price * cuts.len() as f64;
    if wandered(&corrected_ut, field_ut, &time_s, along)? - own < MIN_ODDS {
        return None;
    }
    let pairs = || list.windows(2).map(|pair| (&pair[0], &pair[1]));
    Some(Levels {
        at_s: bounds.iter().map(|place| time_s[*place]).collect(),
        change_ut: pairs().map(|(a, b)| minus(b.offset_change_ut, a.offset_change_ut)).collect(),
        std_errors_ut: pairs()
            .map(|(a, b)| std::array::from_fn(|axis| a.std_errors_ut[axis].hypot(b.std_errors_ut[axis])))
            .collect(),
        before_rms_ut: found.common_rms_ut,
        rms_ut: found.rms_ut,
    })
}

/// Drops jumps that only make up for what is not linear in the others: without them the exact fit is as good. `worth` is the fall of ln of the
/// squares, per sample, that a jump is worth.
fn prune(
    cuts: &mut Vec<usize>,
    corrected_ut: &[[f64; 3]],
    (matrix, field_ut): (&[[f64; 3]; 3], f64),
    worth: f64,
) {
    let squares = |cuts: &[usize]| {
        let bounds: Vec<usize> = cuts.iter().map(|cell| bound(*cell, corrected_ut.len())).collect();
        match offsets(&stretches(corrected_ut, &bounds), matrix, field_ut) {
            Some(found) if found.recordings.len() == bounds.len() + 1 => found.rms_ut.powi(2),
            _ => f64::INFINITY,
        }
    };
    let mut left = squares(cuts);
    while cuts.len() > 1 {
        let without = |place: usize| {
            let mut fewer = cuts.clone();
            fewer.remove(place);
            (squares(&fewer), fewer)
        };
        let Some((squares, fewer)) = (0..cuts.len()).map(without).min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return;
        };
        if !((squares / left).ln() < worth) {
            return;
        }
        (*cuts, left) = (fewer, squares);
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn stretches(corrected_ut: &[[f64; 3]], bounds: &[usize]) -> Vec<Vec<[f64; 3]>> {
    let ends = bounds.iter().copied().chain([corrected_ut.len()]);
    let mut from = 0;
    let mut list = Vec::with_capacity(bounds.len() + 1);
    for to in ends {
        list.push(corrected_ut[from.min(to)..to].to_vec());
        from = to;
    }
    list
}
