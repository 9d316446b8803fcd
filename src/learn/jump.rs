//! A jump of the offset, and the test of many of them beside the plain base: what runs with every few samples.

use super::blocks::Blocks;
use super::cross::Cross;
use super::layout::{ENTRIES, STREAMED};
use super::point::BASE;
use super::solve::{LEAST_PIVOT, decrease};
use super::sums::at;
use crate::math;

/// A moment, with the sums of all rows before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct At {
    pub(super) rows: u32,
    /// ms of the board's clock.
    pub(super) t_ms: u32,
    pub(super) cross: Cross,
}

/// The plain base, solved.
pub(super) struct Base {
    /// `L` with `L Lᵀ = N`, ...
    lower: [[f32; BASE]; BASE],
    /// ... the inverse of its diagonal, ...
    inverse: [f32; BASE],
    /// ... and `L⁻¹ g`.
    known: [f32; BASE],
    /// Squared error that it leaves.
    pub(super) left: f32,
}

impl Base {
    /// `None` where the samples do not tell it.
    pub(super) fn of(blocks: &Blocks<STREAMED, ENTRIES>) -> Option<Self> {
        let (mut lower, mut known) = ([[0.0; BASE]; BASE], [0.0; BASE]);
        let mut left = 0.0;
        for block in blocks.iter().filter(|block| block.rows > 0) {
            let mut entries = block.entries.iter();
            for (i, row) in lower.iter_mut().enumerate() {
                row.iter_mut().take(i + 1).zip(&mut entries).for_each(|(sum, value)| *sum += value);
            }
            known.iter_mut().zip(&block.right).for_each(|(sum, value)| *sum += value);
            left += block.squares;
        }
        const { assert!(at(BASE, 0) == BASE * (BASE + 1) / 2, "the base's triangle stands first") };
        let mut inverse = [0.0; BASE];
        for i in 0..BASE {
            for j in 0..i {
                let mut sum = lower[i][j];
                for k in 0..j {
                    sum -= lower[i][k] * lower[j][k];
                }
                lower[i][j] = sum * inverse[j];
            }
            let size = lower[i][i];
            let mut sum = size;
            for k in 0..i {
                sum -= lower[i][k] * lower[i][k];
            }
            if !(sum > LEAST_PIVOT * size && sum.is_finite()) {
                return None;
            }
            lower[i][i] = math::sqrtf(sum);
            inverse[i] = 1.0 / lower[i][i];
            let mut value = known[i];
            for k in 0..i {
                value -= lower[i][k] * known[k];
            }
            known[i] = value * inverse[i];
            left -= known[i] * known[i];
        }
        Some(Self { lower, inverse, known, left: left.max(0.0) })
    }

    /// What a jump since which these sums were taken takes off the squared error.
    pub(super) fn decrease(&self, since: &Cross) -> f32 {
        let (mut through, own, mut right) = (since.base(), since.own(), since.right());
        let mut schur = own;
        for i in 0..BASE {
            let mut row = through[i];
            for k in 0..i {
                let share = self.lower[i][k];
                for (value, known) in row.iter_mut().zip(&through[k]) {
                    *value -= share * known;
                }
            }
            let row = row.map(|value| value * self.inverse[i]);
            through[i] = row;
            for a in 0..3 {
                right[a] -= row[a] * self.known[i];
                for b in 0..3 {
                    schur[a][b] -= row[a] * row[b];
                }
            }
        }
        // To unit columns.
        let scale = [own[0][0], own[1][1], own[2][2]]
            .map(|size| if size > 0.0 { 1.0 / math::sqrtf(size) } else { 0.0 });
        for a in 0..3 {
            right[a] *= scale[a];
            for b in 0..3 {
                schur[a][b] *= scale[a] * scale[b];
            }
        }
        decrease(schur, right, 3).decrease
    }
}
