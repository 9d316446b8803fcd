//! Whether the three axes of a sensor are off together: noise of its own has each axis for itself, while a current, a magnet that
//! moves or a field moves the reading along one direction, and that is seldom an axis.

use crate::noise::colour::{Colour, seen_through};
use crate::noise::power::{Band, bands, padded, symmetric, transforms};
use crate::noise::turning::Turning;
use nalgebra::{Matrix3, Vector3};

/// What has a memory stands out of what is quick in a band that holds so many times its power.
const STANDS_OUT: f64 = 3.0;
/// A direction in which the field hardly ever lay shows nothing of the error along it: at least this share of the mean counts.
const LEAST_SEEN: f64 = 0.02;
/// Where the axes have their noise apart the statistic is that of a chi-square with three degrees of freedom: of 320 simulated
/// logs with nothing hidden, of every colour, the largest was 17.
const TOGETHER: f64 = 25.0;
/// The six different products of two axes.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

fn symmetric_of(six: [f64; 6]) -> Matrix3<f64> {
    let [xx, xy, xz, yy, yz, zz] = six;
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Whether what has a memory in a magnitude's residual moves the axes together. `rounding` is the share of the variance that is
/// the readings' rounding, `colour` what the residual is most like.
pub fn together(residuals: &[f64], turning: &Turning, colour: Colour, rounding: f64) -> bool {
    statistic(residuals, turning, colour, rounding) > TOGETHER
}

/// The power that `w r` has by bin, in products of two axes, where the error `e` has this colour and each axis for itself: with
/// `r = wᵀe` its covariance is that of the noise times `⟨w wᵀ w' w'ᵀ⟩`, weights that long apart.
fn expected(weights: &[[f64; 3]], colour: Colour, rounding: f64, size: usize) -> [Vec<f64>; 6] {
    let n = weights.len();
    let twice = (2 * n).next_power_of_two();
    let products = PAIRS.map(|(i, j)| weights.iter().map(|w| w[i] * w[j]).collect::<Vec<f64>>());
    let seen = transforms(&products, twice);
    let own = colour.correlation(size);
    let pair = |i: usize, j: usize| PAIRS.iter().position(|pair| *pair == (i.min(j), i.max(j))).unwrap_or(0);
    PAIRS.map(|(i, j)| {
        let both = |bin: usize, k: usize| {
            let (a, b) = (seen[pair(i, k)][bin], seen[pair(j, k)][bin]);
            a.0 * b.0 + a.1 * b.1
        };
        let power: Vec<f64> = (0..=twice / 2).map(|bin| (0..3).map(|k| both(bin, k)).sum()).collect();
        let alike = symmetric(&power, twice);
        seen_through(&own, &alike[..n], rounding, size)
    })
}

/// Minus twice the logarithm of the likelihood ratio of "each axis for itself" (Bartlett's test of independence) over the
/// frequencies where the error stands out.
fn statistic(residuals: &[f64], turning: &Turning, colour: Colour, rounding: f64) -> f64 {
    let n = residuals.len();
    let weights = &turning.weights;
    if weights.len() != n || n == 0 {
        return 0.0;
    }
    let size = padded(n);
    let axis = |i: usize| weights.iter().zip(residuals).map(|(w, r)| w[i] * r).collect::<Vec<f64>>();
    let seen = transforms(&[axis(0), axis(1), axis(2)], size);
    let at = |bin: usize, (i, j): (usize, usize)| {
        seen[i][bin].0 * seen[j][bin].0 + seen[i][bin].1 * seen[j][bin].1
    };
    let power: Vec<f64> = (0..=size / 2).map(|bin| (0..3).map(|i| at(bin, (i, i))).sum()).collect();
    let quick = &power[size / 4..size / 2];
    let quick = quick.iter().sum::<f64>() / quick.len() as f64;
    let level = |band: &Band| band.seen / band.bins.len() as f64;
    let standing = bands(&power[..size / 4], n, size).into_iter();
    let standing: Vec<Band> = standing.take_while(|band| level(band) >= STANDS_OUT * quick).collect();
    if standing.is_empty() {
        return 0.0;
    }
    let expected = expected(weights, colour, rounding, size);
    if !power.iter().chain(expected.iter().flatten()).all(|value| value.is_finite()) {
        return 0.0;
    }
    let (mut sum, mut count) = (Matrix3::zeros(), 0.0);
    for band in standing {
        let above = 1.0 - quick / level(&band);
        let found = symmetric_of(PAIRS.map(|pair| band.bins.clone().map(|bin| at(bin, pair)).sum::<f64>()));
        let chance =
            symmetric_of(std::array::from_fn(|k| expected[k][band.bins.clone()].iter().sum::<f64>()));
        let eigen = chance.symmetric_eigen();
        let least = LEAST_SEEN * eigen.eigenvalues.mean();
        let scale = eigen.eigenvalues.map(|value| value.max(least).max(f64::MIN_POSITIVE).sqrt().recip());
        let back = eigen.eigenvectors * Matrix3::from_diagonal(&scale) * eigen.eigenvectors.transpose();
        let of_band = back * found * back;
        if of_band.trace() <= 0.0 {
            continue;
        }
        sum += of_band * (above * band.count / of_band.trace());
        count += band.count;
    }
    let own = Vector3::from_fn(|i, _| sum[(i, i)]);
    if own.min() <= 0.0 {
        return 0.0;
    }
    let correlation = Matrix3::from_fn(|i, j| sum[(i, j)] / (own[i] * own[j]).sqrt());
    -2.0 * count * correlation.determinant().max(1e-300).ln()
}
