//! What every fit starts from: the moments of order ≤ 4, centred and scaled, in double precision.
//!
//! Exact integer sums are shifted by an integer centre (still exact), and only then turned into `f64`: once, at solve
//! time. Raw, the normal matrix of a board with a large hard iron has a condition number of 1e13 and more; centred
//! and scaled it is 6 … 13.

use crate::dense::{all_finite, root};
use crate::moments::Moments;
use crate::monomial::{self, COUNT, EXPONENTS, at};
use crate::refusal::FitError;

/// Centred, scaled moments `m_ijk = (1/n) Σ ξⁱηʲζᵏ` with `ξ = (x_ut − centre_ut)/scale_ut`, and the quadric fits' only input.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scatter {
    /// `m_ijk`, ordered as [`monomial::EXPONENTS`]; the first is 1.
    pub(crate) moments: [f64; COUNT],
    /// Origin of the moments, µT.
    pub centre_ut: [f64; 3],
    /// Unit of the moments: the rms distance of the samples from `centre_ut`, µT.
    pub scale_ut: f64,
    /// Covariance of the samples about their mean in units of `scale_ut²`: xx, xy, xz, yy, yz, zz.
    pub(crate) covariance: [f64; 6],
    /// Number of samples.
    pub samples: u64,
    /// Variance of the quantisation (LSB²/12, mean over the axes), µT²; 0 for float data.
    pub quantisation_ut2: f64,
}

impl Scatter {
    /// The scatter of exact integer sums; `ut_per_count` is the sensor's scale on each axis, µT per count.
    ///
    /// # Errors
    /// [`FitError::NotFinite`] for a scale that is not positive and finite; [`FitError::TooFewSamples`] without
    /// samples; [`FitError::StuckAxis`] if no axis ever moved.
    #[inline(never)]
    pub fn from_moments(moments: &Moments, ut_per_count: [f64; 3]) -> Result<Self, FitError> {
        if !all_finite(&ut_per_count) || ut_per_count.iter().any(|scale| *scale <= 0.0) {
            return Err(FitError::NotFinite);
        }
        if moments.count() == 0 {
            return Err(FitError::TooFewSamples { samples: 0 });
        }
        let n = moments.count() as f64;
        let mut sums = moments.sums();
        // Any integer near the mean will do, so single precision may choose it: it has an instruction for that.
        let centre: [i128; 3] = core::array::from_fn(|a| i128::from((sums[a + 1] as f64 / n) as f32 as i32));
        monomial::shift(&mut sums, centre);
        let lsb2: f64 = ut_per_count.iter().map(|s| s * s).sum::<f64>() / 3.0;
        Self::scaled(
            sums.map(|sum| sum as f64),
            ut_per_count,
            core::array::from_fn(|a| centre[a] as f64 * ut_per_count[a]),
            moments.count(),
            lsb2 / 12.0,
        )
    }

    /// From sums about `centre_ut` in units of `unit_ut` on each axis.
    fn scaled(
        sums: [f64; COUNT],
        unit_ut: [f64; 3],
        centre_ut: [f64; 3],
        samples: u64,
        quantisation_ut2: f64,
    ) -> Result<Self, FitError> {
        let per_sample = 1.0 / samples as f64;
        let mut spread = 0.0;
        for (sum, unit) in [sums[4], sums[7], sums[9]].into_iter().zip(unit_ut) {
            spread += sum * unit * unit * per_sample;
        }
        // Outside of nanotesla … kilotesla something is wrong with the unit, and products of four must not overflow.
        if !(spread < 1e18) || !all_finite(&centre_ut) {
            return Err(FitError::NotFinite);
        }
        if !(spread > 1e-12) {
            return Err(FitError::StuckAxis { axis: 0 });
        }
        let scale_ut = root(spread);
        let mut powers = [[1.0; 5]; 3];
        // The mean over the samples goes with the first axis.
        powers[0][0] = per_sample;
        for (powers, unit) in powers.iter_mut().zip(unit_ut) {
            let unit = unit / scale_ut;
            for i in 1..5 {
                powers[i] = powers[i - 1] * unit;
            }
        }
        // The units are positive and finite, so that equal bits are equal numbers.
        let [x, y, z] = unit_ut.map(f64::to_bits);
        let isotropic = x == y && y == z;
        let mut moments = sums;
        for (slot, e) in moments.iter_mut().zip(EXPONENTS) {
            if isotropic {
                // The usual sensor: one factor for each degree.
                *slot *= powers[0][usize::from(e[0] + e[1] + e[2]).min(4)];
                continue;
            }
            for (powers, power) in powers.iter().zip(e) {
                *slot *= powers[usize::from(power).min(4)];
            }
        }
        moments[0] = 1.0;
        if !all_finite(&moments) {
            return Err(FitError::NotFinite);
        }
        let mut covariance = [0.0; 6];
        let [_, x, y, z, squares @ ..] = &moments;
        let means = [(x, x), (x, y), (x, z), (y, y), (y, z), (z, z)];
        for (slot, (square, (a, b))) in covariance.iter_mut().zip(squares.iter().zip(means)) {
            *slot = *square - a * b;
        }
        Ok(Self { moments, centre_ut, scale_ut, covariance, samples, quantisation_ut2 })
    }

    /// The same data about the sensor's own zero, as the paper's constant reading needs it.
    pub(crate) fn about_zero(&self) -> Result<Self, FitError> {
        let mut moments = self.moments;
        monomial::shift(&mut moments, self.centre_ut.map(|c| -c / self.scale_ut));
        let n = self.samples as f64;
        Self::scaled(
            moments.map(|m| m * n),
            [self.scale_ut; 3],
            [0.0; 3],
            self.samples,
            self.quantisation_ut2,
        )
    }

    /// `m_ijk`; the caller keeps `i + j + k ≤ 4`.
    #[inline]
    pub(crate) fn moment(&self, i: usize, j: usize, k: usize) -> f64 {
        self.moments[at(i, j, k)]
    }

    /// Mean of the samples, µT.
    pub fn mean_ut(&self) -> [f64; 3] {
        let first = [self.moment(1, 0, 0), self.moment(0, 1, 0), self.moment(0, 0, 1)];
        core::array::from_fn(|a| self.centre_ut[a] + first[a] * self.scale_ut)
    }

    /// Refuses data in which an axis never moves or copies another, which no fit can know better.
    ///
    /// # Errors
    /// [`FitError::StuckAxis`], [`FitError::CopiedAxis`].
    pub fn check_axes(&self) -> Result<(), FitError> {
        let [xx, xy, xz, yy, yz, zz] = self.covariance.map(|v| v as f32);
        for (axis, variance) in [xx, yy, zz].into_iter().enumerate() {
            // Written so that a NaN is refused too.
            if !(variance > 1e-12) {
                return Err(FitError::StuckAxis { axis: axis as u8 });
            }
        }
        for (of, axis, both, product) in [(0u8, 1u8, xy, xx * yy), (0, 2, xz, xx * zz), (1, 2, yz, yy * zz)] {
            // A noisy copy: the noise of a sensor of its own is thousands of times more.
            if both * both >= (1.0 - 1e-6) * product {
                return Err(FitError::CopiedAxis { axis, of });
            }
        }
        Ok(())
    }
}

/// Collects float samples about a fixed centre near the data: the host's way into [`Scatter`], for logs in µT.
///
/// Subtracting a centre near the mean first keeps the `f64` sums as good as exact ones; take the mean of a first pass,
/// or any sample.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScatterBuilder {
    sums: [f64; COUNT],
    centre_ut: [f64; 3],
    samples: u64,
}

impl ScatterBuilder {
    /// An empty builder about `centre_ut`.
    pub fn new(centre_ut: [f64; 3]) -> Self {
        Self { sums: [0.0; COUNT], centre_ut, samples: 0 }
    }

    /// Adds one sample, µT.
    pub fn push(&mut self, measured_ut: [f64; 3]) {
        let [x, y, z] = core::array::from_fn(|a| measured_ut[a] - self.centre_ut[a]);
        let powers = |v: f64| [1.0, v, v * v, v * v * v, v * v * v * v];
        let (px, py, pz) = (powers(x), powers(y), powers(z));
        for (sum, [i, j, k]) in self.sums.iter_mut().zip(EXPONENTS) {
            *sum += px[usize::from(i)] * py[usize::from(j)] * pz[usize::from(k)];
        }
        self.samples += 1;
    }

    /// Adds the samples of another builder with the same centre; `false`, and nothing changed, if the centres differ.
    pub fn merge(&mut self, other: &Self) -> bool {
        if self.centre_ut != other.centre_ut {
            return false;
        }
        for (a, b) in self.sums.iter_mut().zip(other.sums) {
            *a += b;
        }
        self.samples += other.samples;
        true
    }

    /// Number of samples so far.
    pub fn count(&self) -> u64 {
        self.samples
    }

    /// The scatter of the samples so far. `quantum_ut` is the step the values were rounded to (0 if unknown).
    ///
    /// # Errors
    /// [`FitError::TooFewSamples`] without samples, [`FitError::NotFinite`] if a sample or the step was not finite,
    /// [`FitError::StuckAxis`] if nothing moved.
    pub fn finish(&self, quantum_ut: f64) -> Result<Scatter, FitError> {
        if self.samples == 0 {
            return Err(FitError::TooFewSamples { samples: 0 });
        }
        if !all_finite(&[quantum_ut]) || !all_finite(&self.centre_ut) {
            return Err(FitError::NotFinite);
        }
        let n = self.samples as f64;
        let mut sums = self.sums;
        // Move to the mean: the centre given may be a few fields away.
        let mean: [f64; 3] = core::array::from_fn(|a| sums[a + 1] / n);
        monomial::shift(&mut sums, mean);
        let centre = core::array::from_fn(|a| self.centre_ut[a] + mean[a]);
        Scatter::scaled(sums, [1.0; 3], centre, self.samples, quantum_ut * quantum_ut / 12.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moments_are_means_of_powers_about_the_centre_in_units_of_the_rms_distance() {
        let points: [[f64; 3]; 60] = core::array::from_fn(|i| {
            let i = i as i32;
            [i * 7 % 41 - 11, i * i % 29 + 4, i * 3 % 17 - 30].map(f64::from)
        });
        let centre = [3.0, -2.0, 1.0];
        let (mut first, mut second) = (ScatterBuilder::new(centre), ScatterBuilder::new(centre));
        points[..20].iter().for_each(|point| first.push(*point));
        points[20..].iter().for_each(|point| second.push(*point));
        assert!(first.merge(&second) && first.count() == 60);
        let scatter = first.finish(0.0).expect("sound");
        let power = |base: f64, exponent: u8| (0..exponent).map(|_| base).product::<f64>();
        for (moment, exponents) in scatter.moments.iter().zip(EXPONENTS) {
            let mut mean = 0.0;
            for point in &points {
                let own = |a: usize| (point[a] - scatter.centre_ut[a]) / scatter.scale_ut;
                mean += (0..3).map(|a| power(own(a), exponents[a])).product::<f64>() / 60.0;
            }
            assert!((moment - mean).abs() < 1e-9, "{exponents:?}: {moment} instead of {mean}");
        }
    }
}
