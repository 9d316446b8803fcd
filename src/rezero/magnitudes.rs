//! The offset from the magnitudes of the looks.

use super::looks::{MIN_LOOKS, Rezero};
use crate::math::{eigenvalues_3x3_f32, sqrtf};
use crate::vector::{dot, inverse_3x3, minus, norm, plus, scaled, times};

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
    /// Rms of the residual of the magnitudes, µT.
    pub rms_ut: f32,
    /// Magnitude of the field that the looks show, µT.
    pub field_ut: f32,
    /// Looks.
    pub looks: usize,
    /// What the gyro added.
    pub gyro: GyroUse,
}

impl OffsetChange {
    /// Size of the change, µT.
    pub fn size_ut(&self) -> f32 {
        norm(self.change_ut)
    }
}

/// Whether a gyro helped to find the offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GyroUse {
    /// There is none, or it was silent during most of the turns.
    None,
    /// The offset is from magnitudes and gyro.
    Used,
    /// The field turned otherwise than the gyro says: the offset is from magnitudes alone.
    Disagrees,
}

impl GyroUse {
    /// The word of the console.
    pub const fn name(self) -> &'static str {
        match self {
            GyroUse::None => "none",
            GyroUse::Used => "used",
            GyroUse::Disagrees => "disagrees",
        }
    }
}

/// Why the looks show no offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoOffset {
    /// Fewer than [`MIN_LOOKS`]: the number of looks.
    TooFewLooks(usize),
    /// The field came from one plane, or nearly so; and whether a gyro could help.
    Planar(GyroUse),
}

/// The looks about their mean.
pub(super) struct Spread {
    pub(super) n: f32,
    pub(super) mean: [f32; 3],
    /// Mean square, and the right side of the equations of the centre from the mean.
    pub(super) square: [[f32; 3]; 3],
    pub(super) right: [f32; 3],
}

impl Spread {
    /// The square without noise of this variance, which adds to it and not to the right side.
    pub(super) fn without(&self, noise: f32) -> [[f32; 3]; 3] {
        let mut own = self.square;
        for (axis, row) in own.iter_mut().enumerate() {
            if let Some(value) = row.get_mut(axis) {
                *value -= noise;
            }
        }
        own
    }
}

/// The sphere about an offset.
pub(super) struct Sphere {
    pub(super) radius: f32,
    /// Variance and rms of the residual of the magnitudes.
    pub(super) variance: f32,
    pub(super) rms_ut: f32,
    /// Looks that stand for one, because successive residuals are alike.
    pub(super) memory: f32,
}

impl Sphere {
    /// Variance of the mean of `n` looks. What the matrix does is the same in all looks of a direction.
    pub(super) fn variance_of_mean(&self, n: f32, matrix_error_ut: f32) -> f32 {
        self.variance * self.memory / n + matrix_error_ut * matrix_error_ut
    }
}

/// The least and the largest eigenvalue.
pub(super) fn extremes(&[[xx, xy, xz], [_, yy, yz], [_, _, zz]]: &[[f32; 3]; 3]) -> (f32, f32) {
    let [least, _, most] = eigenvalues_3x3_f32(&[xx, xy, xz, yy, yz, zz]);
    (least, most)
}

impl Rezero {
    pub(super) fn spread(&self) -> Spread {
        let n = self.count() as f32;
        let mean = scaled(self.iter().fold([0.0; 3], plus), 1.0 / n);
        let centred = || self.iter().map(|look| minus(look, mean));
        let length2 = centred().map(|u| dot(u, u)).sum::<f32>() / n;
        let (mut square, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        for u in centred() {
            for (row, (sums, right)) in square.iter_mut().zip(&mut right).enumerate() {
                let own = u.get(row).copied().unwrap_or(0.0) / n;
                sums.iter_mut().zip(u).for_each(|(sum, value)| *sum += own * value);
                *right += 0.5 * own * (dot(u, u) - length2);
            }
        }
        Spread { n, mean, square, right }
    }

    pub(super) fn sphere(&self, offset_ut: [f32; 3]) -> Sphere {
        let n = self.count() as f32;
        let squares = || self.iter().map(|look| minus(look, offset_ut)).map(|u| dot(u, u));
        let radius2 = squares().sum::<f32>() / n;
        let radius = sqrtf(radius2);
        let (mut sum, mut products, mut last) = (0.0, 0.0, 0.0);
        for square in squares() {
            let residual = 0.5 * (square - radius2) / radius;
            sum += residual * residual;
            products += residual * last;
            last = residual;
        }
        let correlation = (products / sum.max(f32::MIN_POSITIVE)).clamp(0.0, MAX_CORRELATION);
        let memory = (1.0 + correlation) / (1.0 - correlation);
        Sphere { radius, variance: sum / (n - 4.0), rms_ut: sqrtf(sum / n), memory }
    }

    /// The change of the offset that the looks show, with the gyro if it was pushed and agrees. `matrix_error_ut` is the error of a
    /// corrected reading that the matrix makes: it is the same in all looks of a direction, and no number of them averages it out.
    ///
    /// # Errors
    /// [`NoOffset`].
    #[inline(never)]
    pub fn solve(&self, matrix_error_ut: f32) -> Result<OffsetChange, NoOffset> {
        let looks = self.count();
        if looks < MIN_LOOKS {
            return Err(NoOffset::TooFewLooks(looks));
        }
        let spread = self.spread();
        let alone = self.by_magnitudes(&spread, matrix_error_ut);
        self.by_gyro(&spread, matrix_error_ut, alone)
    }

    /// The offset from the magnitudes alone.
    #[inline(never)]
    fn by_magnitudes(&self, spread: &Spread, matrix_error_ut: f32) -> Option<OffsetChange> {
        // The size of the noise comes of a first solution.
        let mut noise = 0.0;
        // What is said where noise decides: the error is the whole field.
        let mut undecided = None;
        for _ in 0..3 {
            let own = spread.without(noise);
            let (least, most) = extremes(&own);
            let inverse = inverse_3x3(&own).filter(|_| least > MIN_SNR * noise && least > 1e-5 * most);
            let Some(inverse) = inverse else { return undecided };
            let change_ut = plus(times(&inverse, spread.right), spread.mean);
            let sphere = self.sphere(change_ut);
            let Sphere { radius, variance, rms_ut, .. } = sphere;
            let is_decided = noise > 0.0 || variance == 0.0;
            let error = radius * sqrtf(sphere.variance_of_mean(spread.n, matrix_error_ut));
            let found = OffsetChange {
                change_ut,
                error_ut: if is_decided { error / sqrtf(least) } else { radius },
                least_error_ut: if is_decided { error / sqrtf(most) } else { radius },
                rms_ut,
                field_ut: radius,
                looks: self.count(),
                gyro: GyroUse::None,
            };
            if is_decided {
                return Some(found);
            }
            undecided = Some(found);
            noise = variance;
        }
        undecided
    }
}
