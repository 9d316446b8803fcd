//! Where the samples were, before it is known what they mean.

use super::map::{Coverage, CoverageMap};
use crate::calibration::{Calibration, norm};

/// Cells along each axis. Ten along x, so that six rows of them fit a word; more along z, where the map's bins are thinner.
const CELLS: [i32; 3] = [10, 12, 12];
const SLICES: usize = CELLS[2] as usize;
const ROWS: i32 = CELLS[1];
const ROW_BITS: i32 = CELLS[0];
const ROWS_IN_WORD: i32 = ROWS / 2;
/// The bits of one row.
const ROW: u64 = (1 << ROW_BITS) - 1;
/// How far such a middle lies beyond the edge, in widths of a cell: measured over simulated sessions of every kind
/// (`host-tests/tests/suite/coverage.rs`), so that the gap told is right on the average.
const EDGE: f32 = 0.3;
/// A cell is at first at most this large, µT: small beside any field, so that the grid is never too coarse, and large
/// enough that it grows but three or four times along each axis.
const FIRST_CELL_UT: f32 = 2.0;

/// Where samples were: a grid of bits over the box of all counts so far, kept on the board instead of the samples. The
/// coverage is drawn after the solve, when the centre is known at last. 216 bytes, integers only.
///
/// Cells are powers of two of counts wide, on each axis its own. When the box outgrows the grid along an axis, neighbouring
/// cells become one, in place: so the box always spans some half of the grid at least, and a cell is 10 to 20° wide where the whole
/// sphere was seen. A push merges or moves the cells along one axis at most, once, which bounds its
/// cost; a sample for which that is not enough is left out, and the next ones find more room.
#[derive(Clone, Debug)]
pub struct Sketch {
    /// Slices along z; two words of six rows along y; ten bits a row along x.
    cells: [[u64; 2]; SLICES],
    /// The box of the samples; its lower end is above its upper one before there are any.
    low: [i16; 3],
    high: [i16; 3],
    /// Number of the grid's first cell, counted from zero counts; even where the box grows, so that cells merge where
    /// coarser ones begin.
    origin: [i16; 3],
    /// Logarithm to base two of a cell's width in counts.
    shift: [u8; 3],
}

impl Sketch {
    /// An empty sketch for a sensor of this scale, µT per count. A scale that is no scale only makes the first cells small.
    pub fn new(ut_per_count: [f32; 3]) -> Self {
        let shift = ut_per_count.map(|scale| {
            let fits = |shift: &u8| f32::from(1u16 << shift) * scale <= FIRST_CELL_UT && scale > 0.0;
            (1..=10u8).take_while(fits).last().unwrap_or(0)
        });
        Self { cells: [[0; 2]; SLICES], low: [i16::MAX; 3], high: [i16::MIN; 3], origin: [0; 3], shift }
    }

    /// Takes a sample into account.
    #[inline]
    pub fn add(&mut self, counts: [i16; 3]) {
        if !self.add_inside(counts) && self.grow(counts) {
            self.mark(counts);
        }
    }

    /// Takes a sample into account if it lies in the box of those before it; `false` if it does not. Some 60 instructions at
    /// most, where [`Self::add`] may take a thousand.
    #[inline]
    pub fn add_inside(&mut self, counts: [i16; 3]) -> bool {
        let inside = (0..3).all(|a| self.low[a] <= counts[a] && counts[a] <= self.high[a]);
        if inside {
            self.mark(counts);
        }
        inside
    }

    #[inline]
    fn mark(&mut self, counts: [i16; 3]) {
        let cell = |a: usize| (i32::from(counts[a]) >> self.shift[a]) - i32::from(self.origin[a]);
        let (x, mut y, z) = (cell(0), cell(1), cell(2));
        // Inside the box all three are inside the grid.
        let Some([first, second]) = self.cells.get_mut(z as usize) else { return };
        let word = if y < ROWS_IN_WORD {
            first
        } else {
            y -= ROWS_IN_WORD;
            second
        };
        *word |= 1u64.unbounded_shl((y * ROW_BITS + x) as u32);
    }

    /// Makes the box larger for a sample outside of it; `false`, and the box as it was, if the grid cannot be yet.
    #[inline(never)]
    fn grow(&mut self, counts: [i16; 3]) -> bool {
        if self.is_empty() {
            for axis in 0..3 {
                let cell = i32::from(counts[axis]) >> self.shift[axis];
                self.origin[axis] = even(cell - CELLS[axis] / 2);
            }
            (self.low, self.high) = (counts, counts);
            return true;
        }
        let low = core::array::from_fn(|a| self.low[a].min(counts[a]));
        let high = core::array::from_fn(|a| self.high[a].max(counts[a]));
        let mut changed = false;
        for axis in 0..3 {
            if self.fits(axis, low[axis], high[axis]) {
                continue;
            }
            if changed {
                return false;
            }
            changed = true;
            self.make_room(axis, low[axis], high[axis]);
            if !self.fits(axis, low[axis], high[axis]) {
                return false;
            }
        }
        (self.low, self.high) = (low, high);
        true
    }

    /// The number of the cell of a count.
    fn number(&self, axis: usize, count: i16) -> i32 {
        i32::from(count) >> self.shift[axis]
    }

    fn fits(&self, axis: usize, low: i16, high: i16) -> bool {
        let origin = i32::from(self.origin[axis]);
        origin & 1 == 0 && self.number(axis, low) >= origin && self.number(axis, high) < origin + CELLS[axis]
    }

    /// One step towards room for a box along an axis: merges pairs of cells, or moves the grid. A merged grid may begin with
    /// an odd cell; it is moved before it grows.
    fn make_room(&mut self, axis: usize, low: i16, high: i16) {
        let origin = i32::from(self.origin[axis]);
        let (low_cell, high_cell) = (self.number(axis, low), self.number(axis, high));
        let too_long = high_cell - i32::from(even(low_cell)) >= CELLS[axis];
        if too_long && origin & 1 == 0 {
            self.merge_pairs(axis);
            self.shift[axis] = (self.shift[axis] + 1).min(15);
            self.origin[axis] /= 2;
            return;
        }
        let target = if too_long {
            even(origin)
        } else if low < self.low[axis] {
            // The room goes to the side on which the box grows.
            even(high_cell - CELLS[axis] + 2)
        } else {
            even(low_cell)
        };
        self.move_cells(axis, origin - i32::from(target));
        self.origin[axis] = target;
    }

    /// Makes one cell of each pair along an axis; the grid's first cell stays the first.
    fn merge_pairs(&mut self, axis: usize) {
        match axis {
            2 => {
                for slice in 0..SLICES / 2 {
                    // Never outside; said so that no panic is compiled into the path of a sample.
                    let pair = self.cells.get(2 * slice).zip(self.cells.get(2 * slice + 1));
                    let Some((&[a, b], &[c, d])) = pair else { continue };
                    if let Some(merged) = self.cells.get_mut(slice) {
                        *merged = [a | c, b | d];
                    }
                }
                self.cells.iter_mut().skip(SLICES / 2).for_each(|slice| *slice = [0; 2]);
            }
            1 => {
                for [first, second] in &mut self.cells {
                    *first = merge_rows(*first) | merge_rows(*second) << (ROWS_IN_WORD / 2 * ROW_BITS);
                    *second = 0;
                }
            }
            _ => self.cells.iter_mut().flatten().for_each(|word| *word = merge_bits(*word)),
        }
    }

    /// Moves all cells to higher places (or lower ones) along an axis. Those that were marked stay inside the grid.
    fn move_cells(&mut self, axis: usize, by: i32) {
        let steps = by.unsigned_abs();
        match axis {
            _ if by == 0 => {}
            2 => {
                // Slice by slice: moving them all at once would link a `memmove` of a kilobyte and a half.
                for place in 0..SLICES {
                    let to = if by > 0 { SLICES - 1 - place } else { place };
                    let from =
                        if by > 0 { to.checked_sub(steps as usize) } else { Some(to + steps as usize) };
                    let moved = from.and_then(|from| self.cells.get(from)).copied().unwrap_or_default();
                    if let Some(slice) = self.cells.get_mut(to) {
                        *slice = moved;
                    }
                }
            }
            1 => {
                const HALF: i32 = ROWS_IN_WORD * ROW_BITS;
                const WORD: u64 = (1 << HALF) - 1;
                for [first, second] in &mut self.cells {
                    // Row by row: a shift of 128 bits by an unknown number takes more code than time.
                    for _ in 0..steps.min(ROWS as u32) {
                        (*first, *second) = if by > 0 {
                            (
                                *first << ROW_BITS & WORD,
                                (*second << ROW_BITS | *first >> (HALF - ROW_BITS)) & WORD,
                            )
                        } else {
                            (*first >> ROW_BITS | *second << (HALF - ROW_BITS) & WORD, *second >> ROW_BITS)
                        };
                    }
                }
            }
            _ => {
                for word in self.cells.iter_mut().flatten() {
                    *word = if by > 0 { word.unbounded_shl(steps) } else { word.unbounded_shr(steps) };
                }
            }
        }
    }

    /// Whether there was no sample yet.
    pub fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }

    /// The longest side of the box of all samples, µT; 0 without any. `ut_per_count` is the sensor's scale.
    pub fn extent_ut(&self, ut_per_count: [f32; 3]) -> f32 {
        let sides = self.high.iter().zip(&self.low).zip(ut_per_count);
        sides.map(|((high, low), scale)| (f32::from(*high) - f32::from(*low)) * scale).fold(0.0, f32::max)
    }

    /// The coverage of the samples as corrected by `calibration`; `ut_per_count` is the sensor's scale.
    #[inline(never)]
    pub fn coverage(&self, calibration: &Calibration<f32>, ut_per_count: [f32; 3]) -> Coverage {
        let mut map = CoverageMap::new();
        let ([scale_x, scale_y, scale_z], [off_x, off_y, off_z]) = (ut_per_count, calibration.offset_ut);
        let x = self.middles_ut(0, scale_x, off_x);
        let y = self.middles_ut(1, scale_y, off_y);
        let z = self.middles_ut(2, scale_z, off_z);
        let matrix = &calibration.matrix;
        let column = |k: usize, v: f32| [matrix[0][k] * v, matrix[1][k] * v, matrix[2][k] * v];
        let add = |a: [f32; 3], b: [f32; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        for (slice, z) in self.cells.iter().zip(z) {
            let z = column(2, z);
            for (row, y) in y.iter().enumerate() {
                let in_word = row as i32 % ROWS_IN_WORD;
                let word = if in_word == row as i32 { slice[0] } else { slice[1] };
                let mut bits = (word >> (in_word * ROW_BITS)) as u32 & ROW as u32;
                if bits == 0 {
                    continue;
                }
                let zy = add(z, column(1, *y));
                while bits != 0 {
                    // There are more middles than bits.
                    if let Some(x) = x.get(bits.trailing_zeros() as usize) {
                        map.add(add(zy, column(0, *x)));
                    }
                    bits &= bits - 1;
                }
            }
        }
        let mut coverage = map.coverage();
        // Cells at the edge of what was seen reach beyond it: the nearest of their middles is nearer than the nearest sample.
        let widths_ut: f32 =
            (0..3).map(|a| f32::from(1u16 << self.shift[a]) * ut_per_count[a] * norm(column(a, 1.0))).sum();
        let beyond_deg = (EDGE * widths_ut / 3.0 / calibration.field_ut).to_degrees();
        if beyond_deg.is_finite() {
            coverage.gap_deg = (coverage.gap_deg + beyond_deg).clamp(0.0, 180.0);
        }
        coverage
    }

    /// The middles of the cells along an axis, of as much of each as lies in the box, less the offset; µT.
    fn middles_ut(&self, axis: usize, ut_per_count: f32, offset_ut: f32) -> [f32; SLICES] {
        let (low, high) = (i32::from(self.low[axis]), i32::from(self.high[axis]));
        let width = 1i32 << self.shift[axis];
        let mut first = i32::from(self.origin[axis]) * width;
        core::array::from_fn(|_| {
            let twice = first.max(low) + (first + width - 1).min(high);
            first += width;
            0.5 * twice as f32 * ut_per_count - offset_ut
        })
    }

    /// The middle of the box of all samples, µT.
    fn middle_ut(&self, ut_per_count: [f32; 3]) -> [f32; 3] {
        let ([low_x, low_y, low_z], [high_x, high_y, high_z]) = (self.low, self.high);
        let middle = |low: i16, high: i16, scale: f32| (f32::from(low) + f32::from(high)) * 0.5 * scale;
        let [x, y, z] = ut_per_count;
        [middle(low_x, high_x, x), middle(low_y, high_y, y), middle(low_z, high_z, z)]
    }

    /// What stands for a calibration before there is one: about the middle of the box of all samples.
    pub fn calibration_about_middle(&self, ut_per_count: [f32; 3]) -> Calibration<f32> {
        let (offset_ut, radius_ut) = (self.middle_ut(ut_per_count), 0.5 * self.extent_ut(ut_per_count));
        Calibration { offset_ut, ..Calibration::identity(radius_ut) }
    }

    /// The coverage before there is a calibration.
    pub fn coverage_about_middle(&self, ut_per_count: [f32; 3]) -> Coverage {
        self.coverage(&self.calibration_about_middle(ut_per_count), ut_per_count)
    }
}

/// The even number at or below. Cells of 16-bit counts have 16-bit numbers, less the little that the grid reaches beyond.
fn even(number: i32) -> i16 {
    (number & !1).clamp(-32768, 32766) as i16
}

/// Makes one row of each pair of the six.
fn merge_rows(word: u64) -> u64 {
    let pairs = word | word >> ROW_BITS;
    pairs & ROW
        | (pairs >> ROW_BITS) & (ROW << ROW_BITS)
        | (pairs >> (2 * ROW_BITS)) & (ROW << (2 * ROW_BITS))
}

/// Makes one bit of each pair of the ten, in all six rows at once.
fn merge_bits(word: u64) -> u64 {
    // Each mask is one of a row's, six times.
    const fn rows(mask: u64) -> u64 {
        let mut all = 0;
        let mut row = 0;
        while row < ROWS_IN_WORD {
            all |= mask << (row * ROW_BITS);
            row += 1;
        }
        all
    }
    const PAIRS: u64 = rows(0b01_0101_0101);
    let pairs = (word | word >> 1) & PAIRS;
    // From places 0 2 4 6 8 to 0 1 4 5 8, to 0 1 2 3 8, to 0 1 2 3 4.
    let twos = pairs & rows(0b01_0001_0001) | (pairs >> 1) & rows(0b00_0010_0010);
    let fours = twos & rows(0b01_0000_0011) | (twos >> 2) & rows(0b00_0000_1100);
    fours & rows(0b00_0000_1111) | (fours >> 4) & rows(0b00_0001_0000)
}

const _: () = assert!(core::mem::size_of::<Sketch>() <= 216, "the sketch's memory is a promise");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    extern crate std;
    use std::collections::BTreeSet;
    use std::vec::Vec;

    /// The cells marked, by number.
    fn marked(sketch: &Sketch) -> BTreeSet<[i32; 3]> {
        let mut all = BTreeSet::new();
        for x in 0..10i32 {
            for y in 0..12i32 {
                for z in 0..12i32 {
                    let word = sketch.cells[z as usize][(y / 6) as usize];
                    if word >> (y % 6 * 10 + x) & 1 == 1 {
                        all.insert([x, y, z].map({
                            let mut a = 0;
                            move |cell| {
                                a += 1;
                                i32::from(sketch.origin[a - 1]) + cell
                            }
                        }));
                    }
                }
            }
        }
        all
    }

    fn noise(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
    }

    #[test]
    fn however_the_grid_grows_each_sample_taken_is_in_its_cell_and_no_other_cell_is_marked() {
        let mut state = 7;
        for run in 0..300 {
            let mut sketch = Sketch::new([[0.1f32, 0.006, 1.5, 0.0][run % 4]; 3]);
            // From a few counts to the whole range, round or flat, smooth or scattered, anywhere.
            let size = [0, 1, 2].map(|_| math::exp(10.3 * (noise(&mut state) + 0.5)));
            let centre = size.map(|s| (32_700.0 - s) * 2.0 * noise(&mut state));
            let step = [1e-3, 0.02, 0.3, 3.0][run / 4 % 4];
            let mut taken = Vec::new();
            let mut out = 0;
            for i in 0..2000 {
                let (tilt, turn) = (0.37 * f64::from(i) * step, f64::from(i) * step);
                let u =
                    [math::cos(tilt) * math::cos(turn), math::cos(tilt) * math::sin(turn), math::sin(tilt)];
                let counts = [0, 1, 2].map(|a| (centre[a] + size[a] * u[a] + noise(&mut state)) as i16);
                sketch.add(counts);
                if (0..3).all(|a| sketch.low[a] <= counts[a] && counts[a] <= sketch.high[a]) {
                    taken.push(counts);
                } else {
                    out += 1;
                }
            }
            let expected: BTreeSet<[i32; 3]> =
                taken.iter().map(|c| core::array::from_fn(|a| i32::from(c[a]) >> sketch.shift[a])).collect();
            assert_eq!(marked(&sketch), expected, "run {run}");
            // A few are left out wherever the grid grew by more than one step at once.
            assert!(out <= 60, "run {run}: {out} samples left out, shift {:?}", sketch.shift);
            for axis in 0..3 {
                let cells =
                    sketch.number(axis, sketch.high[axis]) - sketch.number(axis, sketch.low[axis]) + 1;
                assert!(cells <= CELLS[axis], "run {run}");
                let first = Sketch::new([[0.1f32, 0.006, 1.5, 0.0][run % 4]; 3]).shift[axis];
                assert!(
                    sketch.shift[axis] == first || cells >= CELLS[axis] / 2,
                    "run {run}: {cells} cells are coarse"
                );
            }
        }
    }

    #[test]
    fn a_sketch_of_the_whole_sphere_covers_it() {
        let mut sketch = Sketch::new([0.1; 3]);
        assert!(sketch.is_empty() && sketch.extent_ut([0.1; 3]) == 0.0);
        assert_eq!(sketch.coverage_about_middle([0.1; 3]).gap_deg, 180.0);
        for i in 0..5000 {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 5000.0;
            let (r, angle) = (math::sqrt(1.0 - z * z), f64::from(i) * 0.7);
            let u = [r * math::cos(angle), r * math::sin(angle), z];
            sketch.add(u.map(|v| (500.0 * v + 930.0) as i16));
        }
        let c = sketch.coverage_about_middle([0.1; 3]);
        assert!(c.fraction > 0.97 && c.gap_deg < 20.0, "{c:?}");
        assert!((sketch.extent_ut([0.1; 3]) - 100.0).abs() < 0.2);
    }

    #[test]
    fn pairs_of_rows_and_bits_become_one() {
        for row in 0..6 {
            for bit in 0..10 {
                let word = 1u64 << (row * 10 + bit);
                assert_eq!(merge_rows(word), 1 << (row / 2 * 10 + bit), "{row} {bit}");
                assert_eq!(merge_bits(word), 1 << (row * 10 + bit / 2), "{row} {bit}");
            }
        }
        assert_eq!(merge_bits((1 << 60) - 1), (0..6).map(|row| 0x1f << (10 * row)).sum::<u64>());
    }
}
