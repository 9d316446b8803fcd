//! What streams: rows about a point, in blocks of time.

use super::blocks::Blocks;
use super::columns::Columns;
use super::late::{Late, Motion};
use super::layout::{DRIFT, DRIFT_UNIT_MS, ENTRIES, STREAMED};
use super::marks::{EVERY, Marks};
use super::memory::Memory;
use super::point::{BASE, Point};
use super::solve::{Chosen, Factor};
use super::sums::{WIDEST, Work};
use crate::calibration::Calibration;
use crate::effect::ColumnName;
use crate::math;

/// A pause longer than this is a gap, ms.
const GAP_MS: u64 = 250;
/// A base further than this from where it was linearised begins anew early on, ...
const FAR_EARLY: f32 = 0.05;
/// ... up to so many rows, and one further than that at any time.
const EARLY_ROWS: u32 = 1000;
const FAR: f32 = 0.25;
/// A base nearer than this is near enough, also for directions.
const NEAR: f32 = 0.004;
/// No base is that far.
const ABSURD: f32 = 1.0;
/// The samples tell the base once its standard errors are this small.
const TOLD: f32 = 0.01;
/// Rows between two looks at that.
const LOOK_EVERY: u32 = 128;

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
    pub(super) blocks: Blocks<STREAMED, ENTRIES>,
    pub(super) marks: Marks,
    pub(super) memory: Memory,
    pub(super) late: Late,
    pub(super) columns: Columns,
    pub(super) first_ms: u64,
    pub(super) last_ms: u64,
    /// Changes whenever what was learned is forgotten.
    pub(super) epoch: u16,
}

const _: () = assert!(core::mem::size_of::<Learner>() <= 6144, "the learner's memory is a promise");

impl Learner {
    /// One that has learned nothing and waits for a point to begin at.
    pub const fn new() -> Self {
        Self {
            point: None,
            blocks: Blocks::new(),
            marks: Marks::new(),
            memory: Memory::new(),
            late: Late::new(),
            columns: Columns::new(),
            first_ms: 0,
            last_ms: 0,
            epoch: 0,
        }
    }

    /// Begins at a calibration, from nothing; columns stay.
    pub fn begin(&mut self, calibration: &Calibration<f64>) {
        match Point::of(calibration) {
            Some((point, rotation)) => {
                self.point = Some(point);
                self.late.begin(rotation.map(|row| row.map(|value| value as f32)));
                self.forget();
            }
            None => self.reset(),
        }
    }

    /// Forgets what was learned and where; columns stay.
    pub fn reset(&mut self) {
        self.point = None;
        self.forget();
    }

    /// Forgets everything, columns too.
    pub fn begin_anew(&mut self) {
        self.late = Late::new();
        self.columns = Columns::new();
        self.reset();
        (self.first_ms, self.last_ms) = (0, 0);
    }

    fn forget(&mut self) {
        self.blocks.clear();
        self.marks.clear();
        self.memory = Memory::new();
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

    /// Rms of the residual at the point, µT; NaN without samples.
    pub fn rms_ut(&self) -> f32 {
        let squares: f32 = self.blocks.iter().map(|block| block.squares).sum();
        let field = self.point.map_or(f32::NAN, |point| point.field_ut);
        math::sqrtf(squares.max(0.0) / self.rows() as f32) * field
    }

    /// Sets a column, which keeps this value until it is set again. A new one begins to be tested, from nothing: what was learned
    /// without it is forgotten.
    pub fn feed(&mut self, name: &ColumnName, value: f32) -> Fed {
        if self.columns.set(name.as_str(), value).is_some() {
            return Fed::Tested;
        }
        if !self.columns.add(*name, value) {
            return Fed::Full;
        }
        let rotation = self.late.rotation;
        self.late.begin(rotation);
        self.forget();
        Fed::Tested
    }

    /// Forgets a column, and what was learned with it. Whether it was known.
    pub fn drop_column(&mut self, name: &str) -> bool {
        let known = self.columns.remove(name);
        if known {
            let rotation = self.late.rotation;
            self.late.begin(rotation);
            self.forget();
        }
        known
    }

    /// The columns that are tested, by name.
    pub fn tested(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// A column's value, where it is known.
    pub fn value(&self, name: &str) -> Option<f32> {
        self.columns.place(name).and_then(|place| self.columns.get(place)).map(|column| column.now)
    }

    /// Learns from a sample, µT, from which the effects in use were taken off.
    pub fn push(&mut self, measured_ut: [f32; 3], t_ms: u64, motion: &Motion) {
        let Some(point) = &self.point else { return };
        let Some(look) = point.look(measured_ut) else { return };
        let mut row = [0.0; STREAMED];
        let (base, effects) = row.split_at_mut(BASE);
        base.copy_from_slice(&look.base);
        if !(look.residual.is_finite() && base.iter().all(|value| value.is_finite())) {
            return;
        }
        let rows = self.blocks.rows();
        if rows == 0 {
            self.first_ms = t_ms;
        }
        if rows > 0 && t_ms.saturating_sub(self.last_ms) > GAP_MS {
            self.memory.interrupt();
            self.late.interrupt();
        }
        self.last_ms = t_ms;
        let [p, q, r] = look.offset();
        let mut put = |place: usize, value: f32| {
            let three = effects.iter_mut().skip(3 * place).take(3);
            three.zip([p, q, r]).for_each(|(slot, along)| *slot = along * value);
        };
        put(0, t_ms.saturating_sub(self.first_ms) as f32 / DRIFT_UNIT_MS);
        self.columns.take(|place, value| put(1 + place, value));
        if rows > 0 && rows.is_multiple_of(EVERY) {
            self.marks.take(&self.blocks, t_ms as u32);
        }
        let width = DRIFT + 3 + 3 * self.columns.width();
        self.blocks.push(row.get(..width).unwrap_or(&row), look.residual);
        self.memory.push(look.residual);
        self.late.push(look.direction, motion);
        if (rows + 1).is_multiple_of(LOOK_EVERY) {
            self.look();
        }
    }

    /// The sums of all rows, with the columns of a step where it explains most.
    pub(super) fn total(&self) -> Work {
        let mut work = Work::new();
        self.blocks.iter().for_each(|block| work.merge(block));
        self.marks.beside_total(&self.blocks, &mut work);
        work
    }

    /// Begins anew where the sums say that they were taken far from where they should have been.
    fn look(&mut self) {
        let mut work = Work::new();
        self.blocks.iter().for_each(|block| work.merge(block));
        // Beside everything that is fed: what an effect does is no reason to look elsewhere for the base.
        let effects = 3 + 3 * self.columns.width();
        let Some(factor) = Factor::of(&work, Chosen::base(BASE).with(DRIFT, effects), true) else { return };
        let delta = factor.step(&work);
        let far = delta.iter().take(BASE).fold(0.0f32, |most, value| most.max(value.abs()));
        let limit = if self.blocks.rows() <= EARLY_ROWS { FAR_EARLY } else { FAR };
        // Where the samples do not tell it yet, it is where it was.
        if !(far > NEAR && far < ABSURD && factor.largest_error(&work) < TOLD) {
            return;
        }
        let Some(point) = self.point else { return };
        let rotation = self.late.rotation;
        if far > limit {
            self.point = Some(point.stepped(&delta));
            self.late.begin(rotation);
            self.forget();
        } else if self.blocks.rows().is_power_of_two() {
            // What was learned stays; the direction that the dip looks at was another one.
            let mut base = [0.0; WIDEST];
            base.iter_mut().zip(delta).take(BASE).for_each(|(slot, value)| *slot = value);
            self.shift(&base, point.stepped(&delta));
            self.late.begin(rotation);
        }
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
