//! Where the offset may have jumped: snapshots of running sums, from which the fit with a jump there follows exactly.
//!
//! A jump at some row has the columns of the offset, from that row on. Their sums are those of all rows less those before it, so
//! that a copy of the offset's sums is all that a possible jump costs, and nothing a sample.

use super::blocks::{Block, Blocks, first_to_end};
use super::bounds::{FIRM_SHARE, LEAST_JUMP_ROWS, LEAST_JUMP_SHARE, MIN_DIRECTION};
use super::point::BASE;
use super::sums::{Jump, STEP, Sums, WIDEST, Work};
use crate::study::{Factor, Normal, Role};

/// Snapshots that are kept.
const MARKS: usize = 5;
/// Rows between two.
pub(super) const EVERY: u32 = 32;

/// A moment, with the sums of all samples before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    rows: u32,
    /// ms of the board's clock, its lower half: it wraps after 49.7 days.
    t_ms: u32,
    before: Jump,
}

const NO_MARK: Mark = Mark { rows: 0, t_ms: 0, before: Jump::NONE };

/// A few moments, spread like the logarithm of how long ago they were, and the one at which a jump explains most.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    marks: [Mark; MARKS],
    used: u8,
    /// The place of the best.
    best: Option<u8>,
    /// The jump at the best is one, so that the marks next to it stay.
    firm: bool,
    /// The best is that of a step in use, and stays.
    pub(super) pinned: bool,
}

impl Marks {
    pub(super) const fn new() -> Self {
        Self { marks: [NO_MARK; MARKS], used: 0, best: None, firm: false, pinned: false }
    }

    pub(super) fn clear(&mut self) {
        (self.used, self.best, self.firm, self.pinned) = (0, None, false, false);
    }

    fn used(&self) -> &[Mark] {
        self.marks.get(..usize::from(self.used)).unwrap_or_default()
    }

    /// The jump that explains most.
    fn best(&self) -> Option<&Mark> {
        self.used().get(usize::from(self.best?))
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
        let margin = LEAST_JUMP_ROWS.max(rows / LEAST_JUMP_SHARE);
        self.best().is_some_and(|best| best.rows >= margin && rows.saturating_sub(best.rows) >= margin)
    }

    /// Takes a snapshot before the next row, at the time `t_ms`; the one that is missed least gives way.
    pub(super) fn take(&mut self, blocks: &Blocks<Sums>, t_ms: u32) {
        if self.pinned {
            return;
        }
        let rows = blocks.rows();
        let before = self.look(blocks);
        if usize::from(self.used) == MARKS {
            let from_best = |index: usize| self.best.map_or(MARKS, |best| index.abs_diff(usize::from(best)));
            let rows_at = |index: usize| self.marks.get(index).map_or(rows, |mark| mark.rows);
            // The gap that it would leave, over how long ago that is.
            let gap = |index: usize| {
                let before = index.checked_sub(1).map_or(0, rows_at);
                (rows_at(index + 1) - before) as f32 / (rows - rows_at(index)).max(1) as f32
            };
            let may_go = (0..MARKS).filter(|index| from_best(*index) > usize::from(self.firm));
            let Some(index) = may_go.min_by(|a, b| gap(*a).total_cmp(&gap(*b))) else { return };
            if let Some(rest) = self.marks.get_mut(index..) {
                first_to_end(rest);
            }
            self.used -= 1;
            self.best = self.best.map(|best| if usize::from(best) > index { best - 1 } else { best });
        }
        let Some(mark) = self.marks.get_mut(usize::from(self.used)) else { return };
        *mark = Mark { rows, t_ms, before };
        self.used += 1;
    }

    /// Finds the best one, next to the plain base; the sums of a jump of all rows.
    fn look(&mut self, blocks: &Blocks<Sums>) -> Jump {
        let mut work: Normal<f32, { BASE + 3 }> = Normal::EMPTY;
        let mut sums = Sums::EMPTY;
        blocks.iter().for_each(|block| sums.merge_base(block));
        sums.write(&mut work, BASE);
        let (now, rows) = (sums.jump(), work.rows());
        let role = |column| if column < BASE { Role::Required } else { Role::Optional(MIN_DIRECTION) };
        let mut base = Factor::new();
        if base.extend(&work, BASE, 0.0, &role).is_none() {
            return now;
        }
        let left = base.squares(&work);
        let mut best = (left, None);
        for (index, mark) in (0..).zip(self.used()) {
            if mark.rows < LEAST_JUMP_ROWS || rows.saturating_sub(mark.rows) < LEAST_JUMP_ROWS {
                continue;
            }
            now.less(&mark.before).write(&mut work, BASE);
            base.shorten(BASE);
            if base.extend(&work, BASE + 3, 0.0, &role).is_some() {
                let squares = base.squares(&work);
                if squares < best.0 {
                    best = (squares, Some(index));
                }
            }
        }
        self.best = best.1;
        self.firm = left - best.0 > FIRM_SHARE * left;
        now
    }

    /// Adds the sums of all rows, with the columns of the best jump.
    #[inline(never)]
    pub(super) fn add_to(&self, blocks: &Blocks<Sums>, work: &mut Work) {
        let mut sums = Sums::EMPTY;
        blocks.iter().for_each(|block| sums.merge(block));
        sums.add_to(work);
        if let Some(best) = self.best() {
            sums.jump().less(&best.before).write(work, STEP);
        }
    }

    /// Adds those of one block.
    #[inline(never)]
    pub(super) fn add_part_to(&self, blocks: &Blocks<Sums>, index: usize, work: &mut Work) {
        let Some(block) = blocks.get(index) else { return };
        block.add_to(work);
        let Some(best) = self.best() else { return };
        let begin = blocks.rows_before(index);
        if best.rows <= begin {
            block.jump().write(work, STEP);
        } else if best.rows < begin + block.rows() {
            // What came after the jump, less the later blocks.
            so_far(blocks, 0).less(&best.before).less(&so_far(blocks, index + 1)).write(work, STEP);
        }
    }

    /// The oldest block leaves the sums. What happened within it happened before all rows that are left.
    pub(super) fn forget(&mut self, oldest: &Sums) {
        let gone = self.used().iter().filter(|mark| mark.rows <= oldest.rows()).count() as u8;
        for _ in 0..gone {
            first_to_end(&mut self.marks);
        }
        self.used -= gone;
        let sums = oldest.jump();
        for mark in self.marks.iter_mut().take(usize::from(self.used)) {
            mark.rows -= oldest.rows();
            mark.before.add(&sums, -1.0);
        }
        self.best = self.best.and_then(|best| best.checked_sub(gone));
        if self.best.is_none() {
            (self.firm, self.pinned) = (false, false);
        }
    }

    /// An effect's column is held against another value, by `times` further.
    pub(super) fn hold_against(&mut self, effect: usize, times: f32) {
        self.marks.iter_mut().for_each(|mark| mark.before.hold_against(effect, times));
    }

    /// The snapshots about another point: streamed columns and the best step moved by `delta`.
    pub(super) fn shift(&mut self, delta: &[f32; WIDEST]) {
        let [.., x, y, z] = *delta;
        let best = self.best().copied();
        for mark in self.marks.iter_mut().take(usize::from(self.used)) {
            mark.before.pull(mark.before.along(delta));
            if let Some(best) = best.filter(|best| mark.rows > best.rows) {
                let since = mark.before.less(&best.before).own();
                mark.before.pull(since.map(|row| row[0] * x + row[1] * y + row[2] * z));
            }
        }
    }
}

/// The offset's sums of the blocks from one on.
fn so_far(blocks: &Blocks<Sums>, from: usize) -> Jump {
    let mut sum = Jump::NONE;
    blocks.iter().skip(from).for_each(|block| sum.add(&block.jump(), 1.0));
    sum
}
