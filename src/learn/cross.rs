//! The offset's rows of a normal matrix: all that the columns of a jump need.

use super::layout::{DRIFT, EFFECTS, ENTRIES, STEP, STREAMED};
use super::point::BASE;
use super::sums::{Sums, Work, at};

/// Where the base's other columns begin, the effects' and the right side.
const TRIANGLE: usize = 6;
const EFFECT: usize = TRIANGLE + 3 * (BASE - 3);
const RIGHT: usize = EFFECT + 6 * EFFECTS;
const WORDS: usize = RIGHT + 3;

/// Sums of the offset's three columns with all that stream, and with the residual. With themselves, and with each effect, whose
/// columns are multiples of theirs, they are symmetric, and only a triangle is kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cross([f32; WORDS]);

/// Place in a triangle.
const fn place(i: usize, j: usize) -> usize {
    at(i, j)
}

impl Cross {
    pub(super) const NONE: Self = Self([0.0; WORDS]);

    /// Adds those of a block.
    pub(super) fn add_block(&mut self, block: &Sums<STREAMED, ENTRIES>) {
        let mut put = |to: usize, from: usize, count: usize| {
            let to = self.0.iter_mut().skip(to).take(count);
            to.zip(block.entries.iter().skip(from)).for_each(|(sum, value)| *sum += value);
        };
        // The offset's own triangle stands first in the block's.
        put(0, 0, 6);
        for column in 3..BASE {
            put(TRIANGLE + 3 * (column - 3), at(column, 0), 3);
        }
        for effect in 0..EFFECTS {
            for axis in 0..3 {
                put(EFFECT + 6 * effect + place(axis, 0), at(DRIFT + 3 * effect + axis, 0), axis + 1);
            }
        }
        let right = self.0.iter_mut().skip(RIGHT);
        right.zip(&block.right).for_each(|(sum, value)| *sum += value);
    }

    /// Adds a multiple of others.
    pub(super) fn add(&mut self, other: &Self, times: f32) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, value)| *sum += times * value);
    }

    /// The same with `times` the offset's own columns taken off those of an effect.
    pub(super) fn take_off_offset(&mut self, effect: usize, times: f32) {
        let (own, effects) = self.0.split_at_mut(EFFECT);
        let effect = effects.iter_mut().skip(6 * effect).take(6);
        effect.zip(own).for_each(|(sum, value)| *sum -= times * *value);
    }

    /// Those of the samples between two moments.
    pub(super) fn less(mut self, before: &Self) -> Self {
        self.add(before, -1.0);
        self
    }

    /// Sum of the offset's column of an axis with a column that streams.
    pub(super) fn entry(&self, axis: usize, column: usize) -> f32 {
        let index = if column < 3 {
            place(axis, column)
        } else if column < BASE {
            TRIANGLE + 3 * (column - 3) + axis
        } else {
            let effect = column - DRIFT;
            EFFECT + 6 * (effect / 3) + place(axis, effect % 3)
        };
        self.0.get(index).copied().unwrap_or(0.0)
    }

    /// With the residual.
    pub(super) fn right(&self) -> [f32; 3] {
        let [.., x, y, z] = self.0;
        [x, y, z]
    }

    pub(super) fn set_right(&mut self, right: [f32; 3]) {
        self.0.iter_mut().skip(RIGHT).zip(right).for_each(|(slot, value)| *slot = value);
    }

    /// The offset's own part.
    pub(super) fn own(&self) -> [[f32; 3]; 3] {
        let [a, b, c, d, e, f, ..] = self.0;
        [[a, b, d], [b, c, e], [d, e, f]]
    }

    /// With the base's columns.
    pub(super) fn base(&self) -> [[f32; 3]; BASE] {
        let mut out = [[0.0; 3]; BASE];
        let own = self.own();
        let rest = self.0.iter().skip(TRIANGLE);
        let mut rest = rest.copied();
        for (index, slot) in out.iter_mut().enumerate() {
            *slot = match own.get(index) {
                Some(row) => *row,
                None => core::array::from_fn(|_| rest.next().unwrap_or(0.0)),
            };
        }
        out
    }

    /// What the offset's columns have of a step of those that stream.
    pub(super) fn along(&self, delta: &[f32]) -> [f32; 3] {
        core::array::from_fn(|axis| {
            let streamed = delta.iter().take(STREAMED).enumerate();
            streamed.filter(|(_, value)| **value != 0.0).map(|(c, value)| self.entry(axis, c) * value).sum()
        })
    }

    /// Writes them as the columns of a jump.
    pub(super) fn write(&self, work: &mut Work) {
        let own = self.own();
        for (axis, right) in self.right().into_iter().enumerate() {
            let from = at(STEP + axis, 0);
            let Some(line) = work.entries.get_mut(from..from + STEP + axis + 1) else { return };
            for (column, slot) in line.iter_mut().enumerate() {
                *slot = match column.checked_sub(STEP) {
                    None => self.entry(axis, column),
                    Some(other) => own.get(axis).and_then(|row| row.get(other)).copied().unwrap_or(0.0),
                };
            }
            if let Some(slot) = work.right.get_mut(STEP + axis) {
                *slot = right;
            }
        }
    }
}
