//! Noise where the board does not turn.
//!
//! A sensor's noise is the same at rest and on the move. An error that the board's turning brings in and out of the field's direction is
//! not: at rest it stands still with the board. So a memory that shows only while the board turns is no noise's.

use crate::noise::colour::Colour;
use crate::noise::power::padded;
use crate::noise::turning::{Rest, Turning};

/// A board that turns by less than this within a stretch rests there, rad.
const RESTS: f64 = 0.15;
/// A stretch is at least so many samples ...
const SHORTEST: usize = 16;
/// ... and counts as several where it is longer than this.
const LONGEST: usize = 1024;

/// Where the readings' rounding is more than this share of the variance a resting board's readings say nothing.
const ROUNDED: f64 = 0.25;

/// How a residual is where the board rests, against the noise that the whole of it is most like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Still {
    /// Its squares over those of that noise.
    pub share: f64,
    /// Standard deviations by which they are more.
    pub sigmas: f64,
    /// Samples at rest.
    pub samples: usize,
}

impl Still {
    /// Of a residual that is most like noise of this colour, `rounding` the share of its variance that is the readings' rounding.
    /// `None` where the board never rests.
    pub fn of(residuals: &[f64], turning: &Turning, colour: Colour, rounding: f64) -> Option<Still> {
        let weights = &turning.weights;
        let n = residuals.len();
        if weights.len() != n || n == 0 {
            return None;
        }
        let size = padded(n);
        let mut own = colour.correlation(size);
        own.iter_mut().for_each(|value| *value *= 1.0 - rounding);
        own[0] = 1.0;
        let gain = |w: &[f64; 3]| w.iter().map(|x| x * x).sum::<f64>();
        let mean_gain = weights.iter().map(gain).sum::<f64>() / n as f64;
        let whole = residuals.iter().map(|r| r * r).sum::<f64>() / n as f64 / mean_gain;
        let mut sums = Sums::default();
        for stretch in stretches(weights) {
            let gain = weights[stretch.clone()].iter().map(gain).sum::<f64>() / stretch.len() as f64;
            sums.add(&residuals[stretch], whole * gain, &own);
        }
        // Where most of the noise is rounding a resting reading stands still.
        if rounding < ROUNDED {
            for Rest { residuals, gain } in &turning.rest {
                let pieces = residuals.chunks(LONGEST).filter(|piece| piece.len() >= SHORTEST);
                pieces.for_each(|piece| sums.add(piece, whole * gain, &own));
            }
        }
        // How well the squares of the whole are known themselves.
        let memory =
            own[..n.min(own.len())].iter().skip(1).map(|value| 2.0 * value * value).sum::<f64>() + 1.0;
        sums.variance += 2.0 * memory / n as f64 * sums.expected * sums.expected;
        sums.still()
    }
}

/// Squares about the mean of stretches, and what noise would make of them.
#[derive(Default)]
struct Sums {
    seen: f64,
    expected: f64,
    variance: f64,
    samples: usize,
}

impl Sums {
    /// Adds a stretch of a series that should have this variance and correlation.
    fn add(&mut self, part: &[f64], scale: f64, own: &[f64]) {
        let Some(own) = own.get(..part.len()) else { return };
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        let (trace, squares) = centred(own);
        self.seen += part.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>();
        self.expected += scale * trace;
        self.variance += 2.0 * scale * scale * squares;
        self.samples += part.len();
    }

    fn still(&self) -> Option<Still> {
        let still = Still {
            share: self.seen / self.expected,
            sigmas: (self.seen - self.expected) / self.variance.sqrt(),
            samples: self.samples,
        };
        (still.share.is_finite() && still.sigmas.is_finite()).then_some(still)
    }
}

/// Where the field's direction stays, seen from the board: long stretches in pieces.
fn stretches(weights: &[[f64; 3]]) -> Vec<std::ops::Range<usize>> {
    let mut list = Vec::new();
    let mut from = 0;
    let mut sum = [0.0; 3];
    for (at, w) in weights.iter().enumerate() {
        if from < at && (at - from == LONGEST || !stays(&sum, w)) {
            list.push(from..at);
            (from, sum) = (at, [0.0; 3]);
        }
        for (total, value) in sum.iter_mut().zip(w) {
            *total += value;
        }
    }
    list.push(from..weights.len());
    list.retain(|stretch| stretch.len() >= SHORTEST);
    list
}

/// Whether a direction is within the angle of the mean of those before it.
fn stays(sum: &[f64; 3], w: &[f64; 3]) -> bool {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let cos = dot(sum, w) / (dot(sum, sum) * dot(w, w)).sqrt();
    cos > RESTS.cos()
}

/// Trace and sum of squares of `P R P`: `R` the covariance of so many samples, which depends on their distance, `P` the projection that
/// takes their mean out. The sum of squares about the mean of such noise has the trace as its mean, and twice the squares as its variance.
fn centred(own: &[f64]) -> (f64, f64) {
    let n = own.len();
    let length = n as f64;
    let mut squares = 0.0;
    let mut sums = vec![0.0; n + 1];
    for (lag, value) in own.iter().enumerate() {
        let pairs = if lag == 0 { length } else { 2.0 * (n - lag) as f64 };
        squares += pairs * value * value;
        sums[lag + 1] = sums[lag] + value;
    }
    // Sums of the rows.
    let rows = (0..n).map(|i| sums[i + 1] + sums[n - i] - own[0]);
    let (whole, row_squares) = rows.fold((0.0, 0.0), |(sum, squares), row| (sum + row, squares + row * row));
    let trace = length * own[0] - whole / length;
    (trace, squares - 2.0 * row_squares / length + (whole / length).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn the_moments_of_centred_noise_are_those_of_its_matrices() {
        let own: Vec<f64> = (0..12).map(|lag| 0.8_f64.powi(lag)).collect();
        let n = own.len();
        let r = DMatrix::from_fn(n, n, |i, j| own[i.abs_diff(j)]);
        let p = DMatrix::identity(n, n) - DMatrix::from_element(n, n, 1.0 / n as f64);
        let c = &p * r * &p;
        let (trace, squares) = centred(&own);
        assert!((trace - c.trace()).abs() < 1e-12, "{trace}");
        assert!((squares - c.norm_squared()).abs() < 1e-12, "{squares}");
    }

    #[test]
    fn a_board_rests_between_its_turns() {
        let at = |angle: f64| [angle.cos(), angle.sin(), 0.0];
        let angles =
            (0..30).map(|_| 0.0).chain((0..30).map(|i| 0.1 * f64::from(i))).chain((0..40).map(|_| 2.9));
        let list = stretches(&angles.map(at).collect::<Vec<_>>());
        assert_eq!(list.len(), 2, "{list:?}");
        assert!((30..=32).contains(&list[0].end) && (57..=60).contains(&list[1].start), "{list:?}");
    }
}
