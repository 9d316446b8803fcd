//! What streams: rows about a point, in blocks of time.

use super::blocks::Blocks;
use super::columns::Columns;
use super::late::{Late, Motion};
use super::layout::{DRIFT, DRIFT_UNIT_MS, EFFECTS, ENTRIES, STEP, STREAMED};
use super::marks::{EVERY, Marks};
use super::memory::Memory;
use super::point::{BASE, Point};
use super::solve::Chosen;
use super::sums::{WIDEST, Work};
use crate::calibration::Calibration;
use crate::effect::ColumnName;
use crate::math;

/// A pause longer than this is a gap, ms.
const GAP_MS: u64 = 250;
/// Rows between two looks at where the study stands, early on; later as many as [`EARLY_ROWS`].
const LOOK_EVERY: u32 = 256;
/// Up to so many rows it is early.
pub(super) const EARLY_ROWS: u32 = 1024;

/// What became of a column that was fed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fed {
    /// It is tested.
    Tested,
    /// It is not, since as many others are as there is room for.
    Full,
}

/// The study that a board carries with it.
///
/// Nine columns of base, three of drift and three for each of up to [`MAX_TESTED`](super::MAX_TESTED) fed columns, in four blocks of time; snapshots
/// for a step; and the dip with a delay. No sample is kept.
#[derive(Clone, Debug)]
pub struct Learner {
    pub(super) point: Option<Point>,
    /// Coefficients of the effects at the point, over the field: taken off each sample before it is looked at.
    pub(super) carried: [[f32; 3]; EFFECTS],
    pub(super) blocks: Blocks<STREAMED, ENTRIES>,
    pub(super) marks: Marks,
    pub(super) memory: Memory,
    pub(super) late: Late,
    pub(super) columns: Columns,
    pub(super) first_ms: u64,
    pub(super) last_ms: u64,
    /// Rows that were forgotten since it began, for a better point.
    pub(super) lost: u32,
    /// Changes whenever what was learned is forgotten.
    pub(super) epoch: u16,
    /// The last block that was forgotten was an odd one.
    pub(super) is_odd: bool,
}

/// Of what is new from sample to sample, a settled jump leaves at least this share: less is made of the wrong assumption.
const SETTLED_SHARE: f32 = 0.3;

const _: () = assert!(core::mem::size_of::<Learner>() <= 6144, "the learner's memory is a promise");

impl Learner {
    /// One that has learned nothing and waits for a point to begin at.
    pub const fn new() -> Self {
        Self {
            point: None,
            carried: [[0.0; 3]; EFFECTS],
            blocks: Blocks::new(),
            marks: Marks::new(),
            memory: Memory::new(),
            late: Late::new(),
            columns: Columns::new(),
            first_ms: 0,
            last_ms: 0,
            lost: 0,
            epoch: 0,
            is_odd: false,
        }
    }

    /// Begins at a calibration, from nothing; columns stay.
    pub fn begin(&mut self, calibration: &Calibration<f64>) {
        match Point::of(calibration) {
            Some((point, rotation)) => {
                self.point = Some(point);
                self.carried = [[0.0; 3]; EFFECTS];
                self.late.begin(rotation.map(|row| row.map(|value| value as f32)));
                self.forget();
            }
            None => self.reset(),
        }
    }

    /// Begins from nothing where it is, if it is anywhere.
    pub fn begin_again(&mut self) {
        let rotation = self.late.rotation;
        self.late.begin(rotation);
        self.forget();
    }

    /// Forgets everything, columns too.
    pub fn begin_anew(&mut self) {
        self.late = Late::new();
        self.columns = Columns::new();
        self.reset();
        self.carried = [[0.0; 3]; EFFECTS];
        (self.first_ms, self.last_ms, self.lost) = (0, 0, 0);
    }

    /// Forgets what was learned and where; columns stay.
    pub fn reset(&mut self) {
        self.point = None;
        self.carried = [[0.0; 3]; EFFECTS];
        self.forget();
    }

    /// Begins with nothing, at the same point: effects that it carries are held against other values from now on.
    pub(super) fn forget(&mut self) {
        self.blocks.clear();
        self.marks.clear();
        self.memory = Memory::new();
        let moved = self.values(self.first_ms, self.last_ms);
        self.first_ms = self.last_ms;
        self.lost = 0;
        if let Some(point) = &mut self.point {
            for (theta, moved) in self.carried.iter().zip(moved) {
                for (offset, value) in point.offset_ut.iter_mut().zip(theta) {
                    *offset += point.field_ut * value * moved;
                }
            }
        }
        self.columns.begin();
        self.epoch = self.epoch.wrapping_add(1);
    }

    /// Whether it has a point, so that samples are learned from.
    pub fn is_learning(&self) -> bool {
        self.point.is_some()
    }

    /// Samples that were learned from.
    pub fn rows(&self) -> u32 {
        self.blocks.rows()
    }

    /// The calibration at which it stands.
    pub fn calibration(&self) -> Option<Calibration<f64>> {
        const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.point.map(|point| point.calibration(&UPRIGHT))
    }

    /// The field of the point, µT.
    pub fn field_ut(&self) -> Option<f64> {
        self.point.map(|point| f64::from(point.field_ut))
    }

    /// Rms of the residual at the point without any effect, µT; NaN without samples.
    pub fn rms_ut(&self) -> f32 {
        let squares = self.total().squares;
        let field = self.point.map_or(f32::NAN, |point| point.field_ut);
        math::sqrtf(squares.max(0.0) / self.rows() as f32) * field
    }

    /// Sets a column, which keeps this value until it is set again. A new one begins to be tested, from nothing: what was learned
    /// without it is forgotten.
    pub fn feed(&mut self, name: &ColumnName, value: f32) -> Fed {
        if self.columns.set(name.as_str(), value).is_some() {
            return Fed::Tested;
        }
        let Some(place) = self.columns.add(*name, value) else { return Fed::Full };
        self.renew(place);
        Fed::Tested
    }

    /// Another column stands in a place, or none: what was learned with the one before is forgotten.
    fn renew(&mut self, place: usize) {
        if let Some(theta) = self.carried.get_mut(1 + place) {
            *theta = [0.0; 3];
        }
        self.begin_again();
    }

    /// Forgets a column, and what was learned with it. Whether it was known.
    pub fn drop_column(&mut self, name: &str) -> bool {
        let Some(place) = self.columns.remove(name) else { return false };
        self.renew(place);
        true
    }

    /// The columns that are tested, by name.
    pub fn tested(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// A column's value, where it is known.
    pub fn value(&self, name: &str) -> Option<f32> {
        self.columns.place(name).and_then(|place| self.columns.get(place)).map(|column| column.now)
    }

    /// What the columns of the effects are multiples of.
    #[inline]
    fn values(&self, first_ms: u64, t_ms: u64) -> [f32; EFFECTS] {
        core::array::from_fn(|effect| match effect.checked_sub(1) {
            None => t_ms.saturating_sub(first_ms) as f32 / DRIFT_UNIT_MS,
            Some(place) => self.columns.since_first(place),
        })
    }

    /// Learns from a sample, µT, from which the effects in use were taken off. The time goes on: a tick that wraps is extended first
    /// ([`Extended`](crate::clock::Extended)).
    pub fn push(&mut self, measured_ut: [f32; 3], t_ms: u64, motion: &Motion) {
        let Some(point) = &self.point else { return };
        let first_ms = if self.blocks.rows() == 0 { t_ms } else { self.first_ms };
        let values = self.values(first_ms, t_ms);
        let mut cleaned_ut = measured_ut;
        for (theta, value) in self.carried.iter().zip(values) {
            let ([x, y, z], [along_x, along_y, along_z]) = (&mut cleaned_ut, theta);
            *x -= point.field_ut * along_x * value;
            *y -= point.field_ut * along_y * value;
            *z -= point.field_ut * along_z * value;
        }
        let Some(look) = point.look(cleaned_ut) else { return };
        let mut row = [0.0; STREAMED];
        let (base, effects) = row.split_at_mut(BASE);
        base.copy_from_slice(&look.base);
        if !(look.residual.is_finite() && base.iter().all(|value| value.is_finite())) {
            return;
        }
        let rows = self.blocks.rows();
        self.first_ms = first_ms;
        if rows > 0 && t_ms.saturating_sub(self.last_ms) > GAP_MS {
            self.memory.interrupt();
            self.late.interrupt();
        }
        self.last_ms = t_ms;
        self.columns.take();
        let offset = look.offset();
        let [along_x, along_y, along_z] = offset;
        for (three, value) in effects.as_chunks_mut::<3>().0.iter_mut().zip(values) {
            *three = [along_x * value, along_y * value, along_z * value];
        }
        if rows > 0 && rows.is_multiple_of(EVERY) {
            self.marks.take(&self.blocks, t_ms as u32);
        }
        let width = DRIFT + 3 + 3 * self.columns.width();
        let (marks, mut has_forgotten) = (&mut self.marks, false);
        self.blocks.push(row.get(..width).unwrap_or(&row), look.residual, |oldest| {
            marks.forget(oldest);
            has_forgotten = true;
        });
        if has_forgotten {
            self.hold_against_what_is_left();
        }
        self.memory.push(look.residual);
        self.late.push(look.direction, motion, t_ms);
        let rows = rows + 1;
        if rows.is_multiple_of(if rows <= EARLY_ROWS { LOOK_EVERY } else { 2 * LOOK_EVERY }) {
            self.look();
        }
    }

    /// The way from the effects at the point to none.
    pub(super) fn away(&self) -> [f32; WIDEST] {
        let mut away = [0.0; WIDEST];
        let effects = away.iter_mut().skip(DRIFT);
        effects.zip(self.carried.as_flattened()).for_each(|(slot, value)| *slot = -value);
        away
    }

    /// The sums of all rows about the point without any effect, with the columns of a step where it explains most.
    pub(super) fn total(&self) -> Work {
        let mut work = self.total_here();
        work.shift(&self.away());
        work
    }

    /// The same about the point with the effects at it.
    pub(super) fn total_here(&self) -> Work {
        let mut work = Work::new();
        self.blocks.iter().for_each(|block| work.merge(block));
        self.marks.beside_total(&self.blocks, &mut work);
        work
    }

    /// The sums of one block, likewise; `None` of one without rows.
    pub(super) fn part(&self, index: usize) -> Option<Work> {
        let block = self.blocks.iter().nth(index).filter(|block| block.rows > 0)?;
        let mut work = Work::new();
        work.merge(block);
        self.marks.beside_block(&self.blocks, index, &mut work);
        work.shift(&self.away());
        Some(work)
    }

    /// Finds the moment of a jump more closely than the snapshots stand; before a question is put.
    pub fn settle(&mut self) {
        let effects = 3 + 3 * self.columns.width();
        let chosen = Chosen::base(BASE).with(DRIFT, effects).with(STEP, 3);
        self.marks.settle(&self.blocks, chosen, SETTLED_SHARE * self.memory.quick());
    }

    /// Moves to another point of the linearised model: what was learned is kept. The base, streamed columns and the best step are
    /// moved by `delta`, which leads to `point`.
    pub(super) fn shift(&mut self, delta: &[f32; WIDEST], point: Point) {
        // From the last to the first: the sums since a mark are those of all blocks less those before it, which are still to come.
        for index in (0..super::blocks::BLOCKS).rev() {
            let mut work = Work::new();
            if let Some(block) = self.blocks.iter().nth(index) {
                work.merge(block);
            }
            self.marks.beside_block(&self.blocks, index, &mut work);
            work.shift(delta);
            if let Some(block) = self.blocks.iter_mut().nth(index) {
                block.right.iter_mut().zip(&work.right).for_each(|(to, from)| *to = *from);
                block.squares = work.squares;
            }
        }
        self.marks.shift(delta);
        self.point = Some(point);
    }
}

impl Default for Learner {
    fn default() -> Self {
        Self::new()
    }
}
