//! Two magnetometers in one log: what both read, and what one of them reads alone.
//!
//! After each is calibrated, the magnitudes deviate by `r₁ = c + o₁ + n₁` and `r₂ = c + o₂ + n₂`: a common field `c`, a cause `o` of its own at each
//! sensor, and noise. The covariance of the deviations is the variance of `c`. What a variance has beyond that and beyond noise is the sensor's
//! own. A magnitude knows no axes, so that the sensors may be mounted differently.

use crate::bounds::{PAIR_RATIO, PAIR_SHARE, PAIR_SIGMAS};
use serde::Serialize;

/// Blocks of time whose differences show the errors.
const BLOCKS: usize = 24;

/// Which of the two sensors is disturbed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Disturbed {
    /// The one that was fitted.
    This,
    /// The other one.
    Other,
}

/// A part of the deviations, rms, µT.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Part {
    /// Its size; zero where noise explains all.
    pub rms_ut: f64,
    /// Whether it is significant and matters.
    pub significant: bool,
}

/// What two magnetometers show together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pair {
    /// Rows in which both are known.
    pub rows: usize,
    /// Deviation of the corrected magnitude of each sensor, rms, µT: this one, the other.
    pub rms_ut: [f64; 2],
    /// What both have.
    pub common: Part,
    /// What each has alone, beyond noise.
    pub own: [Part; 2],
    /// The sensor whose own part stands out.
    pub disturbed: Option<Disturbed>,
}

/// Sums of one block of time.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    /// Of the first, of the second, of both.
    products: [f64; 3],
    pairs: f64,
    /// Squares of the steps from one row to the next.
    steps: [f64; 2],
}

impl Sums {
    fn minus(&self, other: &Sums) -> Sums {
        Sums {
            count: self.count - other.count,
            products: std::array::from_fn(|i| self.products[i] - other.products[i]),
            pairs: self.pairs - other.pairs,
            steps: std::array::from_fn(|i| self.steps[i] - other.steps[i]),
        }
    }

    fn plus(&self, other: &Sums) -> Sums {
        self.minus(&Sums::default().minus(other))
    }

    /// Variances: common, own of each, and the difference of the own ones.
    fn parts(&self) -> [f64; 4] {
        let [one, other, both] = self.products.map(|sum| sum / self.count);
        let noise = self.steps.map(|sum| 0.5 * sum / self.pairs);
        let own = [one - both - noise[0], other - both - noise[1]];
        [both, own[0], own[1], own[0] - own[1]]
    }
}

/// Compares the deviations of the corrected magnitudes of two sensors in the same rows, each without its mean, µT.
pub fn pair(first: &[f64], second: &[f64], field_ut: f64) -> Pair {
    let long = first.len().div_ceil(BLOCKS).max(1);
    let blocks: Vec<Sums> =
        (first.chunks(long).zip(second.chunks(long))).map(|(one, two)| sums(one, two)).collect();
    let all = blocks.iter().fold(Sums::default(), |sum, block| sum.plus(block));
    let parts = all.parts();
    // Jackknife over the blocks: the deviations have a memory.
    let without: Vec<[f64; 4]> = blocks.iter().map(|block| all.minus(block).parts()).collect();
    let n = without.len() as f64;
    let error = |place: usize| {
        let mean = without.iter().map(|parts| parts[place]).sum::<f64>() / n;
        ((n - 1.0) / n * without.iter().map(|parts| (parts[place] - mean).powi(2)).sum::<f64>()).sqrt()
    };
    let least_ut2 = (PAIR_SHARE * field_ut).powi(2);
    let part = |place: usize| Part {
        rms_ut: parts[place].max(0.0).sqrt(),
        significant: parts[place] > PAIR_SIGMAS * error(place) && parts[place] > least_ut2,
    };
    let [common, this, that] = [part(0), part(1), part(2)];
    let stands_out = parts[3].abs() > PAIR_SIGMAS * error(3);
    let of_both_ut = if common.significant { common.rms_ut } else { 0.0 };
    let outweighs = |own: Part, other: Part| own.rms_ut > of_both_ut.max(PAIR_RATIO * other.rms_ut);
    let disturbed = match () {
        () if stands_out && this.significant && outweighs(this, that) => Some(Disturbed::This),
        () if stands_out && that.significant && outweighs(that, this) => Some(Disturbed::Other),
        () => None,
    };
    let rms_ut = [0, 1].map(|place: usize| (all.products[place] / all.count).sqrt());
    Pair { rows: first.len(), rms_ut, common, own: [this, that], disturbed }
}

fn sums(one: &[f64], two: &[f64]) -> Sums {
    let mut sums = Sums::default();
    for (a, b) in one.iter().zip(two) {
        sums.count += 1.0;
        sums.products = std::array::from_fn(|i| sums.products[i] + [a * a, b * b, a * b][i]);
    }
    for (place, series) in [one, two].into_iter().enumerate() {
        sums.steps[place] = series.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    }
    sums.pairs = one.len().saturating_sub(1) as f64;
    sums
}
