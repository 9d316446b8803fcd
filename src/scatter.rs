//! What every fit starts from: the moments of order ≤ 4, centred and scaled, in double precision.
//!
//! Exact integer sums are shifted by an integer centre (still exact), and only then turned into `f64`: once, at solve
//! time. Raw, the normal matrix of a board with a large hard iron has a condition number of 1e13 and more; centred
//! and scaled it is 6 … 13.

use crate::fit::FitError;
use crate::math;
use crate::moments::Moments;
use crate::monomial::{self, COUNT, EXPONENTS, at};

/// Centred, scaled moments `m_ijk = (1/n) Σ ξⁱηʲζᵏ` with `ξ = (x_ut − centre_ut)/scale_ut`, and the quadric fits' only input.
#[derive(Clone, Debug)]
pub struct Scatter {
    /// `m_ijk`, ordered as [`monomial::EXPONENTS`]; the first is 1.
    pub(crate) moments: [f64; COUNT],
    /// Origin of the moments, µT.
    pub centre_ut: [f64; 3],
    /// Unit of the moments: the rms distance of the samples from `centre_ut`, µT.
    pub scale_ut: f64,
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
    pub fn from_moments(moments: &Moments, ut_per_count: [f64; 3]) -> Result<Self, FitError> {
        if ut_per_count.iter().any(|scale| !scale.is_finite() || *scale <= 0.0) {
            return Err(FitError::NotFinite);
        }
        if moments.count() == 0 {
            return Err(FitError::TooFewSamples { samples: 0 });
        }
        let n = moments.count() as f64;
        let mut sums = moments.sums();
        let centre: [i128; 3] = core::array::from_fn(|a| math::round(sums[a + 1] as f64 / n) as i64 as i128);
        monomial::shift(&mut sums, centre);
        let mut out = [0.0; COUNT];
        for ((slot, sum), e) in out.iter_mut().zip(sums).zip(EXPONENTS) {
            let unit: f64 = (0..3).map(|a| powi(ut_per_count[a], e[a])).product();
            *slot = sum as f64 / n * unit;
        }
        let lsb2: f64 = ut_per_count.iter().map(|s| s * s).sum::<f64>() / 3.0;
        Self::scaled(
            out,
            core::array::from_fn(|a| centre[a] as f64 * ut_per_count[a]),
            moments.count(),
            lsb2 / 12.0,
        )
    }

    fn scaled(
        mut moments: [f64; COUNT],
        centre_ut: [f64; 3],
        samples: u64,
        quantisation_ut2: f64,
    ) -> Result<Self, FitError> {
        let spread = moments[at(2, 0, 0)] + moments[at(0, 2, 0)] + moments[at(0, 0, 2)];
        if !spread.is_finite() {
            return Err(FitError::NotFinite);
        }
        let scale_ut = math::sqrt(spread);
        if scale_ut <= 0.0 {
            return Err(FitError::StuckAxis { axis: 0 });
        }
        for (slot, e) in moments.iter_mut().zip(EXPONENTS) {
            *slot /= powi(scale_ut, e[0] + e[1] + e[2]);
        }
        if moments.iter().any(|m| !m.is_finite()) {
            return Err(FitError::NotFinite);
        }
        Ok(Self { moments, centre_ut, scale_ut, samples, quantisation_ut2 })
    }

    /// The same data about the sensor's own zero, as the paper's constant reading needs it.
    pub(crate) fn about_zero(&self) -> Result<Self, FitError> {
        let mut moments = self.moments;
        monomial::shift(&mut moments, self.centre_ut.map(|c| -c / self.scale_ut));
        for (slot, e) in moments.iter_mut().zip(EXPONENTS) {
            *slot *= powi(self.scale_ut, e[0] + e[1] + e[2]);
        }
        Self::scaled(moments, [0.0; 3], self.samples, self.quantisation_ut2)
    }

    /// `m_ijk`; the caller keeps `i + j + k ≤ 4`.
    #[inline]
    pub(crate) fn moment(&self, i: usize, j: usize, k: usize) -> f64 {
        self.moments[at(i, j, k)]
    }

    /// Covariance of the samples about their mean, in units of `scale_ut²`.
    pub(crate) fn covariance(&self) -> [[f64; 3]; 3] {
        let mean = [self.moment(1, 0, 0), self.moment(0, 1, 0), self.moment(0, 0, 1)];
        let second = |a: usize, b: usize| {
            let mut e = [0; 3];
            e[a] += 1;
            e[b] += 1;
            self.moment(e[0], e[1], e[2]) - mean[a] * mean[b]
        };
        core::array::from_fn(|a| core::array::from_fn(|b| second(a, b)))
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
        let c = self.covariance();
        for axis in 0..3u8 {
            if c[usize::from(axis)][usize::from(axis)] <= 1e-12 {
                return Err(FitError::StuckAxis { axis });
            }
        }
        for (a, b) in [(0u8, 1u8), (0, 2), (1, 2)] {
            let (i, j) = (usize::from(a), usize::from(b));
            if c[i][j] * c[i][j] >= (1.0 - 1e-10) * c[i][i] * c[j][j] {
                return Err(FitError::CopiedAxis { axis: b, of: a });
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
        if !quantum_ut.is_finite() || self.centre_ut.iter().any(|c| !c.is_finite()) {
            return Err(FitError::NotFinite);
        }
        let n = self.samples as f64;
        let mut sums = self.sums;
        // Move to the mean: the centre given may be a few fields away.
        let mean: [f64; 3] = core::array::from_fn(|a| sums[a + 1] / n);
        monomial::shift(&mut sums, mean);
        let centre = core::array::from_fn(|a| self.centre_ut[a] + mean[a]);
        Scatter::scaled(sums.map(|s| s / n), centre, self.samples, quantum_ut * quantum_ut / 12.0)
    }
}

fn powi(base: f64, exponent: u8) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * base)
}
