//! Sums of products over the samples of one block of time, in single precision, and the normal matrix that they are.
//!
//! An effect's three columns are those of the offset times a number of the moment (a time, a temperature), so that their products
//! with each other are symmetric and one triangle of six says all nine.

use super::blocks::Block;
use super::columns::MAX_TESTED;
use super::point::{BASE, Look};
use crate::dense::add_scaled_f32;
use crate::study::{Factor, Normal, Role};

/// Effects that stream: drift and the tested columns.
pub(super) const EFFECTS: usize = 1 + MAX_TESTED;
/// Where the drift's columns begin; those of a tested column follow, three each.
pub(super) const DRIFT: usize = BASE;
/// The unit of time of the drift's columns, ms.
pub(super) const DRIFT_UNIT_MS: f32 = 64_000.0;
/// Columns that stream.
const STREAMED: usize = DRIFT + 3 * EFFECTS;
/// Where a jump's columns stand, behind those that stream.
pub(super) const STEP: usize = STREAMED;
/// The columns of the widest normal matrix that is solved.
pub(super) const WIDEST: usize = STEP + 3;
/// What all come together in to be solved.
pub(super) type Work = Normal<f32, WIDEST>;

/// What a model leaves of the samples, and where it leads.
pub(super) struct Solved {
    /// `δ = −N⁻¹g`.
    pub(super) step: [f32; WIDEST],
    /// Squared residual.
    pub(super) squares: f32,
    /// What the columns before it leave of a column's square.
    pub(super) own: [f32; WIDEST],
    /// Columns that are told.
    pub(super) directions: usize,
}

/// The squared residual that a part of the columns leaves. `None` where the base is not determined.
#[inline(never)]
pub(super) fn left(work: &Work, role: &dyn Fn(usize) -> Role<f32>) -> Option<f32> {
    let mut factor = Factor::new();
    factor.extend(work, WIDEST, 0.0, role)?;
    Some(factor.squares(work))
}

/// Solves for a part of the columns. `None` where the base is not determined.
// Apart, and with what is needed of a factor alone: the stack carries one of them at a time.
#[inline(never)]
pub(super) fn solved(work: &Work, role: &dyn Fn(usize) -> Role<f32>) -> Option<Solved> {
    let mut factor = Factor::new();
    factor.extend(work, WIDEST, 0.0, role)?;
    Some(Solved {
        step: work.step(&factor),
        squares: factor.squares(work),
        own: core::array::from_fn(|column| factor.own_square(column)),
        directions: factor.directions(),
    })
}

/// Diagonal of the inverse, over a part of the columns; zero of those that are left out.
#[inline(never)]
pub(super) fn inverse_diagonal(work: &Work, role: &dyn Fn(usize) -> Role<f32>) -> Option<[f32; WIDEST]> {
    let mut factor = Factor::new();
    factor.extend(work, WIDEST, 0.0, role)?;
    Some(core::array::from_fn(|column| factor.inverse_diagonal(column)))
}

/// The offset's columns and their multiples.
const MULTIPLES: usize = 1 + EFFECTS;
/// The columns of the matrix, and the residual as the last.
const OTHERS: usize = BASE - 3 + 1;
const RESIDUAL: usize = WIDEST;
/// Where the sums of the others with each other stand.
const OWN: usize = start(MULTIPLES);
const WORDS: usize = OWN + (OTHERS - 1) * OTHERS + 1;

/// Where the sums of a multiple begin: with itself and each that follows (a triangle of six), then with the others, by axis.
const fn start(multiple: usize) -> usize {
    multiple * (6 * MULTIPLES + 3 * OTHERS) - 3 * multiple * multiple.saturating_sub(1)
}

const fn triangle(i: usize, j: usize) -> usize {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    high * (high + 1) / 2 + low
}

const fn pair(a: usize, b: usize) -> usize {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    start(low) + 6 * (high - low)
}

/// What a column is: an axis of a multiple, or one of the others.
const fn kind(column: usize) -> Result<(usize, usize), usize> {
    match column {
        0..3 => Ok((0, column)),
        3..BASE => Err(column - 3),
        RESIDUAL => Err(OTHERS - 1),
        _ => Ok((1 + (column - BASE) / 3, (column - BASE) % 3)),
    }
}

/// Where the sum of the products of two columns stands.
const fn place(i: usize, j: usize) -> usize {
    match (kind(i), kind(j)) {
        (Ok((a, x)), Ok((b, y))) => pair(a, b) + triangle(x, y),
        (Ok((a, x)), Err(other)) | (Err(other), Ok((a, x))) => {
            start(a) + 6 * (MULTIPLES - a) + OTHERS * x + other
        }
        (Err(a), Err(b)) => {
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            OWN + low * OTHERS + if low == OTHERS - 1 { 0 } else { high }
        }
    }
}

fn add_six(slots: &mut [f32; 6], times: f32, values: &[f32; 6]) {
    let ([a, b, c, d, e, f], [p, q, r, s, t, u]) = (slots, values);
    *a += times * p;
    *b += times * q;
    *c += times * r;
    *d += times * s;
    *e += times * t;
    *f += times * u;
}

/// Adds a column's products with those of the matrix, and with the residual; the slots behind.
#[inline]
fn add_row<'a>(slots: &'a mut [f32], times: f32, matrix: &[f32; 6], residual: f32) -> Option<&'a mut [f32]> {
    let (six, [right, rest @ ..]) = slots.split_first_chunk_mut()? else { return None };
    if times != 0.0 {
        add_six(six, times, matrix);
        *right += times * residual;
    }
    Some(rest)
}

/// The sums of the offset's columns with all: what the columns of a jump are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jump([f32; start(1)]);

impl Jump {
    pub(super) const NONE: Self = Self([0.0; start(1)]);

    /// Adds a multiple of others.
    pub(super) fn add(&mut self, other: &Self, times: f32) {
        add_scaled_f32(&mut self.0, times, &other.0);
    }

    /// Those of the samples between two moments.
    pub(super) fn less(mut self, before: &Self) -> Self {
        self.add(before, -1.0);
        self
    }

    /// Holds an effect against a value further by `times`.
    pub(super) fn hold_against(&mut self, effect: usize, times: f32) {
        let [own, effects @ ..] = self.0.as_chunks_mut::<6>().0 else { return };
        if let Some(slot) = effects.get_mut(effect) {
            add_six(slot, -times, own);
        }
    }

    fn entry(&self, axis: usize, column: usize) -> f32 {
        self.0.get(place(axis, column)).copied().unwrap_or(0.0)
    }

    /// With the offset's columns themselves.
    pub(super) fn own(&self) -> [[f32; 3]; 3] {
        core::array::from_fn(|i| core::array::from_fn(|j| self.entry(i, j)))
    }

    /// Adds to those with the residual.
    pub(super) fn pull(&mut self, right: [f32; 3]) {
        for (axis, value) in right.into_iter().enumerate() {
            if let Some(slot) = self.0.get_mut(place(axis, RESIDUAL)) {
                *slot += value;
            }
        }
    }

    /// What the offset's columns have of a step of those that stream.
    pub(super) fn along(&self, delta: &[f32; WIDEST]) -> [f32; 3] {
        core::array::from_fn(|axis| {
            let streamed = delta.iter().take(STREAMED).enumerate();
            streamed.filter(|(_, value)| **value != 0.0).map(|(c, value)| self.entry(axis, c) * value).sum()
        })
    }

    /// Puts them into the columns of a jump, which stand at `first`, behind the base and what streams with it.
    pub(super) fn write<const P: usize>(&self, work: &mut Normal<f32, P>, first: usize) {
        let (sixes, others) = self.0.split_at(6 * MULTIPLES);
        let threes = |[a, b, c, d, e, f]: [f32; 6]| [[a, b, d], [b, c, e], [d, e, f]];
        for (multiple, six) in sixes.as_chunks::<6>().0.iter().enumerate() {
            let column = if multiple == 0 { 0 } else { BASE - 3 + 3 * multiple };
            for (axis, three) in threes(*six).into_iter().enumerate() {
                for (other, value) in three.into_iter().enumerate() {
                    if column < first {
                        work.set(column + other, first + axis, value);
                    }
                    if multiple == 0 && other <= axis {
                        work.set(first + other, first + axis, value);
                    }
                }
            }
        }
        for (axis, [matrix @ .., right]) in others.as_chunks::<OTHERS>().0.iter().enumerate() {
            (3..).zip(matrix).for_each(|(column, value)| work.set(column, first + axis, *value));
            work.set_right(first + axis, *right);
        }
    }
}

/// The sums of a block.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    values: [f32; WORDS],
    rows: u32,
}

impl Block for Sums {
    const EMPTY: Self = Self { values: [0.0; WORDS], rows: 0 };

    fn rows(&self) -> u32 {
        self.rows
    }

    fn clear(&mut self) {
        self.values.fill(0.0);
        self.rows = 0;
    }

    fn merge(&mut self, other: &Self) {
        add_scaled_f32(&mut self.values, 1.0, &other.values);
        self.rows = self.rows.saturating_add(other.rows);
    }
}

impl Sums {
    /// Adds a sample, each effect's number as it is now.
    ///
    /// Most of the study's instructions are here: slices that are taken apart, so that no index is checked.
    pub(super) fn push(&mut self, look: &Look, effects: &[f32; EFFECTS]) {
        let [x, y, z, matrix @ ..] = look.base;
        let residual = look.residual;
        let squares = [x * x, x * y, y * y, x * z, y * z, z * z];
        let mut multiples = [1.0; MULTIPLES];
        multiples.iter_mut().skip(1).zip(effects).for_each(|(slot, value)| *slot = *value);
        let mut slots = self.values.as_mut_slice();
        let mut left = multiples.as_slice();
        while let [own, ..] = left {
            for other in left {
                let Some((six, rest)) = slots.split_first_chunk_mut() else { return };
                let times = own * other;
                if times != 0.0 {
                    add_six(six, times, &squares);
                }
                slots = rest;
            }
            for axis in [x, y, z] {
                let Some(rest) = add_row(slots, own * axis, &matrix, residual) else { return };
                slots = rest;
            }
            let [_, rest @ ..] = left else { return };
            left = rest;
        }
        for value in matrix {
            let Some(rest) = add_row(slots, value, &matrix, residual) else { return };
            slots = rest;
        }
        if let [slot] = slots {
            *slot += residual * residual;
        }
        self.rows = self.rows.saturating_add(1);
    }

    fn entry(&self, i: usize, j: usize) -> f32 {
        self.values.get(place(i, j)).copied().unwrap_or(0.0)
    }

    /// Adds what another block knows of the base and of a jump.
    pub(super) fn merge_base(&mut self, other: &Self) {
        let (jump, rest) = self.values.split_at_mut(start(1));
        add_scaled_f32(jump, 1.0, &other.values);
        if let (Some(to), Some(from)) = (rest.get_mut(OWN - start(1)..), other.values.get(OWN..)) {
            add_scaled_f32(to, 1.0, from);
        }
        self.rows = self.rows.saturating_add(other.rows);
    }

    /// Those of the offset's columns.
    pub(super) fn jump(&self) -> Jump {
        Jump(self.values.first_chunk().copied().unwrap_or(Jump::NONE.0))
    }

    /// The sum of an effect's number over that of ones, each weighed as the offset's columns see it: `(Σ w‖o‖², Σ ‖o‖²)`.
    pub(super) fn moment(&self, effect: usize) -> [f32; 2] {
        let sum = |first: usize| (0..3).map(|axis| self.entry(first + axis, axis)).sum();
        [sum(DRIFT + 3 * effect), sum(0)]
    }

    /// The normal matrix of the first `width` columns.
    pub(super) fn write<const P: usize>(&self, work: &mut Normal<f32, P>, width: usize) {
        for j in 0..width {
            for i in 0..=j {
                work.inform(i, j, self.entry(i, j));
            }
            work.pull(j, self.entry(j, RESIDUAL));
        }
        work.depart(self.entry(RESIDUAL, RESIDUAL));
        work.count(self.rows);
    }

    /// The matrix of the streamed columns.
    pub(super) fn add_to(&self, work: &mut Work) {
        self.write(work, STREAMED);
    }

    /// Takes the right side and the squared residual of a matrix whose columns these are.
    pub(super) fn take_right(&mut self, work: &Work) {
        for column in 0..STREAMED {
            if let Some(slot) = self.values.get_mut(place(column, RESIDUAL)) {
                *slot = work.right(column);
            }
        }
        if let Some(slot) = self.values.get_mut(place(RESIDUAL, RESIDUAL)) {
            *slot = work.squares();
        }
    }

    /// Holds an effect's number against a value further by `times`.
    pub(super) fn hold_against(&mut self, effect: usize, times: f32) {
        let (own, jump) = (1 + effect, self.jump());
        let mut take_off = |first: usize, from: &[f32]| {
            if let Some(slots) = self.values.get_mut(first..first + from.len()) {
                add_scaled_f32(slots, -times, from);
            }
        };
        let (pairs, others) = jump.0.split_at(6 * MULTIPLES);
        for (other, six) in pairs.chunks_exact(6).enumerate() {
            take_off(pair(own, other), six);
        }
        take_off(start(own) + 6 * (MULTIPLES - own), others);
        // Of its square, the second factor too.
        let cross: [f32; 6] =
            core::array::from_fn(|at| self.values.get(pair(own, 0) + at).copied().unwrap_or(0.0));
        if let Some(slots) = self.values.get_mut(pair(own, own)..) {
            add_scaled_f32(slots, -times, &cross);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_the_normal_matrix_of_the_rows_that_were_pushed_also_held_against_another_value() {
        let mut state = 9u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u32 << 23) as f32 - 1.0
        };
        let mut sums = Sums::EMPTY;
        let (mut plain, mut held): (Work, Work) = (Work::EMPTY, Work::EMPTY);
        for _ in 0..300 {
            let base = core::array::from_fn(|_| noise());
            let look = Look { residual: noise(), base, direction: [0.0; 3] };
            let effects = core::array::from_fn(|_| 2.0 + noise());
            sums.push(&look, &effects);
            for (work, times) in [(&mut plain, 0.0), (&mut held, 1.7)] {
                let mut row = [0.0; WIDEST];
                row[..BASE].copy_from_slice(&base);
                for (effect, value) in effects.iter().enumerate() {
                    let value = value - if effect == 2 { times } else { 0.0 };
                    (0..3).for_each(|axis| row[DRIFT + 3 * effect + axis] = value * base[axis]);
                }
                work.push(&row, look.residual);
            }
        }
        for (expected, times) in [(plain, 0.0), (held, 1.7)] {
            sums.hold_against(2, times);
            let mut got = Work::EMPTY;
            sums.add_to(&mut got);
            assert_eq!(got.rows(), 300);
            let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-2, "{a} {b}");
            for i in 0..STREAMED {
                (i..STREAMED).for_each(|j| near(got.entry(i, j), expected.entry(i, j)));
                near(got.right(i), expected.right(i));
            }
            near(got.squares(), expected.squares());
        }
    }
}
