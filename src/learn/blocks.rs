//! Four blocks of time, however long a session is.

use super::sums::Sums;

/// Blocks.
pub(super) const BLOCKS: usize = 4;
/// The shortest block, rows.
const LEAST_ROWS: u32 = 100;

/// Sums by block of time. Where all blocks are full, the two neighbours that are shortest together become one, and a block is
/// as long as a fourth of all that came before: there are always three of like length, and one that fills.
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

    #[inline]
    pub(super) fn push(&mut self, row: &[f32], residual: f32) {
        let filling = usize::from(self.full).min(BLOCKS - 1);
        let Some(block) = self.blocks.get_mut(filling) else { return };
        block.push(row, residual);
        if block.rows >= LEAST_ROWS && block.rows >= self.rows() / BLOCKS as u32 {
            self.close();
        }
    }

    /// The block that fills is full.
    fn close(&mut self) {
        if usize::from(self.full) + 1 < BLOCKS {
            self.full += 1;
            return;
        }
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
    use super::Blocks;

    #[test]
    fn every_row_is_in_one_block_and_blocks_stay_alike() {
        let mut blocks: Blocks<2, 3> = Blocks::new();
        for row in 1..200_000u32 {
            blocks.push(&[1.0, (row % 7) as f32], 0.5);
            assert_eq!(blocks.rows(), row);
            if row > 1000 {
                let longest = blocks.iter().map(|block| block.rows).max().unwrap_or(0);
                assert!(longest <= row * 2 / 3, "{longest} of {row}");
            }
        }
    }
}
