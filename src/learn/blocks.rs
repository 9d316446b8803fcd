//! Four blocks of time, however long a session is.

use super::sums::Sums;

/// Blocks.
pub(super) const BLOCKS: usize = 4;
/// The shortest block, rows.
const LEAST_ROWS: u32 = 100;
/// The most rows of all blocks together, an hour at 50 samples per second: what begins today is not to be outweighed by the days
/// before it, and sums in single precision are exact enough up to here.
pub(super) const MOST_ROWS: u32 = 180_000;

/// Sums by block of time. A block is as long as a fourth of all rows. Where all blocks are full, the two neighbours that are shortest
/// together become one; with more rows than three fourths of [`MOST_ROWS`] the oldest blocks are forgotten instead. There are always
/// three of like length, and one that fills.
#[derive(Clone, Debug)]
pub(super) struct Blocks<const P: usize, const E: usize> {
    blocks: [Sums<P, E>; BLOCKS],
    /// Blocks before the one that fills.
    full: u8,
}

impl<const P: usize, const E: usize> Blocks<P, E> {
    pub(super) const fn new() -> Self {
        Self { blocks: [const { Sums::new() }; BLOCKS], full: 0 }
    }

    pub(super) fn clear(&mut self) {
        self.blocks.iter_mut().for_each(Sums::clear);
        self.full = 0;
    }

    pub(super) fn rows(&self) -> u32 {
        self.blocks.iter().map(|block| block.rows).fold(0, u32::saturating_add)
    }

    /// Blocks in their order, the last ones perhaps empty.
    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = &Sums<P, E>> {
        self.blocks.iter()
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Sums<P, E>> {
        self.blocks.iter_mut()
    }

    /// Rows before a block.
    pub(super) fn rows_before(&self, block: usize) -> u32 {
        self.blocks.iter().take(block).map(|block| block.rows).fold(0, u32::saturating_add)
    }

    /// Adds a row. `forget` is told of the oldest block before its rows leave the sums.
    #[inline]
    pub(super) fn push(&mut self, row: &[f32], residual: f32, forget: impl FnMut(&Sums<P, E>)) {
        let filling = usize::from(self.full).min(BLOCKS - 1);
        let Some(block) = self.blocks.get_mut(filling) else { return };
        block.push(row, residual);
        if block.rows >= LEAST_ROWS && block.rows >= self.rows() / BLOCKS as u32 {
            self.close(forget);
        }
    }

    /// The block that fills is full.
    fn close(&mut self, mut forget: impl FnMut(&Sums<P, E>)) {
        self.full += 1;
        while self.rows() > MOST_ROWS - MOST_ROWS / BLOCKS as u32 {
            if let Some(oldest) = self.blocks.first_mut() {
                forget(oldest);
                oldest.clear();
            }
            first_to_end(&mut self.blocks);
            self.full = self.full.saturating_sub(1);
        }
        if usize::from(self.full) < BLOCKS {
            return;
        }
        self.full -= 1;
        let together = |pair: &[Sums<P, E>]| pair.iter().map(|block| block.rows).fold(0, u32::saturating_add);
        let shortest = self.blocks.windows(2).enumerate().min_by_key(|(_, pair)| together(pair));
        let Some((first, _)) = shortest else { return };
        if let Some((one, [other, ..])) = self
            .blocks
            .split_at_mut_checked(first + 1)
            .and_then(|(before, after)| Some((before.last_mut()?, after)))
        {
            one.merge(other);
            other.clear();
        }
        if let Some(rest) = self.blocks.get_mut(first + 1..) {
            first_to_end(rest);
        }
    }
}

/// Puts the first behind all others. A rotation by one, without the panic that the library's has for an empty slice: this is on the
/// path of a sample.
pub(super) fn first_to_end<T>(all: &mut [T]) {
    let mut rest = all.iter_mut();
    let Some(mut place) = rest.next() else { return };
    for next in rest {
        core::mem::swap(place, next);
        place = next;
    }
}

#[cfg(test)]
mod tests {
    use super::{Blocks, MOST_ROWS};

    #[test]
    fn every_row_is_in_one_block_or_forgotten_with_the_oldest_and_blocks_stay_alike() {
        let mut blocks: Blocks<2, 3> = Blocks::new();
        let mut forgotten = 0;
        for row in 1..2_000_000u32 {
            blocks.push(&[1.0, (row % 7) as f32], 0.5, |oldest| forgotten += oldest.rows);
            assert_eq!(blocks.rows() + forgotten, row);
            assert!(blocks.rows() <= MOST_ROWS && (forgotten == 0 || blocks.rows() > MOST_ROWS / 3));
            if row > 1000 {
                let longest = blocks.iter().map(|block| block.rows).max().unwrap_or(0);
                assert!(longest <= blocks.rows() * 2 / 3, "{longest} of {row}");
            }
        }
        assert!(forgotten > 1_500_000);
        // Each row counts as much as any other, however long it has gone on.
        let total: f32 = blocks.iter().map(|block| block.entries[0]).sum();
        assert_eq!(total, blocks.rows() as f32);
    }
}
