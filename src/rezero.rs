//! The offset measured again, with the matrix kept: from turns that need not go all round.
//!
//! A battery that was swapped moves the offset and leaves the matrix. Corrected readings `v` then lie on a sphere about the error `d` of
//! the corrected offset, and `‖v − d‖²` is one number for all of them: `‖v‖² = 2 d·v + k` is linear in `d` and `k`. An arc of the sphere
//! is enough, and its covariance says for which directions. The field's magnitude is not taken as known: it may be another place.
//!
//! A *look* is the mean of the readings in which the field turned by [`LOOK_DEG`] = 6°. A board at rest gives none, so that a day on a
//! table does not outweigh a minute of turning. The last [`MAX_LOOKS`] = 64 are kept.

use crate::math::{eigenvalues_3x3_f32, sqrtf};
use crate::vector::{dot, inverse_3x3, minus, norm, scaled, times};

/// Looks that are kept.
pub const MAX_LOOKS: usize = 64;
/// Looks that an offset is measured from at least.
pub const MIN_LOOKS: usize = 24;
/// Turn of the field within one look, degrees.
pub const LOOK_DEG: f32 = 6.0;
/// Cosine of that.
const LOOK_COS: f32 = 0.994_521_9;
/// A look that takes longer than this, ms, is no turning.
const MAX_LOOK_MS: u64 = 2000;
/// Variance of the looks along an axis over that of their noise: below it noise decides the offset along that axis.
const MIN_SNR: f32 = 4.0;
/// Correlation of successive residuals is taken as at most this.
const MAX_CORRELATION: f32 = 0.9;

/// A change of the offset, in corrected axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetChange {
    /// Change, µT.
    pub change_ut: [f32; 3],
    /// Standard error in the worst direction, µT.
    pub error_ut: f32,
    /// Standard error in the best direction, µT.
    pub least_error_ut: f32,
    /// Rms of the residual, µT.
    pub rms_ut: f32,
    /// Magnitude of the field that the looks show, µT.
    pub field_ut: f32,
    /// Looks.
    pub looks: usize,
}

impl OffsetChange {
    /// Size of the change, µT.
    pub fn size_ut(&self) -> f32 {
        norm(self.change_ut)
    }
}

/// Why the looks show no offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoOffset {
    /// Fewer than [`MIN_LOOKS`]: the number of looks.
    TooFewLooks(usize),
    /// The field came from one plane, or nearly so.
    Planar,
}

/// The last looks of a board that turns, and the offset that they show.
#[derive(Clone, Debug)]
pub struct Rezero {
    looks: [[f32; 3]; MAX_LOOKS],
    /// Looks ever taken; the next goes to this place, modulo their number.
    taken: usize,
    /// Sum and number of the readings of the look that is open, its first reading, and when it began.
    open: Option<([f32; 3], u16, [f32; 3], u64)>,
}

impl Default for Rezero {
    fn default() -> Self {
        Self::new()
    }
}

impl Rezero {
    /// Without looks.
    pub const fn new() -> Self {
        Self { looks: [[0.0; 3]; MAX_LOOKS], taken: 0, open: None }
    }

    /// Forgets all looks.
    pub fn clear(&mut self) {
        (self.taken, self.open) = (0, None);
    }

    /// Number of looks.
    pub fn count(&self) -> usize {
        self.taken.min(MAX_LOOKS)
    }

    /// Takes a corrected reading, µT, of this time since power-up.
    pub fn push(&mut self, t_ms: u64, corrected_ut: [f32; 3]) {
        let length = norm(corrected_ut);
        if !length.is_finite() {
            return;
        }
        let begun = Some((corrected_ut, 1, corrected_ut, t_ms));
        let Some((sum, count, first, begun_ms)) = &mut self.open else {
            self.open = begun;
            return;
        };
        if t_ms.saturating_sub(*begun_ms) > MAX_LOOK_MS || t_ms < *begun_ms {
            self.open = begun;
        } else if dot(*first, corrected_ut) < LOOK_COS * norm(*first) * length {
            let look = scaled(*sum, 1.0 / f32::from(*count));
            if let Some(place) = self.looks.get_mut(self.taken % MAX_LOOKS) {
                *place = look;
            }
            // Past the first round only the place counts.
            self.taken = if self.taken + 1 == 2 * MAX_LOOKS { MAX_LOOKS } else { self.taken + 1 };
            self.open = begun;
        } else {
            (0..3).for_each(|axis| sum[axis] += corrected_ut[axis]);
            *count = count.saturating_add(1);
        }
    }

    /// The looks from the oldest on.
    fn iter(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        let (newer, older) = match self.taken.checked_sub(MAX_LOOKS) {
            Some(place) => self.looks.split_at(place),
            None => (self.looks.get(..self.taken).unwrap_or_default(), [].as_slice()),
        };
        older.iter().chain(newer).copied()
    }

    /// The change of the offset that the looks show. `matrix_error_ut` is the error of a corrected reading that the matrix makes: it is
    /// the same in all looks of a direction, and no number of them averages it out.
    ///
    /// # Errors
    /// [`NoOffset`].
    #[inline(never)]
    pub fn solve(&self, matrix_error_ut: f32) -> Result<OffsetChange, NoOffset> {
        let looks = self.count();
        if looks < MIN_LOOKS {
            return Err(NoOffset::TooFewLooks(looks));
        }
        let n = looks as f32;
        let mean = scaled(self.iter().fold([0.0; 3], |sum, look| minus(sum, scaled(look, -1.0))), 1.0 / n);
        let centred = || self.iter().map(|look| minus(look, mean));
        let square = centred().map(|u| dot(u, u)).sum::<f32>() / n;
        let (mut spread, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        for u in centred() {
            for (row, (sums, right)) in spread.iter_mut().zip(&mut right).enumerate() {
                let own = u.get(row).copied().unwrap_or(0.0) / n;
                sums.iter_mut().zip(u).for_each(|(sum, value)| *sum += own * value);
                *right += 0.5 * own * (dot(u, u) - square);
            }
        }
        // Noise of this variance adds to the spread and not to the right side; its size comes of a first solution.
        let mut noise = 0.0;
        // What is said where noise decides: the error is the whole field.
        let mut undecided = Err(NoOffset::Planar);
        for _ in 0..3 {
            let mut own = spread;
            for (axis, row) in own.iter_mut().enumerate() {
                if let Some(value) = row.get_mut(axis) {
                    *value -= noise;
                }
            }
            let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = own;
            let [least, _, most] = eigenvalues_3x3_f32(&[xx, xy, xz, yy, yz, zz]);
            let inverse = inverse_3x3(&own).filter(|_| least > MIN_SNR * noise && least > 1e-5 * most);
            let Some(inverse) = inverse else { return undecided };
            let centre = times(&inverse, right);
            let distance = |u: [f32; 3]| minus(u, centre);
            let radius2 = centred().map(|u| dot(distance(u), distance(u))).sum::<f32>() / n;
            let radius = sqrtf(radius2);
            let (mut squares, mut products, mut last) = (0.0, 0.0, 0.0);
            for u in centred() {
                let residual = 0.5 * (dot(distance(u), distance(u)) - radius2) / radius;
                squares += residual * residual;
                products += residual * last;
                last = residual;
            }
            let variance = squares / (n - 4.0);
            let change_ut = minus(centre, scaled(mean, -1.0));
            let rms_ut = sqrtf(squares / n);
            if noise > 0.0 || variance == 0.0 {
                let correlation = (products / squares.max(f32::MIN_POSITIVE)).clamp(0.0, MAX_CORRELATION);
                let memory = (1.0 + correlation) / (1.0 - correlation);
                let error = radius * sqrtf(variance * memory / n + matrix_error_ut * matrix_error_ut);
                return Ok(OffsetChange {
                    change_ut,
                    error_ut: error / sqrtf(least),
                    least_error_ut: error / sqrtf(most),
                    rms_ut,
                    field_ut: radius,
                    looks,
                });
            }
            let (error_ut, least_error_ut) = (radius, radius);
            undecided =
                Ok(OffsetChange { change_ut, error_ut, least_error_ut, rms_ut, field_ut: radius, looks });
            noise = variance;
        }
        undecided
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, sin};

    /// Readings while a board turns to and fro by this much about all its axes, with an offset and noise.
    fn turned(most_deg: f64, offset_ut: [f32; 3], sigma_ut: f32, seconds: u32) -> Rezero {
        let mut rezero = Rezero::new();
        let mut state = 7_u64;
        let mut normal = || {
            let mut sum = -6.0_f32;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 40) as f32 / (1_u32 << 24) as f32;
            }
            sum
        };
        for i in 0..50 * seconds {
            let t = f64::from(i) * 0.02;
            let most = most_deg.to_radians();
            let (a, b) = (most * sin(1.1 * t), most * sin(0.7 * t + 1.0));
            let field = [cos(a) * cos(b), sin(a) * cos(b), sin(b)].map(|value| (50.0 * value) as f32);
            let reading = [0, 1, 2].map(|axis| field[axis] + offset_ut[axis] + sigma_ut * normal());
            rezero.push(u64::from(i) * 20, reading);
        }
        rezero
    }

    #[test]
    fn small_turns_show_the_offset_within_its_error() {
        let truth = [4.0, -7.0, 2.5];
        let mut last = f32::INFINITY;
        for most_deg in [20.0, 30.0, 60.0] {
            let found = turned(most_deg, truth, 0.2, 60).solve(0.01).expect("an offset");
            let off = norm(minus(found.change_ut, truth));
            assert!(off < 3.0 * found.error_ut, "{most_deg}: {off} {found:?}");
            assert!(found.error_ut < last && found.least_error_ut < 0.2, "{most_deg}: {found:?}");
            last = found.error_ut;
        }
        assert!(last < 0.2, "{last}");
    }

    #[test]
    fn a_matrix_that_is_wrong_widens_the_error() {
        let rezero = turned(30.0, [4.0, -7.0, 2.5], 0.1, 60);
        let of = |error_ut| rezero.solve(error_ut).expect("an offset").error_ut;
        assert!(of(0.1) > 3.0 * of(0.0), "{} {}", of(0.1), of(0.0));
    }

    #[test]
    fn a_board_at_rest_and_one_that_turns_in_a_plane_show_none() {
        assert_eq!(turned(0.0, [1.0; 3], 0.2, 600).solve(0.0), Err(NoOffset::TooFewLooks(0)));
        let mut level = Rezero::new();
        for i in 0..3000_u32 {
            let angle = f64::from(i) * 0.02;
            level.push(
                u64::from(i) * 20,
                [(20.0 * cos(angle)) as f32, (20.0 * sin(angle)) as f32, 45.0 + 0.01 * (i % 3) as f32],
            );
        }
        assert_eq!(level.solve(0.0), Err(NoOffset::Planar));
    }
}
