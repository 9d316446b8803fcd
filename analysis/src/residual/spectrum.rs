//! The noise's spectrum, and the test of a candidate that knows it.
//!
//! Noise with a memory weighs most on the columns that vary as slowly as it does, and hardly on fast ones. So the test
//! takes the variance of what it measures, `X'r`, from the noise's power where the candidate's own columns have theirs:
//! `X'ΓX = Σ_f S(f) |X(f)|²`. One number of independent samples for all candidates would be too strict for the fast and
//! too kind to the slow.

use crate::base::term::Matrix;
use crate::noise::colour::{Colour, Described, Seen};
use crate::noise::power::{add_power, padded, symmetric, transforms, weight};
use crate::noise::turning::Turning;
use crate::residual::autoregression::Autoregression;
use crate::samples::fft;
use ironout::study::{MIN_EIGENVALUE, f_tail};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::ops::Range;

mod rows;

pub use rows::Rows;

/// The longest autoregression of the noise.
const LONGEST_ORDER: usize = 24;
/// Rounds of filling in what the fit has taken out of the noise.
const ROUNDS: usize = 6;

/// The power of noise by frequency.
pub struct Spectrum {
    /// Half spectrum; its mean over the whole circle is the variance.
    power: Vec<f64>,
    size: usize,
    /// The autoregression behind it: coefficients, and their covariance.
    coefficients: Vec<f64>,
    uncertain: DMatrix<f64>,
    /// Independent values behind the variance.
    freedom: f64,
    /// Of a colour: how the logarithm of its power changes with the one number that it was chosen by, and its variance.
    chosen: Option<(Vec<f64>, f64)>,
    /// The power of each of the sensor's axes, where that is more than a short memory: what the axes show is no stationary noise
    /// then, since each comes and goes with the turning.
    of_axes: Option<Vec<f64>>,
}

impl Spectrum {
    /// Of a residual. `absorbed` is the share that the fit takes out of the noise at each bin: it is filled in again with
    /// what the spectrum itself expects there (expectation and maximisation by turns, which ends at the most likely
    /// spectrum). The spectrum is that of an autoregression, its order chosen by Akaike's criterion: it sees a short
    /// memory at all frequencies and so says what a band holds of which the fit has left little.
    pub fn of(residuals: &[f64], absorbed: &[f64]) -> Spectrum {
        let n = residuals.len();
        let size = padded(n);
        let transform = transforms(std::slice::from_ref(&residuals.to_vec()), size).swap_remove(0);
        let seen: Vec<f64> = transform.iter().map(|(re, im)| (re * re + im * im) / n.max(1) as f64).collect();
        let share = |bin: usize| absorbed.get(bin).copied().unwrap_or(0.0).clamp(0.0, 1.0);
        let total = |power: &dyn Fn(usize) -> f64| {
            (0..seen.len()).map(|bin| weight(bin, size) * power(bin)).sum::<f64>() / size as f64
        };
        let left = 1.0 - total(&|bin| share(bin));
        let variance = total(&|bin| seen[bin]) / left.max(0.1);
        let order = LONGEST_ORDER.min(n / 40);
        let mut power = vec![variance; seen.len()];
        let freedom = n as f64 * left;
        let mut model = Autoregression { coefficients: Vec::new(), error: variance };
        let mut covariance = Vec::new();
        let mut turns = vec![(0.0, 0.0); size];
        for _ in 0..ROUNDS {
            for (bin, (a, b)) in seen.iter().zip(&power).enumerate() {
                let whole = (a + share(bin) * b, 0.0);
                turns[bin] = whole;
                turns[(size - bin) % size] = whole;
            }
            fft::forward(&mut turns);
            covariance = (0..=order).map(|lag| turns[lag].0 / size as f64).collect();
            model = Autoregression::of(&covariance, freedom);
            power = model.power(size);
        }
        let p = model.coefficients.len();
        let memory = DMatrix::from_fn(p, p, |i, j| covariance[i.abs_diff(j)]);
        let inverse = memory.cholesky().map_or_else(|| DMatrix::zeros(p, p), |factor| factor.inverse());
        let uncertain = inverse * (model.error / freedom);
        Spectrum {
            power,
            size,
            coefficients: model.coefficients,
            uncertain,
            freedom,
            chosen: None,
            of_axes: None,
        }
    }

    /// Those of the colours that the residual may be noise of; none where it is more than noise.
    fn coloured(rows: &Rows, residuals: &[f64], absorbed: &[f64]) -> Vec<Spectrum> {
        let n = residuals.len();
        let turning = match rows.alike.is_empty() {
            true => Turning::none(n),
            false => Turning {
                alike: rows.alike.clone(),
                absorbed: Vec::new(),
                of_magnitude: true,
                weights: Vec::new(),
                rest: Vec::new(),
            },
        };
        let variance = residuals.iter().map(|r| r * r).sum::<f64>() / n.max(1) as f64;
        let seen = Seen::of(residuals, &turning, absorbed, rows.rounding / variance.max(f64::MIN_POSITIVE));
        let size = padded(n);
        let taken = absorbed.iter().enumerate().map(|(bin, share)| weight(bin, size) * share.clamp(0.0, 1.0));
        let freedom = n as f64 * (1.0 - taken.sum::<f64>() / size as f64);
        let noises = seen.plausible().into_iter().filter(|one| one.is_noise(rows.step_s));
        noises
            .map(|described| Spectrum {
                size,
                coefficients: Vec::new(),
                uncertain: DMatrix::zeros(0, 0),
                freedom,
                chosen: seen.slope(&described),
                of_axes: matches!(described.colour, Colour::Flicker { .. })
                    .then(|| of_axes(rows, &described, size))
                    .flatten(),
                power: described.power,
            })
            .collect()
    }

    /// Degrees of freedom of the power where `shares` (they add up to 1) of a candidate's variance lie: two over the
    /// variance of its logarithm, from the errors of the autoregression.
    fn freedom(&self, shares: &[f64]) -> f64 {
        let p = self.coefficients.len();
        let mut slope = DVector::zeros(p);
        for (bin, share) in shares.iter().enumerate().filter(|(_, share)| **share > 1e-6) {
            let angle = std::f64::consts::TAU * bin as f64 / self.size as f64;
            // A = 1 − Σ a_j e^(−iωj), and ∂ log S / ∂a_j = 2 Re(e^(−iωj) / A).
            let (mut re, mut im) = (1.0, 0.0);
            for (j, a) in self.coefficients.iter().enumerate() {
                let (sin, cos) = (angle * (j + 1) as f64).sin_cos();
                (re, im) = (re - a * cos, im + a * sin);
            }
            let square = (re * re + im * im).max(1e-12);
            for j in 0..p {
                let (sin, cos) = (angle * (j + 1) as f64).sin_cos();
                slope[j] += share * 2.0 * (cos * re - sin * im) / square;
            }
        }
        let mut variance = 2.0 / self.freedom + slope.dot(&(&self.uncertain * &slope));
        if let Some((slope, of)) = &self.chosen {
            let along: f64 = slope.iter().zip(shares).map(|(slope, share)| slope * share).sum();
            variance += along * along * of;
        }
        2.0 / variance
    }

    /// Variance.
    pub fn variance(&self) -> f64 {
        self.power.iter().enumerate().map(|(bin, p)| weight(bin, self.size) * p).sum::<f64>()
            / self.size as f64
    }

    /// Autocorrelation at the lags below `lags`.
    pub fn correlation(&self, lags: usize) -> Vec<f64> {
        let mut turns = vec![(0.0, 0.0); self.size];
        for (bin, power) in self.power.iter().enumerate() {
            turns[bin] = (*power, 0.0);
            turns[(self.size - bin) % self.size] = (*power, 0.0);
        }
        fft::forward(&mut turns);
        let zero = turns[0].0.max(f64::MIN_POSITIVE);
        turns.iter().take(lags).map(|value| value.0 / zero).collect()
    }
}

/// The power of each axis of a sensor whose noise shows so in `rows`.
fn of_axes(rows: &Rows, described: &Described, size: usize) -> Option<Vec<f64>> {
    let n = rows.len();
    let gain = rows.weights.iter().flatten().map(|w| w * w).sum::<f64>() / n.max(1) as f64;
    if rows.weights.len() != n || gain <= 0.0 {
        return None;
    }
    let variance =
        (0..described.power.len()).map(|bin| weight(bin, size) * described.power[bin]).sum::<f64>()
            / size as f64;
    let own = symmetric(&described.colour.correlation(size), size);
    Some(own.into_iter().map(|value| (value * variance / gain).max(0.0)).collect())
}

/// `X'ΓX` of columns by their transforms, and the noise's power.
fn power_along(transforms: &[Vec<(f64, f64)>], power: &[f64], size: usize) -> DMatrix<f64> {
    DMatrix::from_fn(transforms.len(), transforms.len(), |i, j| {
        let (a, b) = (&transforms[i], &transforms[j]);
        let both = |bin: usize| a[bin].0 * b[bin].0 + a[bin].1 * b[bin].1;
        (0..power.len()).map(|bin| weight(bin, size) * power[bin] * both(bin)).sum::<f64>() / size as f64
    })
}

/// The same of noise that each axis has for itself, with that power, and that shows in the rows by these weights.
fn power_by_axes(columns: &[Vec<f64>], weights: &[[f64; 3]], power: &[f64], size: usize) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(columns.len(), columns.len());
    for axis in 0..3 {
        let of = |column: &Vec<f64>| column.iter().zip(weights).map(|(x, w)| x * w[axis]).collect();
        let seen: Vec<Vec<f64>> = columns.iter().map(of).collect();
        sum += power_along(&transforms(&seen, size), power, size);
    }
    sum
}

/// Columns made orthogonal to each other.
struct Orthogonal {
    /// They, one value a row.
    columns: Vec<Vec<f64>>,
    /// Their transforms.
    transforms: Vec<Vec<(f64, f64)>>,
    /// The residual along each.
    along: Vec<f64>,
}

/// The columns of a fit made orthogonal, and candidates beyond them.
pub struct Frame<'r> {
    rows: &'r Rows,
    /// Scaled Cholesky factor of the base.
    factor: DMatrix<f64>,
    scale: Vec<f64>,
    base: Vec<usize>,
    /// The rows in the base's own frame, row by row.
    turned: Vec<f64>,
    /// Share of the noise that the base takes out, by bin.
    absorbed: Vec<f64>,
    size: usize,
}

/// A candidate's test with the noise's spectrum.
pub struct Verdict {
    /// Probability that chance does as well.
    pub p_value: f64,
    /// By how much the noise's memory widens the candidate's errors (variance), 1 for white noise.
    pub time: f64,
}

impl<'r> Frame<'r> {
    /// Of the columns `base` of a normal matrix over the same rows.
    pub fn new(rows: &'r Rows, total: &Matrix, base: Vec<usize>) -> Option<Frame<'r>> {
        let p = base.len();
        let scale: Vec<f64> = base.iter().map(|&i| total.entry(i, i).sqrt().recip()).collect();
        let normal = DMatrix::from_fn(p, p, |i, j| total.entry(base[i], base[j]) * scale[i] * scale[j]);
        let factor = normal.cholesky()?.unpack();
        let size = padded(rows.len());
        let mut turned = Vec::with_capacity(rows.len() * p);
        for row in rows.values.chunks_exact(rows.columns.max(1)) {
            let start = turned.len();
            for i in 0..p {
                let mut sum = row[base[i]] * scale[i];
                for j in 0..i {
                    sum -= factor[(i, j)] * turned[start + j];
                }
                turned.push(sum / factor[(i, i)]);
            }
        }
        let mut absorbed = vec![0.0; size / 2 + 1];
        let columns: Vec<Vec<f64>> =
            (0..p).map(|i| turned.iter().skip(i).step_by(p.max(1)).copied().collect()).collect();
        add_power(&mut absorbed, &transforms(&columns, size), rows.len());
        Some(Frame { rows, factor, scale, base, turned, absorbed, size })
    }

    fn forward(&self, values: impl Fn(usize) -> f64) -> DVector<f64> {
        let p = self.base.len();
        let mut out = DVector::zeros(p);
        for i in 0..p {
            let mut sum = values(self.base[i]) * self.scale[i];
            for j in 0..i {
                sum -= self.factor[(i, j)] * out[j];
            }
            out[i] = sum / self.factor[(i, i)];
        }
        out
    }

    /// The directions of the columns `candidate` that are new.
    fn beyond(&self, total: &Matrix, candidate: Range<usize>) -> Option<Orthogonal> {
        let (p, k) = (self.base.len(), candidate.len());
        let norm = |column: usize| {
            let square = total.entry(column, column);
            if square > 0.0 { square.sqrt().recip() } else { 0.0 }
        };
        let scale: Vec<f64> = candidate.clone().map(norm).collect();
        let through: Vec<DVector<f64>> = candidate
            .clone()
            .zip(&scale)
            .map(|(column, s)| self.forward(|i| total.entry(i, column)) * *s)
            .collect();
        let known = self.forward(|i| total.right(i));
        let right =
            DVector::from_fn(k, |i, _| total.right(candidate.start + i) * scale[i] - through[i].dot(&known));
        let schur = DMatrix::from_fn(k, k, |i, j| {
            total.entry(candidate.start + i, candidate.start + j) * scale[i] * scale[j]
                - through[i].dot(&through[j])
        });
        if !schur.iter().chain(right.iter()).all(|value| value.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::new(schur);
        let new: Vec<DVector<f64>> = (0..k)
            .filter(|i| eigen.eigenvalues[*i] > MIN_EIGENVALUE)
            .map(|i| eigen.eigenvectors.column(i) / eigen.eigenvalues[i].sqrt())
            .collect();
        let along = new.iter().map(|direction| direction.dot(&right)).collect();
        // Weights of the candidate's own columns and of the base's, by direction.
        let own: Vec<Vec<f64>> =
            new.iter().map(|direction| direction.iter().zip(&scale).map(|(a, s)| a * s).collect()).collect();
        let taken: Vec<DVector<f64>> = new
            .iter()
            .map(|direction| {
                through.iter().zip(direction.iter()).fold(DVector::zeros(p), |sum, (t, a)| sum + t * *a)
            })
            .collect();
        let mut columns = vec![Vec::with_capacity(self.rows.len()); new.len()];
        let turned = self.turned.chunks_exact(p.max(1));
        for (row, base) in self.rows.values.chunks_exact(self.rows.columns.max(1)).zip(turned) {
            for ((out, own), taken) in columns.iter_mut().zip(&own).zip(&taken) {
                let value: f64 = row[candidate.clone()].iter().zip(own).map(|(a, b)| a * b).sum();
                out.push(value - base.iter().zip(taken.iter()).map(|(a, b)| a * b).sum::<f64>());
            }
        }
        Some(Orthogonal { transforms: transforms(&columns, self.size), columns, along })
    }

    /// The spectrum of a residual from which base and the columns `with` have been fitted.
    pub fn spectrum(&self, total: &Matrix, with: Range<usize>, residuals: &[f64]) -> Option<Spectrum> {
        let mut absorbed = self.absorbed.clone();
        if !with.is_empty() {
            add_power(&mut absorbed, &self.beyond(total, with)?.transforms, self.rows.len());
        }
        Some(Spectrum::of(residuals, &absorbed))
    }

    /// The same as the colours of a sensor's noise have it that may be this one: beyond what an autoregression remembers.
    /// None where the residual is more than such noise.
    pub fn coloured(&self, total: &Matrix, with: Range<usize>, residuals: &[f64]) -> Vec<Spectrum> {
        let mut absorbed = self.absorbed.clone();
        if !with.is_empty() {
            match self.beyond(total, with) {
                Some(beyond) => add_power(&mut absorbed, &beyond.transforms, self.rows.len()),
                None => return Vec::new(),
            }
        }
        Spectrum::coloured(self.rows, residuals, &absorbed)
    }

    /// Tests the columns `candidate` against the base.
    pub fn test(&self, total: &Matrix, candidate: Range<usize>, noise: &Spectrum) -> Option<Verdict> {
        let Orthogonal { columns, transforms, along } = self.beyond(total, candidate)?;
        let k = along.len();
        if k == 0 {
            return None;
        }
        let variance = match &noise.of_axes {
            None => power_along(&transforms, &noise.power, self.size),
            Some(power) => power_by_axes(&columns, &self.rows.weights, power, self.size),
        };
        let time = variance.trace() / (k as f64 * noise.variance());
        let along = DVector::from_vec(along);
        let statistic = along.dot(&variance.cholesky()?.solve(&along));
        let mut shares: Vec<f64> = (0..noise.power.len())
            .map(|bin| {
                let both: f64 = transforms.iter().map(|t| t[bin].0 * t[bin].0 + t[bin].1 * t[bin].1).sum();
                weight(bin, self.size) * noise.power[bin] * both
            })
            .collect();
        let sum: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= sum);
        let freedom = noise.freedom(&shares);
        Some(Verdict { p_value: f_tail(statistic / k as f64, k as f64, freedom), time })
    }
}

#[cfg(test)]
mod tests;
