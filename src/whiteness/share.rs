//! From differences of the residual and its variance to the number of independent samples.
//!
//! For noise whose correlation falls as ρᵏ with the lag k, averaging removes as much as `n (1−ρ)/(1+ρ)` independent samples
//! would. Noise is seen as two parts, one white and one with a memory: of the differences at two lags the first tells how
//! much of it has a memory and both tell how long that is. Where the second says no more than the first, all of it but the
//! sensor's steps has the memory.
//!
//! The residual sees the noise along the gradient, which turns with the board: what is correlated in the noise appears less so
//! in the residual, by the correlation of the gradients, which the pairs know too. And the fit takes slow noise for
//! parameters, so that the residual holds less of it than there is.

use super::lagged::Differences;
use crate::dense::root;
use crate::math;

/// The most correlation of neighbours that is told from the differences.
const MOST_CORRELATED: f64 = 0.995;
/// Below this correlation of the gradients at the two samples of a pair, the pair says nothing about the noise.
const LEAST_ALIGNED: f64 = 0.4;
/// A memory that the neighbours alone do not explain counts beyond this many standard errors.
const SIGMAS: f64 = 2.5;
/// Steps in which the noise's variance is looked for above the residual's.
const STEP: f64 = 1.1;
const STEPS: usize = 12;
/// Pairs below which nothing is concluded.
const LEAST_PAIRS: u16 = 8;

/// What was seen of the residual of a quadric, in the quadric's own scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observed {
    /// Variance of the residual, corrected for the fitted parameters as if noise were white.
    pub variance: f64,
    /// Of that, the part of the sensor's steps.
    pub quantisation: f64,
    /// Mean square of the gradient, per µT².
    pub gradient2: f64,
    /// Pairs of neighbours.
    pub near: Differences,
    /// Pairs of samples `lag` apart.
    pub far: Option<Differences>,
    /// See `far`.
    pub lag: i32,
    /// Samples of the fit.
    pub samples: f64,
    /// Parameters of the fit.
    pub parameters: f64,
}

impl Observed {
    /// How well the gradients at the two samples of a pair are aligned; `None` where too little to say anything.
    fn aligned(&self, pairs: &Differences) -> Option<f64> {
        // The noise's own share of the gradients' difference, 3σ²/F² of it, is left in.
        let aligned = 1.0 - 0.5 * pairs.gradient2 / self.gradient2;
        (pairs.pairs >= LEAST_PAIRS && aligned >= LEAST_ALIGNED).then_some(aligned)
    }

    /// The variance that as many independent samples would have had, were their mean as uncertain: the sum of the
    /// autocovariances over all lags, for noise of this variance.
    fn long_run(&self, variance: f64) -> Option<f64> {
        let aligned = self.aligned(&self.near)?;
        // Where rounding is in doubt, noise is so low that more of it with a memory does no harm.
        let half = 0.5 * (self.near.mean_square - self.near.rounding).max(0.0);
        let covariance = math::within((variance - half) / aligned, 0.0, variance);
        // Steps are white where noise moves the sample over them: then the differences show them in full.
        let white = self.quantisation * math::within((half / self.quantisation - 0.9) / 0.2, 0.0, 1.0);
        let white = if white.is_finite() { white.min(variance - covariance) } else { 0.0 };
        let rho = (covariance / (variance - white)).min(MOST_CORRELATED);
        let of_neighbours = sum_over_lags(variance, covariance, rho);
        let Some((far, aligned)) = self.far.and_then(|far| Some((far, self.aligned(&far)?))) else {
            return Some(of_neighbours);
        };
        let far_covariance = math::within((variance - 0.5 * far.mean_square) / aligned, 0.0, variance);
        let share = covariance / variance;
        // The variance of a sample correlation, were the noise as the neighbours say (Bartlett).
        let squares = (1.0 + 2.0 * share * share / (1.0 - rho * rho)) / f64::from(far.pairs);
        // Over the variance, so that single precision holds the squares.
        let rounding = (0.5 * far.rounding / variance).min(1e15);
        let error = variance * root(squares + rounding * rounding) / aligned;
        let expected = covariance * power(rho, self.lag - 1);
        if far_covariance - expected <= SIGMAS * error {
            return Some(of_neighbours);
        }
        let covariance = covariance.max(far_covariance);
        let ratio = far_covariance / covariance;
        let rho = nth_root(ratio, self.lag - 1).min(MOST_CORRELATED).max(share);
        Some(sum_over_lags(variance, covariance, rho).max(of_neighbours))
    }
}

/// Variance plus twice all autocovariances, where that of neighbours is `covariance` and each further one `rho` times the
/// last.
fn sum_over_lags(variance: f64, covariance: f64, rho: f64) -> f64 {
    variance + 2.0 * covariance / (1.0 - rho)
}

#[inline(never)]
fn power(base: f64, exponent: i32) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * base)
}

/// The root of a number from 0 to 1, by Newton's steps from above: exponential and logarithm would be 1.6 KB of `libm`.
fn nth_root(number: f64, degree: i32) -> f64 {
    let mut root = 1.0;
    // Each step takes off a share of 1/degree at least until it is near.
    for _ in 0..100 {
        let change = (root - number / power(root, degree - 1)) / f64::from(degree.max(1));
        root -= change;
        if !(change > 1e-15 * root) {
            break;
        }
    }
    root
}

/// Differences of a residual between samples of a fixed lag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pairs {
    /// Their mean square.
    pub mean_square: f64,
    /// How many.
    pub pairs: u32,
}

/// The same share as of a session, of a residual whose differences were added up themselves: of `variance` (corrected for
/// `parameters` as if noise were white), from differences of neighbours and of samples `lag` apart.
pub(crate) fn share_of_pairs(
    variance: f64,
    near: Pairs,
    far: Pairs,
    lag: i32,
    samples: f64,
    parameters: f64,
) -> Option<f64> {
    let differences = |pairs: Pairs| Differences {
        mean_square: pairs.mean_square,
        rounding: 0.0,
        gradient2: 0.0,
        pairs: u16::try_from(pairs.pairs).unwrap_or(u16::MAX),
    };
    let (near, far) = (differences(near), Some(differences(far)));
    effective_share(&Observed {
        variance,
        quantisation: 0.0,
        gradient2: 1.0,
        near,
        far,
        lag,
        samples,
        parameters,
    })
}

/// Independent samples over samples, such that the variance of a fit is the residual's over them. `None` where the pairs say
/// nothing.
pub(super) fn effective_share(seen: &Observed) -> Option<f64> {
    // The residual's variance is the noise's less what the parameters took: V − pL(V)/n, where white noise has L = V.
    let per_sample = seen.parameters / seen.samples;
    let left = seen.variance * (1.0 - per_sample).max(0.0);
    if !(left > 0.0 && left.is_finite()) {
        return None;
    }
    let long_run = noise_long_run(seen, left, per_sample)?;
    let share = seen.variance / long_run;
    share.is_finite().then_some(math::within(share, 1.0 / seen.samples, 1.0))
}

/// `L(V)` where `V − pL(V)/n` is what is left of it in the residual, or, where no noise leaves as much as that, where it
/// leaves the most: then the parameters have taken about half of the noise.
fn noise_long_run(seen: &Observed, left: f64, per_sample: f64) -> Option<f64> {
    let mut variance = seen.variance;
    let mut long_run = seen.long_run(variance)?;
    let mut held = variance - per_sample * long_run;
    for _ in 0..STEPS {
        if held >= left {
            break;
        }
        let next = variance * STEP;
        let next_long_run = seen.long_run(next)?;
        let next_held = next - per_sample * next_long_run;
        if next_held <= held {
            break;
        }
        if next_held > left {
            // Between the two, along the straight line.
            let part = (left - held) / (next_held - held);
            return seen.long_run(variance + part * (next - variance));
        }
        (variance, long_run, held) = (next, next_long_run, next_held);
    }
    Some(long_run)
}

/// The share of independent samples, 0 … 1, for noise of variance `total` whose second differences look like white noise
/// of variance `white`.
pub fn independent_share(white: f64, total: f64) -> f64 {
    if !(total > 0.0 && white >= 0.0) {
        return 1.0;
    }
    // 6 white/total = 6 − 8ρ + 2ρ².
    let rho = math::within(2.0 - math::sqrt(1.0 + 3.0 * white / total), 0.0, 1.0);
    (1.0 - rho) / (1.0 + rho)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What pairs see of noise of variance one whose neighbours have the covariance `covariance`, and each further sample
    /// `rho` times the last, through motion that leaves the gradients `aligned` at neighbours.
    fn seen(covariance: f64, rho: f64, aligned: f64) -> Observed {
        let pairs = |lag: i32| {
            let aligned = power(aligned, lag);
            Differences {
                mean_square: 2.0 * (1.0 - covariance * power(rho, lag - 1) * aligned),
                rounding: 0.0,
                gradient2: 8.0 * (1.0 - aligned),
                pairs: 1000,
            }
        };
        Observed {
            variance: 1.0,
            quantisation: 0.0,
            gradient2: 4.0,
            near: pairs(1),
            far: Some(pairs(7)),
            lag: 7,
            samples: 1e9,
            parameters: 9.0,
        }
    }

    #[test]
    fn the_root_is_that_of_the_logarithm() {
        for degree in [1, 2, 6, 11] {
            for number in [1.0, 0.97, 0.3, 1e-3, 1e-9] {
                let right = math::exp(math::ln(number) / f64::from(degree));
                let got = nth_root(number, degree);
                assert!((got / right - 1.0).abs() < 1e-13, "{number} {degree}: {got} for {right}");
            }
        }
        assert_eq!(nth_root(0.0, 6).max(0.5), 0.5);
    }

    #[test]
    fn first_order_noise_is_recognised_however_the_board_turns() {
        for rho in [0.0, 0.5, 0.9, 0.95] {
            for aligned in [1.0, 0.99, 0.9] {
                let share = effective_share(&seen(rho, rho, aligned)).expect("there are pairs");
                assert!((share * (1.0 + rho) / (1.0 - rho) - 1.0).abs() < 1e-3, "{rho} {aligned}: {share}");
            }
        }
    }

    #[test]
    fn slow_noise_under_white_noise_is_told_from_quick_noise() {
        for (slow, rho) in [(0.5, 0.95), (0.3, 0.98), (0.8, 0.9)] {
            let share = effective_share(&seen(slow * rho, rho, 1.0)).expect("there are pairs");
            let right = 1.0 / (1.0 + 2.0 * slow * rho / (1.0 - rho));
            assert!((share / right - 1.0).abs() < 0.01, "{slow} {rho}: {share} for {right}");
        }
        // A far correlation within its own error is none.
        let mut chance = seen(0.1, 0.1, 1.0);
        chance.far = Some(Differences { mean_square: 2.0 * (1.0 - 0.05), ..chance.near });
        let share = effective_share(&chance).expect("there are pairs");
        assert!((share - 0.9 / 1.1).abs() < 1e-3, "{share}");
    }

    #[test]
    fn a_sensors_steps_are_white_where_noise_moves_it_over_them() {
        let (rho, steps) = (0.9, 0.4);
        let mut through = seen(rho * (1.0 - steps), rho, 1.0);
        (through.quantisation, through.far) = (steps, None);
        let share = effective_share(&through).expect("there are pairs");
        let right = 1.0 / (steps + (1.0 - steps) * (1.0 + rho) / (1.0 - rho));
        assert!((share / right - 1.0).abs() < 0.01, "{share} for {right}");
        // Steps that show only in part are correlated themselves.
        through.near.mean_square = 0.5 * steps;
        let share = effective_share(&through).expect("there are pairs");
        assert!((share - 0.1 / 1.9).abs() < 0.01, "{share}");
    }

    #[test]
    fn what_the_parameters_took_of_the_noise_is_given_back() {
        // Noise of variance one, of which nine parameters leave 1 − 9·19/1000 in the residual.
        let (rho, samples) = (0.9, 1000.0);
        let left = 1.0 - 9.0 * 19.0 / samples;
        let mut few = seen(rho, rho, 1.0);
        (few.samples, few.variance) = (samples, left / (1.0 - 9.0 / samples));
        let share = effective_share(&few).expect("there are pairs");
        // The variance of the mean: that of the residual over its share is the noise's own.
        assert!((few.variance / share / 19.0 - 1.0).abs() < 0.02, "{share}");
        // Noise so slow that no variance explains what is left: as good as no independent samples.
        few.near.mean_square = 2.0 * 0.005;
        let share = effective_share(&few).expect("there are pairs");
        assert!(share * samples < 40.0, "{share}");
    }

    #[test]
    fn jumps_and_too_few_pairs_say_nothing() {
        let mut jumps = seen(0.0, 0.0, 1.0);
        jumps.near.gradient2 = 8.0;
        assert_eq!(effective_share(&jumps), None);
        let mut few = seen(0.5, 0.5, 1.0);
        few.near.pairs = 7;
        assert_eq!(effective_share(&few), None);
        let nothing = Observed { variance: f64::NAN, ..seen(0.5, 0.5, 1.0) };
        assert_eq!(effective_share(&nothing), None);
        let more = Differences { mean_square: 3.0, ..seen(0.0, 0.0, 1.0).near };
        assert_eq!(effective_share(&Observed { near: more, ..seen(0.0, 0.0, 1.0) }), Some(1.0));
    }

    #[test]
    fn first_order_noise_is_recognised_in_second_differences() {
        for rho in [0.0f64, 0.5, 0.9] {
            let white = 1.0 - 4.0 / 3.0 * rho + rho * rho / 3.0;
            let share = independent_share(white, 1.0);
            assert!((share - (1.0 - rho) / (1.0 + rho)).abs() < 1e-12, "{rho}: {share}");
        }
        // Jumps from attitude to attitude are no sign of correlation.
        assert_eq!(independent_share(50.0, 1.0), 1.0);
        assert_eq!(independent_share(f64::NAN, 1.0), 1.0);
    }
}
