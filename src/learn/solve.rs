//! Solving packed sums for chosen columns, in single precision.

use super::sums::{WIDEST, WIDEST_ENTRIES, Work, at};
use crate::math;
use crate::study::MIN_EIGENVALUE;

/// Information without data that every effect's unit column gets where a step is taken, so that directions the data do not show
/// stay at zero.
const RIDGE: f32 = 1e-5;
/// A pivot of the base below this is rounding, ...
pub(super) const LEAST_PIVOT: f32 = 4e-6;
/// ... and one of an effect's columns below this no direction of its own.
const LEAST_OWN_PIVOT: f32 = 1e-4;
/// The most columns of one candidate.
pub(super) const MOST_OF_ONE: usize = 3;

/// Columns chosen, in their order; the first [`Chosen::base`] of them belong to the base model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen {
    columns: [u8; WIDEST],
    n: u8,
    pub(super) base: u8,
}

impl Chosen {
    /// The first columns.
    pub(super) fn base(base: usize) -> Self {
        let mut chosen = Self { columns: [0; WIDEST], n: 0, base: base.min(WIDEST) as u8 };
        chosen.add(0, base);
        chosen
    }

    /// `count` columns from `first` on, too.
    pub(super) fn add(&mut self, first: usize, count: usize) {
        for column in first..first + count {
            if let Some(slot) = self.columns.get_mut(usize::from(self.n)) {
                *slot = column as u8;
                self.n += 1;
            }
        }
    }

    /// The same with further columns.
    pub(super) fn with(mut self, first: usize, count: usize) -> Self {
        self.add(first, count);
        self
    }

    pub(super) fn len(&self) -> usize {
        usize::from(self.n)
    }

    fn iter(&self) -> impl Iterator<Item = usize> + Clone {
        self.columns.iter().take(self.len()).map(|column| usize::from(*column))
    }
}

/// `L` with `L Lᵀ = S N S` over chosen columns, `S` the scale to unit columns.
pub(super) struct Factor {
    chosen: Chosen,
    lower: [f32; WIDEST_ENTRIES],
    scale: [f32; WIDEST],
}

/// What a candidate adds beyond the columns before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gained {
    /// What it takes off the squared error, that without it refitted.
    pub(super) decrease: f32,
    /// Its directions that are new.
    pub(super) directions: u8,
}

impl Factor {
    /// `None` where the columns are not determined. With a `ridge` only the base has to be.
    pub(super) fn of(sums: &Work, chosen: Chosen, ridge: bool) -> Option<Self> {
        let mut factor = Self { chosen, lower: [0.0; WIDEST_ENTRIES], scale: [0.0; WIDEST] };
        for (place, column) in chosen.iter().enumerate() {
            let size = sums.entry(column, column);
            // A column of zeros is no direction: with a ridge it stays at zero.
            let scale = match size > 0.0 && size.is_finite() {
                true => 1.0 / math::sqrtf(size),
                false if ridge && place >= usize::from(chosen.base) => 0.0,
                false => return None,
            };
            *factor.scale.get_mut(place)? = scale;
        }
        for (i, row) in chosen.iter().enumerate() {
            let (done, line) = factor.lower.split_at_mut_checked(at(i, 0))?;
            let own_scale = *factor.scale.get(i)?;
            for (j, column) in chosen.iter().take(i + 1).enumerate() {
                let mut sum = sums.entry(row, column) * own_scale * *factor.scale.get(j)?;
                let before = line.get(..j)?;
                if i == j {
                    for value in before {
                        sum -= value * value;
                    }
                    if ridge && i >= usize::from(chosen.base) {
                        if !(sum > LEAST_OWN_PIVOT) {
                            // It says nothing beyond the columns before it, and is left out.
                            line.iter_mut().take(i).for_each(|value| *value = 0.0);
                            *line.get_mut(j)? = 1.0;
                            *factor.scale.get_mut(i)? = 0.0;
                            continue;
                        }
                        sum += RIDGE;
                    }
                    if !(sum > LEAST_PIVOT && sum.is_finite()) {
                        return None;
                    }
                    *line.get_mut(j)? = math::sqrtf(sum);
                } else {
                    let other = done.get(at(j, 0)..at(j, 0) + j + 1)?;
                    for (a, b) in before.iter().zip(other) {
                        sum -= a * b;
                    }
                    *line.get_mut(j)? = sum / *other.get(j)?;
                }
            }
        }
        Some(factor)
    }

    /// `L⁻¹ S b`, of values by column.
    fn forward(&self, b: impl Fn(usize) -> f32) -> [f32; WIDEST] {
        let mut y = [0.0; WIDEST];
        for (i, column) in self.chosen.iter().enumerate() {
            let Some(line) = self.lower.get(at(i, 0)..at(i, 0) + i + 1) else { break };
            let mut sum = b(column) * self.scale.get(i).copied().unwrap_or(0.0);
            for (l, known) in line.iter().zip(&y).take(i) {
                sum -= l * known;
            }
            if let (Some(out), Some(pivot)) = (y.get_mut(i), line.get(i)) {
                *out = sum / pivot;
            }
        }
        y
    }

    /// `N⁻¹ b`, by column; zero for those that were not chosen.
    fn solve(&self, b: impl Fn(usize) -> f32) -> [f32; WIDEST] {
        let mut y = self.forward(b);
        let n = self.chosen.len();
        let lower = |i: usize, j: usize| self.lower.get(at(i, j)).copied().unwrap_or(0.0);
        for i in (0..n).rev() {
            let mut sum = y.get(i).copied().unwrap_or(0.0);
            for (k, known) in y.iter().enumerate().take(n).skip(i + 1) {
                sum -= lower(k, i) * known;
            }
            if let Some(out) = y.get_mut(i) {
                *out = sum / lower(i, i);
            }
        }
        let mut out = [0.0; WIDEST];
        for ((column, value), scale) in self.chosen.iter().zip(&y).zip(&self.scale) {
            if let Some(slot) = out.get_mut(column) {
                *slot = value * scale;
            }
        }
        out
    }

    /// The step `δ = −N⁻¹g`, by column.
    pub(super) fn step(&self, sums: &Work) -> [f32; WIDEST] {
        self.solve(|column| -sums.right(column))
    }

    /// The diagonal entry of `N⁻¹` of a column.
    pub(super) fn inverse(&self, column: usize) -> f32 {
        let unit = |other: usize| if other == column { 1.0 } else { 0.0 };
        self.forward(unit).iter().map(|value| value * value).sum()
    }

    /// The largest standard error among the base's columns, for noise as large as what all leave.
    pub(super) fn largest_error(&self, sums: &Work) -> f32 {
        let freedom = (sums.rows as f32 - self.chosen.len() as f32).max(1.0);
        let variance = self.squares(sums) / freedom;
        let largest = self
            .chosen
            .iter()
            .take(usize::from(self.chosen.base))
            .map(|column| self.inverse(column))
            .fold(0.0, f32::max);
        math::sqrtf(variance * largest)
    }

    /// The squared error with the chosen columns.
    pub(super) fn squares(&self, sums: &Work) -> f32 {
        let known = self.forward(|column| sums.right(column));
        known.iter().take(self.chosen.len()).fold(sums.squares, |left, value| left - value * value).max(0.0)
    }

    /// Tests `count` columns from `first` on, whose values are multiples of the columns 0 to 2 (an offset's, by something): a
    /// constant part of that something is no direction of its own.
    pub(super) fn test(&self, sums: &Work, first: usize, count: usize, is_offset: bool) -> Gained {
        let k = count.min(MOST_OF_ONE);
        let known = self.forward(|column| sums.right(column));
        let through: [[f32; WIDEST]; MOST_OF_ONE] = core::array::from_fn(|i| match i < k {
            true => self.forward(|column| sums.entry(column, first + i)),
            false => [0.0; WIDEST],
        });
        let dot = |a: &[f32; WIDEST], b: &[f32; WIDEST]| {
            a.iter().zip(b).take(self.chosen.len()).map(|(x, y)| x * y).sum::<f32>()
        };
        let scale: [f32; MOST_OF_ONE] = core::array::from_fn(|i| {
            let mut size = sums.entry(first + i, first + i);
            if is_offset && sums.entry(i, i) > 0.0 {
                let with = sums.entry(first + i, i);
                size -= with * with / sums.entry(i, i);
            }
            // Less than rounding is nothing.
            if size > 1e-6 * sums.entry(first + i, first + i) { 1.0 / math::sqrtf(size) } else { 0.0 }
        });
        let schur: [[f32; MOST_OF_ONE]; MOST_OF_ONE] = core::array::from_fn(|i| {
            core::array::from_fn(|j| match i < k && j < k {
                true => {
                    (sums.entry(first + i, first + j) - dot(&through[i], &through[j])) * scale[i] * scale[j]
                }
                false => 0.0,
            })
        });
        let right: [f32; MOST_OF_ONE] = core::array::from_fn(|i| match i < k {
            true => (sums.right(first + i) - dot(&through[i], &known)) * scale[i],
            false => 0.0,
        });
        decrease(schur, right, k)
    }
}

/// What the first `k` of some columns, in unit size and with all before them projected out, take off the squared error.
pub(super) fn decrease(
    mut schur: [[f32; MOST_OF_ONE]; MOST_OF_ONE],
    mut right: [f32; MOST_OF_ONE],
    k: usize,
) -> Gained {
    let k = k.min(MOST_OF_ONE);
    // Elimination with the largest pivot first: what is left in the directions that it drops is below the limit.
    let mut gained = Gained { decrease: 0.0, directions: 0 };
    let mut open = [true; MOST_OF_ONE];
    for _ in 0..k {
        let mut best = (MIN_EIGENVALUE as f32, None);
        for i in 0..k {
            if open[i] && schur[i][i] > best.0 {
                best = (schur[i][i], Some(i));
            }
        }
        let (pivot, Some(p)) = best else { break };
        let p = p.min(MOST_OF_ONE - 1);
        let value = right[p];
        gained.decrease += value * value / pivot;
        gained.directions += 1;
        open[p] = false;
        for i in 0..k {
            if open[i] {
                let share = schur[i][p] / pivot;
                right[i] -= share * value;
                for j in 0..k {
                    schur[i][j] -= share * schur[p][j];
                }
            }
        }
    }
    if !gained.decrease.is_finite() {
        gained = Gained { decrease: 0.0, directions: 0 };
    }
    gained
}
