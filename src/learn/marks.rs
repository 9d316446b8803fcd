//! Where the offset may have jumped: snapshots of running sums, from which the fit with a jump there follows exactly.
//!
//! A jump at some row has the columns of the offset, from that row on. Their sums are those of all rows less those before it, so
//! that a copy of the offset's rows of the normal matrix is all that a possible jump costs, and nothing a sample.

use super::blocks::{Blocks, first_to_end};
use super::layout::{ENTRIES, STEP, STREAMED};
use super::point::BASE;
use super::solve::{Chosen, Factor};
use super::sums::{Work, at};

/// Snapshots that are kept.
const MARKS: usize = 4;
/// No place among them.
const NONE: u8 = u8::MAX;
/// A mark is looked at with so many rows before and after it, so early that none gives way before, ...
const LEAST_ROWS: u32 = 48;
/// ... and a step is one with at least that part of all rows before and after it.
const LEAST_SHARE: u32 = 50;
/// Rows between two.
pub(super) const EVERY: u32 = 32;

/// The offset's rows of the sums of all samples before some sample.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    rows: u32,
    /// Of that sample, ms of the board's clock.
    pub(super) t_ms: u32,
    cross: [[f32; STREAMED]; 3],
    right: [f32; 3],
}

const NO_MARK: Mark = Mark { rows: 0, t_ms: 0, cross: [[0.0; STREAMED]; 3], right: [0.0; 3] };

/// A few moments, spread like the logarithm of how long ago they were, and the one at which a jump explains most.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    marks: [Mark; MARKS],
    used: u8,
    /// Its place, or none's.
    best: u8,
    /// The best is that of a step in use, and stays.
    pub(super) pinned: bool,
}

impl Marks {
    pub(super) const fn new() -> Self {
        Self { marks: [NO_MARK; MARKS], used: 0, best: NONE, pinned: false }
    }

    pub(super) fn clear(&mut self) {
        (self.used, self.best, self.pinned) = (0, NONE, false);
    }

    /// The moment at which a jump explains most.
    pub(super) fn best(&self) -> Option<&Mark> {
        self.marks.get(usize::from(self.best)).filter(|_| self.best < self.used)
    }

    /// Whether there is a step to be tested, of so many rows in all.
    pub(super) fn has_step(&self, rows: u32) -> bool {
        let margin = LEAST_ROWS.max(rows / LEAST_SHARE);
        self.best().is_some_and(|mark| mark.rows >= margin && rows.saturating_sub(mark.rows) >= margin)
    }

    /// Takes a snapshot before the next row, at the time `t_ms`; the one that is missed least gives way.
    pub(super) fn take(&mut self, blocks: &Blocks<STREAMED, ENTRIES>, t_ms: u32) {
        let rows = blocks.rows();
        if !self.pinned {
            self.look(blocks);
        }
        if usize::from(self.used) == MARKS {
            let mut least: Option<(f32, usize)> = None;
            for index in 0..MARKS {
                if index == usize::from(self.best) {
                    continue;
                }
                let at = |index: usize| self.marks.get(index).map_or(rows, |mark| mark.rows);
                let before = if index == 0 { 0 } else { at(index - 1) };
                let gap = at(index + 1).saturating_sub(before) as f32
                    / (rows.saturating_sub(at(index)).max(1)) as f32;
                if least.is_none_or(|(known, _)| gap < known) {
                    least = Some((gap, index));
                }
            }
            let Some((_, index)) = least else { return };
            if let Some(rest) = self.marks.get_mut(index..) {
                first_to_end(rest);
            }
            self.used -= 1;
            if self.best != NONE && usize::from(self.best) > index {
                self.best -= 1;
            }
        }
        let Some(mark) = self.marks.get_mut(usize::from(self.used)) else { return };
        (mark.rows, mark.t_ms) = (rows, t_ms);
        (mark.cross, mark.right) = so_far(blocks);
        self.used += 1;
    }

    /// Finds the best one.
    fn look(&mut self, blocks: &Blocks<STREAMED, ENTRIES>) {
        let mut work = Work::new();
        blocks.iter().for_each(|block| work.merge(block));
        let Some(base) = Factor::of(&work, Chosen::base(BASE), false) else { return };
        let mut best: Option<(f32, u8)> = None;
        let rows = blocks.rows();
        for (index, mark) in self.marks.iter().enumerate().take(usize::from(self.used)) {
            if mark.rows < LEAST_ROWS || rows - mark.rows < LEAST_ROWS {
                continue;
            }
            work_with(&mut work, &since(blocks, mark));
            let gained = base.test(&work, STEP, 3, false);
            if best.is_none_or(|(known, _)| gained.decrease > known) {
                best = Some((gained.decrease, index as u8));
            }
        }
        self.best = best.map_or(NONE, |(_, index)| index);
    }

    /// Puts the columns of the best jump beside the sums of all rows.
    pub(super) fn beside_total(&self, blocks: &Blocks<STREAMED, ENTRIES>, work: &mut Work) {
        if let Some(mark) = self.best() {
            work_with(work, &since(blocks, mark));
        }
    }

    /// The same of one block.
    pub(super) fn beside_block(&self, blocks: &Blocks<STREAMED, ENTRIES>, index: usize, work: &mut Work) {
        let Some(mark) = self.best() else { return };
        let begin = blocks.rows_before(index);
        let Some(block) = blocks.iter().nth(index) else { return };
        if mark.rows <= begin {
            work_with(work, &of(block));
        } else if mark.rows < begin + block.rows {
            // What came after the mark, less the later blocks.
            let (mut cross, mut right) = since(blocks, mark);
            for later in blocks.iter().skip(index + 1) {
                let (c, r) = of(later);
                subtract(&mut cross, &mut right, &c, &r);
            }
            work_with(work, &(cross, right));
        }
    }

    /// The snapshots about another point: streamed columns and the best step moved by `delta`.
    pub(super) fn shift(&mut self, delta: &[f32]) {
        let best = self.best().map(|best| (best.rows, offset_part(&best.cross)));
        for mark in self.marks.iter_mut().take(usize::from(self.used)) {
            for (right, cross) in mark.right.iter_mut().zip(&mark.cross) {
                *right += cross.iter().zip(delta).map(|(a, b)| a * b).sum::<f32>();
            }
            if let Some((rows, before)) = best
                && mark.rows > rows
            {
                let own = offset_part(&mark.cross);
                for axis in 0..3 {
                    for other in 0..3 {
                        let d = delta.get(STEP + other).copied().unwrap_or(0.0);
                        mark.right[axis] += (own[axis][other] - before[axis][other]) * d;
                    }
                }
            }
        }
    }
}

type Rows = ([[f32; STREAMED]; 3], [f32; 3]);

fn offset_part(cross: &[[f32; STREAMED]; 3]) -> [[f32; 3]; 3] {
    cross.map(|row| [row[0], row[1], row[2]])
}

/// The offset's rows of one block.
fn of(block: &super::sums::Sums<STREAMED, ENTRIES>) -> Rows {
    (
        core::array::from_fn(|axis| core::array::from_fn(|column| block.entry(axis, column))),
        core::array::from_fn(|axis| block.right(axis)),
    )
}

fn so_far(blocks: &Blocks<STREAMED, ENTRIES>) -> Rows {
    let (mut cross, mut right) = ([[0.0; STREAMED]; 3], [0.0; 3]);
    for block in blocks.iter().filter(|block| block.rows > 0) {
        let (c, r) = of(block);
        for axis in 0..3 {
            cross[axis].iter_mut().zip(&c[axis]).for_each(|(sum, value)| *sum += value);
            right[axis] += r[axis];
        }
    }
    (cross, right)
}

fn since(blocks: &Blocks<STREAMED, ENTRIES>, mark: &Mark) -> Rows {
    let (mut cross, mut right) = so_far(blocks);
    subtract(&mut cross, &mut right, &mark.cross, &mark.right);
    (cross, right)
}

fn subtract(cross: &mut [[f32; STREAMED]; 3], right: &mut [f32; 3], c: &[[f32; STREAMED]; 3], r: &[f32; 3]) {
    for axis in 0..3 {
        cross[axis].iter_mut().zip(&c[axis]).for_each(|(sum, value)| *sum -= value);
        right[axis] -= r[axis];
    }
}

/// Writes the columns of a step.
fn work_with(work: &mut Work, (cross, right): &Rows) {
    for (axis, (row, value)) in cross.iter().zip(right).enumerate() {
        for (column, entry) in row.iter().enumerate() {
            if let Some(slot) = work.entries.get_mut(at(STEP + axis, column)) {
                *slot = *entry;
            }
        }
        for (other, entry) in row.iter().take(axis + 1).enumerate() {
            if let Some(slot) = work.entries.get_mut(at(STEP + axis, STEP + other)) {
                *slot = *entry;
            }
        }
        if let Some(slot) = work.right.get_mut(STEP + axis) {
            *slot = *value;
        }
    }
}
