//! Where the offset may have jumped: snapshots of running sums, from which the fit with a jump there follows exactly.
//!
//! A jump at some row has the columns of the offset, from that row on. Their sums are those of all rows less those before it, so
//! that a copy of the offset's rows of the normal matrix is all that a possible jump costs, and nothing a sample. Between two
//! snapshots the moment follows from what the fit leaves there ([`Marks::settle`]).

use super::blocks::{Blocks, first_to_end};
use super::cross::Cross;
use super::jump::{At, Base};
use super::layout::{ENTRIES, STEP, STREAMED};
use super::solve::{Chosen, Factor};
use super::sums::{Sums, Work};

/// Snapshots that are kept.
const MARKS: usize = 5;
/// No place among them.
const NONE: u8 = u8::MAX;
/// A mark is looked at with so many rows before and after it, so early that none gives way before, ...
const LEAST_ROWS: u32 = 48;
/// ... and a step is one with at least that part of all rows before and after it.
const LEAST_SHARE: u32 = 50;
/// Rows between two.
pub(super) const EVERY: u32 = 32;
/// A jump that takes this share off the squared error is one; its neighbours are kept, too.
const FIRM: f32 = 0.2;

/// The sums of all samples before some sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    rows: u32,
    /// Of that sample, ms of the board's clock, its lower half: it wraps after 49.7 days.
    t_ms: u32,
    cross: Cross,
}

const NO_MARK: Mark = Mark { rows: 0, t_ms: 0, cross: Cross::NONE };

/// A few moments, spread like the logarithm of how long ago they were, and the one at which a jump explains most.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    marks: [Mark; MARKS],
    used: u8,
    /// The place of the best, or none's.
    best: u8,
    /// The jump at the best is one, so that the marks beside it stay.
    firm: bool,
    /// The best is that of a step in use, and stays.
    pub(super) pinned: bool,
    /// Where the jump is: so much of the way to the next mark, or, negative, to the one before.
    part: f32,
    /// The residual's sum between the earlier of these two and the jump.
    before: [f32; 3],
}

impl Marks {
    pub(super) const fn new() -> Self {
        Self {
            marks: [NO_MARK; MARKS],
            used: 0,
            best: NONE,
            firm: false,
            pinned: false,
            part: 0.0,
            before: [0.0; 3],
        }
    }

    pub(super) fn clear(&mut self) {
        (self.used, self.best, self.firm, self.pinned) = (0, NONE, false, false);
        (self.part, self.before) = (0.0, [0.0; 3]);
    }

    fn mark(&self, place: usize) -> Option<&Mark> {
        self.marks.get(place).filter(|_| place < usize::from(self.used))
    }

    /// The marks on both sides of the jump, and how much of the way it is from the first.
    fn sides(&self) -> Option<(&Mark, &Mark, f32)> {
        let best = usize::from(self.best);
        let here = self.mark(best)?;
        if self.part < 0.0 {
            Some((self.mark(best.checked_sub(1)?)?, here, 1.0 + self.part))
        } else if self.part > 0.0 {
            Some((here, self.mark(best + 1)?, self.part))
        } else {
            None
        }
    }

    /// The jump that explains most.
    fn best(&self) -> Option<At> {
        let here = self.mark(usize::from(self.best))?;
        let Some((first, second, share)) = self.sides() else {
            return Some(At { rows: here.rows, t_ms: here.t_ms, cross: here.cross });
        };
        let between = |a: u32, b: u32| a.wrapping_add((share * b.wrapping_sub(a) as f32) as u32);
        let mut cross = first.cross;
        cross.add(&second.cross.less(&first.cross), share);
        let [x, y, z] = first.cross.right();
        let [p, q, r] = self.before;
        cross.set_right([x + p, y + q, z + r]);
        Some(At { rows: between(first.rows, second.rows), t_ms: between(first.t_ms, second.t_ms), cross })
    }

    /// Its moment, ms of the board's clock; `last_ms` is that of the last sample.
    pub(super) fn best_ms(&self, last_ms: u64) -> Option<u64> {
        let ago_ms = (last_ms as u32).wrapping_sub(self.best()?.t_ms);
        Some(last_ms.saturating_sub(u64::from(ago_ms)))
    }

    /// Whether there is a jump beyond doubt.
    pub(super) fn is_firm(&self) -> bool {
        self.firm
    }

    /// Whether there is a step to be tested, of so many rows in all.
    pub(super) fn has_step(&self, rows: u32) -> bool {
        let margin = LEAST_ROWS.max(rows / LEAST_SHARE);
        self.best().is_some_and(|best| best.rows >= margin && rows.saturating_sub(best.rows) >= margin)
    }

    /// Takes a snapshot before the next row, at the time `t_ms`; the one that is missed least gives way.
    pub(super) fn take(&mut self, blocks: &Blocks<STREAMED, ENTRIES>, t_ms: u32) {
        if self.pinned {
            return;
        }
        let (rows, now) = (blocks.rows(), so_far(blocks));
        self.look(blocks, &now);
        if usize::from(self.used) == MARKS {
            let mut least: Option<(f32, usize)> = None;
            for index in 0..MARKS {
                let from_best = index.abs_diff(usize::from(self.best));
                if from_best == 0 || (self.firm && from_best == 1) {
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
            if index.abs_diff(usize::from(self.best)) == 1 {
                self.part = 0.0;
            }
            if let Some(rest) = self.marks.get_mut(index..) {
                first_to_end(rest);
            }
            self.used -= 1;
            if self.best != NONE && usize::from(self.best) > index {
                self.best -= 1;
            }
        }
        let Some(mark) = self.marks.get_mut(usize::from(self.used)) else { return };
        *mark = Mark { rows, t_ms, cross: now };
        self.used += 1;
    }

    /// Finds the best one.
    fn look(&mut self, blocks: &Blocks<STREAMED, ENTRIES>, now: &Cross) {
        let Some(base) = Base::of(blocks) else { return };
        let mut best: Option<(f32, u8)> = None;
        let rows = blocks.rows();
        for (index, mark) in self.marks.iter().enumerate().take(usize::from(self.used)) {
            if mark.rows < LEAST_ROWS || rows.saturating_sub(mark.rows) < LEAST_ROWS {
                continue;
            }
            let decrease = base.decrease(&now.less(&mark.cross));
            if best.is_none_or(|(known, _)| decrease > known) {
                best = Some((decrease, index as u8));
            }
        }
        let (decrease, place) = best.unwrap_or((0.0, NONE));
        if place != self.best {
            (self.best, self.part) = (place, 0.0);
        }
        self.firm = decrease > FIRM * base.left;
    }

    /// Finds the moment of the jump between the marks, beside all columns that were `chosen` (those of the jump among them).
    ///
    /// With coefficients `δ` of the others and `θ` of the jump, what they leave of the samples between two marks is noise before
    /// the jump and `−uθ` after it: the sums tell how much of the way that is. Where it is no jump that is not so, and less than
    /// the sensor's own noise may seem to be left: then the jump stays where the mark is. `least_variance` is what noise leaves of a
    /// sample at least.
    pub(super) fn settle(&mut self, blocks: &Blocks<STREAMED, ENTRIES>, chosen: Chosen, least_variance: f32) {
        if self.pinned || !self.firm {
            return;
        }
        self.move_to_the_jump(blocks, chosen);
        let mut work = Work::new();
        blocks.iter().for_each(|block| work.merge(block));
        self.beside_total(blocks, &mut work);
        let left = Factor::of(&work, chosen, true).map_or(0.0, |factor| factor.squares(&work));
        if !(left >= least_variance * work.rows as f32) {
            (self.part, self.before) = (0.0, [0.0; 3]);
        }
    }

    #[inline(never)]
    fn move_to_the_jump(&mut self, blocks: &Blocks<STREAMED, ENTRIES>, chosen: Chosen) {
        let best = usize::from(self.best);
        // The coefficients move with the moment, and it with them.
        for _ in 0..3 {
            let mut work = Work::new();
            blocks.iter().for_each(|block| work.merge(block));
            self.beside_total(blocks, &mut work);
            let Some(factor) = Factor::of(&work, chosen, true) else { return };
            let delta = factor.step(&work);
            let variance = factor.squares(&work) / (work.rows as f32 - chosen.len() as f32).max(1.0);
            let theta: [f32; 3] = core::array::from_fn(|axis| delta.get(STEP + axis).copied().unwrap_or(0.0));
            // How much of the way from one mark to the next is behind the jump.
            let behind = |first: &Mark, second: &Mark| -> Option<f32> {
                let between = second.cross.less(&first.cross);
                let (own, base, right) = (between.own(), between.along(&delta), between.right());
                let dot = |v: [f32; 3]| v.iter().zip(&theta).map(|(a, b)| a * b).sum::<f32>();
                let size = dot(own.map(dot));
                let left = dot(core::array::from_fn(|axis| right[axis] + base[axis]));
                // Where it would hardly be seen, nothing is said.
                (size > 4.0 * variance).then(|| (-left / size).clamp(0.0, 1.0))
            };
            let Some(here) = self.mark(best) else { return };
            let earlier = best.checked_sub(1).and_then(|place| self.mark(place));
            let later = self.mark(best + 1);
            let length = |a: &Mark, b: &Mark| b.rows.saturating_sub(a.rows) as f32;
            let mut place = 0.0;
            if let Some(earlier) = earlier
                && let Some(behind) = behind(earlier, here)
            {
                place -= behind * length(earlier, here);
            }
            if let Some(later) = later
                && let Some(behind) = behind(here, later)
            {
                place += (1.0 - behind) * length(here, later);
            }
            let side = if place < 0.0 {
                earlier.map(|mark| length(mark, here))
            } else {
                later.map(|mark| length(here, mark))
            };
            let part = side.map_or(0.0, |length| (place / length.max(1.0)).clamp(-0.999, 0.999));
            self.part = part;
            let before = self.sides().map_or([0.0; 3], |(first, second, share)| {
                second.cross.less(&first.cross).along(&delta).map(|value| -share * value)
            });
            self.before = before;
        }
    }

    /// Puts the columns of the best jump beside the sums of all rows.
    pub(super) fn beside_total(&self, blocks: &Blocks<STREAMED, ENTRIES>, work: &mut Work) {
        if let Some(best) = self.best() {
            so_far(blocks).less(&best.cross).write(work);
        }
    }

    /// The same of one block.
    pub(super) fn beside_block(&self, blocks: &Blocks<STREAMED, ENTRIES>, index: usize, work: &mut Work) {
        let Some(best) = self.best() else { return };
        let begin = blocks.rows_before(index);
        let Some(block) = blocks.iter().nth(index) else { return };
        if best.rows <= begin {
            let mut own = Cross::NONE;
            own.add_block(block);
            own.write(work);
        } else if best.rows < begin + block.rows {
            // What came after the jump, less the later blocks.
            let mut since = so_far(blocks).less(&best.cross);
            let mut later = Cross::NONE;
            blocks.iter().skip(index + 1).for_each(|block| later.add_block(block));
            since.add(&later, -1.0);
            since.write(work);
        }
    }

    /// The oldest block leaves the sums. What happened within it happened before all rows that are left.
    pub(super) fn forget(&mut self, oldest: &Sums<STREAMED, ENTRIES>) {
        let mut cross = Cross::NONE;
        cross.add_block(oldest);
        let gone =
            self.marks.iter().take(usize::from(self.used)).filter(|mark| mark.rows <= oldest.rows).count()
                as u8;
        for _ in 0..gone {
            first_to_end(&mut self.marks);
        }
        self.used -= gone;
        for mark in self.marks.iter_mut().take(usize::from(self.used)) {
            mark.rows -= oldest.rows;
            mark.cross.add(&cross, -1.0);
        }
        match self.best.checked_sub(gone) {
            Some(best) if self.best != NONE => {
                if best == 0 && self.part < 0.0 {
                    // The mark on its other side is gone.
                    (self.part, self.before) = (0.0, [0.0; 3]);
                }
                self.best = best;
            }
            _ => {
                (self.best, self.firm, self.pinned) = (NONE, false, false);
                (self.part, self.before) = (0.0, [0.0; 3]);
            }
        }
    }

    /// An effect's column is held against another value, by `times` further.
    pub(super) fn hold_against(&mut self, effect: usize, times: f32) {
        self.marks.iter_mut().for_each(|mark| mark.cross.take_off_offset(effect, times));
    }

    /// The snapshots about another point: streamed columns and the best step moved by `delta`.
    pub(super) fn shift(&mut self, delta: &[f32]) {
        let best = self.best().map(|best| (best.rows, best.cross.own()));
        let step: [f32; 3] = core::array::from_fn(|axis| delta.get(STEP + axis).copied().unwrap_or(0.0));
        if let Some((first, second, share)) = self.sides() {
            let more = second.cross.less(&first.cross).along(delta);
            self.before = core::array::from_fn(|axis| self.before[axis] + share * more[axis]);
        }
        for mark in self.marks.iter_mut().take(usize::from(self.used)) {
            let (mut right, more, own) = (mark.cross.right(), mark.cross.along(delta), mark.cross.own());
            for axis in 0..3 {
                right[axis] += more[axis];
                if let Some((rows, before)) = best
                    && mark.rows > rows
                {
                    right[axis] += (0..3)
                        .map(|other| (own[axis][other] - before[axis][other]) * step[other])
                        .sum::<f32>();
                }
            }
            mark.cross.set_right(right);
        }
    }
}

fn so_far(blocks: &Blocks<STREAMED, ENTRIES>) -> Cross {
    let mut sum = Cross::NONE;
    blocks.iter().filter(|block| block.rows > 0).for_each(|block| sum.add_block(block));
    sum
}
