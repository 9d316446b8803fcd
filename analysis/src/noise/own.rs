//! Whether what a model leaves is the sensor's own noise, and which.
//!
//! Two noise models compete for the same residual. A sensor's own noise is white, or white through a short filter, with 1/f noise beside
//! it that each axis has for itself. Anything else is stood for by the general one of [`Noise`]: two Ornstein–Uhlenbeck vectors of any
//! size and time constant, and a free autoregressive memory. The general one contains the sensor's: it wins only by its likelihood,
//! less the price of its parameters.

use crate::bounds::{
    FILTER_S, FILTER_SAMPLES, FLICKER_EXPONENTS, FORGOTTEN, LINE, MAX_NOISE_SAMPLES, MIN_ODDS, MOST_FRESH,
};
use crate::noise::cause::single_cause;
use crate::noise::model::{Kalman, Noise, Track, Wander};
use crate::samples::fft;
use serde::Serialize;

/// Time constants of the vectors that 1/f noise is made of, in equal ratios from a sample to the log.
const PARTS: usize = 5;
/// Sizes of 1/f noise per axis and time constant over that of white noise, at first.
const SIZES: [f64; 7] = [0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2];
/// Factors by which the size is then brought near.
const NEARER: [f64; 3] = [1.5, 1.2, 1.1];
/// Shares of white noise behind a filter that are tried.
const WHITE_AFTER: [f64; 7] = [0.0, 0.01, 0.04, 0.1, 0.2, 0.35, 0.5];
/// Samples that a predictor looks back.
const LOOKS_BACK: usize = 32;
/// Rows of a sample, at most: the axes of a board at rest.
const MAX_ROWS: usize = 3;

/// A colour of noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colour {
    /// Every sample its own.
    White,
    /// First order, with this correlation from one sample to the next; negative where neighbours differ more than white noise does.
    Ar1(f64),
    /// A rolling mean, and a share of white noise.
    RollingMean {
        /// Over so many samples.
        of: usize,
        /// Share of the variance that is white.
        white: f64,
    },
    /// 1/f: power in proportion to the frequency to the power of minus `exponent`, and a share of white noise.
    Flicker {
        /// The exponent.
        exponent: f64,
        /// Share of the variance that is white.
        white: f64,
    },
}

impl Colour {
    /// In words.
    pub fn words(self) -> String {
        let white = |white: f64| match white > 0.005 {
            true => format!(" with {:.0} % of white noise", 100.0 * white),
            false => String::new(),
        };
        match self {
            Colour::White => "white".into(),
            Colour::Ar1(rho) => format!("correlated noise (correlation {rho:.2} from sample to sample)"),
            Colour::RollingMean { of, white: share } => {
                format!("a moving average over {of} samples{}", white(share))
            }
            Colour::Flicker { exponent, white: share } => {
                format!("1/f noise (exponent {exponent:.1}){}", white(share))
            }
        }
    }

    /// A word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Colour::White => "white",
            Colour::Ar1(_) => "fading",
            Colour::RollingMean { .. } => "rolling-mean",
            Colour::Flicker { .. } => "flicker",
        }
    }
}

/// A short memory that a filter gives to white noise, as a residual shows it.
#[derive(Debug, Clone, Copy)]
struct Memory {
    /// What the filter makes.
    colour: Colour,
    /// Share of the variance that is white behind it: rounding, the noise of what comes after the filter.
    white: f64,
}

impl Memory {
    fn ar1(rho: f64, white: f64) -> Memory {
        Memory { colour: Colour::Ar1(rho), white }
    }

    fn mean(of: usize, white: f64) -> Memory {
        Memory { colour: Colour::RollingMean { of, white }, white }
    }

    fn correlation(self, lag: usize) -> f64 {
        match self.colour {
            _ if lag == 0 => 1.0,
            Colour::Ar1(rho) => (1.0 - self.white) * rho.powi(lag as i32),
            Colour::RollingMean { of, .. } => (1.0 - self.white) * (1.0 - lag as f64 / of as f64).max(0.0),
            Colour::White | Colour::Flicker { .. } => 0.0,
        }
    }

    /// Samples after which it is forgotten.
    fn samples(self) -> f64 {
        match self.colour {
            Colour::Ar1(rho) => FORGOTTEN.ln() / rho.abs().max(1e-9).ln(),
            Colour::RollingMean { of, .. } => of as f64,
            Colour::White | Colour::Flicker { .. } => 0.0,
        }
    }

    /// Numbers it was chosen by.
    fn parameters(self) -> f64 {
        let own = f64::from(u8::from(self.colour != Colour::White));
        own + f64::from(u8::from(self.white > 0.0))
    }
}

/// A residual, and how it is seen.
struct Seen<'s> {
    series: &'s [f64],
    /// How alike the directions are so many samples apart: what a vector remembers, its projection forgets as the board turns.
    alike: &'s [f64],
    /// Rows of each sample.
    rows: usize,
    /// The longest memory of a filter, samples.
    longest: f64,
}

/// Mean products of the directions at the lags of a predictor, over that at none.
fn alike(directions: &[[f64; 3]], rows: usize) -> Vec<f64> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let at = |lag: usize| {
        let pairs = directions.iter().zip(&directions[lag.min(directions.len())..]);
        let n = directions.len().saturating_sub(lag).max(1) as f64;
        pairs.map(|(a, b)| dot(a, b)).sum::<f64>() / n
    };
    let none = at(0).max(f64::MIN_POSITIVE);
    (0..=LOOKS_BACK * rows).map(|lag| at(lag) / none).collect()
}

impl Seen<'_> {
    /// −2 log likelihood, without constants, of white noise of any size.
    fn white(series: &[f64]) -> f64 {
        let n = series.len() as f64;
        n * (series.iter().map(|v| v * v).sum::<f64>() / n).max(1e-300).ln()
    }

    /// The same with this memory, its price with it.
    fn cost(&self, memory: Memory) -> f64 {
        let (innovations, log_det, fresh) = self.innovations(memory);
        if memory.samples() > FILTER_SAMPLES && fresh > MOST_FRESH {
            return f64::INFINITY;
        }
        Self::white(&innovations) + log_det + (self.series.len() as f64).ln() * memory.parameters()
    }

    /// What the samples before each sample do not predict under this memory, of one size, the logarithm of the determinant, and the share of
    /// the variance that each sample adds.
    fn innovations(&self, memory: Memory) -> (Vec<f64>, f64, f64) {
        let series = self.series;
        // Rows of one sample see different axes, which are not alike.
        let back = LOOKS_BACK * self.rows;
        let correlation = |lag: usize| memory.correlation(lag / self.rows) * self.alike[lag];
        let r: Vec<f64> = (0..=back).map(correlation).collect();
        // Levinson and Durbin: the predictor of each order, and the variance that it leaves.
        let (mut a, mut variance) = ([0.0; LOOKS_BACK * MAX_ROWS + 1], 1.0_f64);
        let mut log_det = 0.0;
        let mut innovations = Vec::with_capacity(series.len());
        for (k, value) in series.iter().enumerate() {
            let order = k.min(back);
            let predicted: f64 = (1..=order).map(|lag| a[lag] * series[k - lag]).sum();
            innovations.push((value - predicted) / variance.sqrt());
            log_det += variance.ln();
            if k < back {
                let known: f64 = (1..=order).map(|lag| a[lag] * r[order + 1 - lag]).sum();
                let reflection = (r[order + 1] - known) / variance;
                let before = a;
                for lag in 1..=order {
                    a[lag] = before[lag] - reflection * before[order + 1 - lag];
                }
                a[order + 1] = reflection;
                variance *= (1.0 - reflection * reflection).max(1e-9);
            }
        }
        (innovations, log_det, variance)
    }

    /// The likeliest memory of a filter, and its cost.
    fn likeliest(&self) -> (Memory, f64) {
        let mut best = (Memory { colour: Colour::White, white: 0.0 }, Self::white(self.series));
        let mut try_it = |memory: Memory| {
            let cost = self.cost(memory);
            if cost < best.1 {
                best = (memory, cost);
            }
            cost
        };
        let most = FORGOTTEN.powf(1.0 / self.longest);
        // Each family by its own parameter, and then by its share of white noise.
        let mut rho = (f64::INFINITY, 0.0);
        for step in -8..=14 {
            let next = most * f64::from(step) / 14.0;
            let cost = try_it(Memory::ar1(next, 0.0));
            rho = if cost < rho.0 { (cost, next) } else { rho };
        }
        for by in [0.02, 0.01, 0.005] {
            for next in [rho.1 - by, rho.1 + by] {
                let next = next.clamp(-most, most);
                let cost = try_it(Memory::ar1(next, 0.0));
                rho = if cost < rho.0 { (cost, next) } else { rho };
            }
        }
        let lengths = std::iter::successors(Some(2), |of| Some(of + 1 + of / 16));
        let lengths = lengths.take_while(|of| *of as f64 <= self.longest);
        let mut means: Vec<(f64, usize)> = lengths.map(|of| (try_it(Memory::mean(of, 0.02)), of)).collect();
        means.sort_by(|a, b| a.0.total_cmp(&b.0));
        for white in WHITE_AFTER {
            for higher in 0..=6 {
                try_it(Memory::ar1(rho.1 + f64::from(higher) / 6.0 * (most - rho.1), white));
            }
            for (_, of) in means.iter().take(3) {
                try_it(Memory::mean(*of, white));
            }
        }
        best
    }
}

/// 1/f noise in each axis: Ornstein–Uhlenbeck vectors with time constants in equal ratios.
struct Flicker {
    tau_s: [f64; PARTS],
    size: [f64; PARTS],
}

impl Flicker {
    fn new(track: &Track, size: f64, exponent: f64) -> Flicker {
        let n = track.time_s.len();
        let length = track.time_s[n - 1] - track.time_s[0];
        let from = (length / (n - 1) as f64).max(1e-9);
        let ratio = (0.3 * length / from).max(2.0);
        let tau_s: [f64; PARTS] =
            core::array::from_fn(|part| from * ratio.powf(part as f64 / (PARTS - 1) as f64));
        Flicker { tau_s, size: tau_s.map(|tau| size * (tau / from).powf(0.5 * (exponent - 1.0))) }
    }

    /// Innovations of a residual beside white noise of unit size, and the logarithm of the determinant.
    fn innovations(&self, track: &Track, series: &[f64]) -> (f64, Vec<f64>) {
        let mut kalman = Kalman::<{ 3 * PARTS }>::new(|i| self.size[i / 3]);
        let mut last = track.time_s[0];
        let (mut step, mut phi) = (f64::NAN, [1.0; PARTS]);
        let mut log_det = 0.0;
        let mut innovations = Vec::with_capacity(series.len());
        for ((value, time_s), q) in series.iter().zip(&track.time_s).zip(&track.direction) {
            let dt = (time_s - last).max(0.0);
            last = *time_s;
            if dt != step {
                step = dt;
                phi = self.tau_s.map(|tau| (-dt / tau).exp());
            }
            let decay = core::array::from_fn(|i| phi[i / 3]);
            let seen = core::array::from_fn(|i| q[i % 3]);
            let (innovation, variance, _) = kalman.step(&decay, &seen, 1.0, *value);
            log_det += variance.ln();
            innovations.push(innovation / variance.sqrt());
        }
        (log_det, innovations)
    }

    /// The share of white noise in its residual.
    fn white(&self, track: &Track) -> f64 {
        let gain =
            track.direction.iter().flatten().map(|q| q * q).sum::<f64>() / track.direction.len() as f64;
        1.0 / (1.0 + gain * self.size.iter().map(|size| size * size).sum::<f64>())
    }
}

/// The likeliest noise of a sensor, its −2 log likelihood with the price of its parameters, and the innovations under it.
fn likeliest(track: &Track, series: &[f64], rows: usize, longest: f64) -> (Colour, f64, Vec<f64>) {
    let alike = alike(&track.direction, rows);
    let filtered = Seen { series, alike: &alike, rows, longest };
    let (memory, least) = filtered.likeliest();
    let mut beside = (f64::INFINITY, 0.0, 1.0);
    let try_size = |size: f64, exponent: f64, beside: &mut (f64, f64, f64)| {
        let (log_det, innovations) = Flicker::new(track, size, exponent).innovations(track, series);
        let cost = Seen::white(&innovations) + log_det;
        if cost < beside.0 {
            *beside = (cost, size, exponent);
        }
    };
    for size in SIZES {
        try_size(size, 1.0, &mut beside);
    }
    for factor in NEARER {
        for exponent in FLICKER_EXPONENTS {
            let size = beside.1;
            for size in [size / factor, size * factor] {
                try_size(size, exponent, &mut beside);
            }
        }
    }
    let (_, size, exponent) = beside;
    let flicker = Flicker::new(track, size, exponent);
    let (log_det, innovations) = flicker.innovations(track, series);
    let rest = Seen { series: &innovations, alike: &alike, rows, longest };
    let (behind, cost) = rest.likeliest();
    let cost = cost + log_det + 2.0 * (series.len() as f64).ln();
    if cost < least {
        (Colour::Flicker { exponent, white: flicker.white(track) }, cost, rest.innovations(behind).0)
    } else {
        (memory.colour, least, filtered.innovations(memory).0)
    }
}

/// Twice the log of the odds that a line stands in a spectrum that is white otherwise, its frequency, size and phase paid for, and its
/// share of the variance: of white noise the largest of all ordinates is seldom more than the logarithm of their number.
fn line(innovations: &[f64]) -> (f64, f64) {
    let n = innovations.len() as f64;
    let mut data: Vec<(f64, f64)> = innovations.iter().map(|v| (*v, 0.0)).collect();
    fft::forward(&mut data);
    let powers = data[1..=data.len() / 2].iter().map(|(re, im)| re * re + im * im);
    let share = 2.0 * powers.fold(0.0, f64::max) / (n * innovations.iter().map(|v| v * v).sum::<f64>());
    (-n * (1.0 - share.min(1.0 - 1e-9)).ln() - 3.0 * n.ln(), share)
}

/// Whether the general noise has no memory beyond that of a filter of so many samples, and no line in its spectrum: a smoothing or a
/// differentiating filter has its highest gain at one end.
fn is_filtered(wander: &Wander, ar: &[f64], rows: usize, longest: f64, step: f64) -> bool {
    let longest_tau = longest * step / FORGOTTEN.recip().ln();
    let is_short = (0..2).all(|part| wander.size[part] == 0.0 || wander.tau_s[part] <= longest_tau);
    let longest = rows * longest as usize;
    let response = response(ar, 8 * longest);
    let energy = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
    let beyond = energy(&response[longest..]);
    let gain = |turns: f64| {
        let sum = |wave: fn(f64) -> f64| {
            ar.iter().enumerate().map(|(lag, a)| a * wave(turns * lag as f64)).sum::<f64>()
        };
        (sum(f64::cos).powi(2) + sum(f64::sin).powi(2)).recip()
    };
    let ends = gain(0.0).max(gain(std::f64::consts::PI));
    let most = (0..=128).map(|k| gain(std::f64::consts::PI * f64::from(k) / 128.0)).fold(0.0, f64::max);
    is_short && beyond <= FORGOTTEN.powi(2) * energy(&response) && most <= LINE * ends
}

/// Impulse response of an autoregressive filter.
fn response(ar: &[f64], length: usize) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::with_capacity(length);
    for k in 0..length {
        let past = (1..ar.len().min(k + 1)).map(|lag| ar[lag] * out[k - lag]).sum::<f64>();
        out.push(f64::from(u8::from(k == 0)) - past);
    }
    out
}

/// What a residual is most like, and the odds against it.
#[derive(Debug, Clone, Copy)]
pub struct OwnNoise {
    /// The likeliest noise of a sensor.
    pub colour: Colour,
    /// Twice the log of the odds that it is something else.
    pub odds: f64,
    /// Variance of what each sample adds, by the likelier of the two, over that of the residual.
    pub fresh: f64,
}

impl OwnNoise {
    /// Of a residual that is seen along these directions of the sensor's axes, `rows` of them in each sample, a sample each `step_s` (0 where
    /// unknown).
    pub fn of(residual: &[f64], directions: &[[f64; 3]], rows: usize, step_s: f64) -> OwnNoise {
        let near = Self::of_series(residual, directions, rows, step_s);
        if residual.len() <= MAX_NOISE_SAMPLES {
            return near;
        }
        // What is slow shows in means over the whole log, as large as if white noise were as before.
        let size = residual.len().div_ceil(MAX_NOISE_SAMPLES);
        let root = (size as f64).sqrt();
        let (mut means, mut seen) = (Vec::new(), Vec::new());
        for (values, axes) in residual.chunks_exact(rows * size).zip(directions.chunks_exact(rows * size)) {
            for row in 0..rows {
                let mean = |sum: f64| sum / size as f64;
                means.push(root * mean(values.iter().skip(row).step_by(rows).sum()));
                let axis = |i: usize| mean(axes.iter().skip(row).step_by(rows).map(|q| q[i]).sum());
                seen.push([0, 1, 2].map(axis));
            }
        }
        let far = Self::of_series(&means, &seen, rows, size as f64 * step_s);
        OwnNoise { odds: near.odds.max(far.odds), ..near }
    }

    /// The same of the middle of a series.
    fn of_series(residual: &[f64], directions: &[[f64; 3]], rows: usize, step_s: f64) -> OwnNoise {
        let step = if step_s > 0.0 { step_s } else { 1.0 };
        let samples = residual.len().min(MAX_NOISE_SAMPLES) / rows;
        let (n, begin) = (rows * samples, (residual.len() / rows - samples) / 2 * rows);
        let series = &residual[begin..begin + n];
        let track = Track {
            time_s: (0..n).map(|row| step * (row / rows) as f64).collect(),
            direction: directions[begin..begin + n].to_vec(),
            weight: vec![1.0; n],
            ..Track::default()
        };
        let whole = series.iter().map(|v| v * v).sum::<f64>() / n.max(1) as f64;
        if n < 2 * LOOKS_BACK || !(whole > 0.0 && whole.is_finite()) {
            return OwnNoise { colour: Colour::White, odds: 0.0, fresh: 1.0 };
        }
        let general = Noise::fit(&track, series, None, f64::INFINITY);
        let cost = general.cost + general.wander.price(n);
        let is_white = Seen::white(series) < cost + MIN_ODDS;
        let by_time = if step_s > 0.0 { FILTER_S / step_s } else { 0.0 };
        // A memory of an eighth of a series is not told from a wander.
        let longest = by_time.clamp(FILTER_SAMPLES, (samples as f64 / 8.0).max(FILTER_SAMPLES));
        let (colour, own, innovations) = match is_white {
            true => (Colour::White, cost, series.to_vec()),
            false => likeliest(&track, series, rows, longest),
        };
        // A filter may be another one than those that have a name.
        let fresh = (general.variance / whole).min(1.0);
        // Something slow beside white noise is no filter's.
        let most = if fresh > MOST_FRESH { FILTER_SAMPLES } else { longest };
        let own =
            if is_filtered(&general.wander, &general.ar, rows, most, step) { own.min(cost) } else { own };
        // A line stands out whichever of the two whitens the series.
        let mut whitened = series.to_vec();
        general.whiten(&track, 1, &mut whitened);
        let (of_line, share) = line(&innovations);
        let of_line = of_line.min(line(&whitened).0);
        let mut odds = (own - cost).max(of_line);
        if colour != Colour::White && odds < MIN_ODDS {
            // A cause has one history; a sensor's axes have one each.
            let cause = single_cause(&track, series, &general);
            odds = odds.max(cause.map_or(f64::NEG_INFINITY, |cause| own - cause.cost));
        }
        if is_white {
            return OwnNoise { colour, odds, fresh: 1.0 - if of_line > MIN_ODDS { share } else { 0.0 } };
        }
        OwnNoise { colour, odds, fresh }
    }

    /// Whether it is a sensor's own noise and nothing more.
    pub fn is_noise(&self) -> bool {
        self.odds < MIN_ODDS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    const N: usize = 3000;

    fn fresh(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
    }

    /// Noise of one axis, of unit variance.
    fn noise(colour: Colour, rng: &mut ChaCha8Rng) -> Vec<f64> {
        match colour {
            Colour::White => (0..N).map(|_| fresh(rng)).collect(),
            Colour::Ar1(rho) => {
                let mut now = fresh(rng);
                (0..N)
                    .map(|_| {
                        now = rho * now + (1.0 - rho * rho).sqrt() * fresh(rng);
                        now
                    })
                    .collect()
            }
            Colour::RollingMean { of, white } => {
                let all: Vec<f64> = (0..N + of).map(|_| fresh(rng)).collect();
                let mean = |at: usize| all[at..at + of].iter().sum::<f64>() / (of as f64).sqrt();
                (0..N).map(|at| (1.0 - white).sqrt() * mean(at) + white.sqrt() * fresh(rng)).collect()
            }
            Colour::Flicker { .. } => {
                // Octave by octave, each as strong as the others.
                let fades: Vec<f64> = (0..12).map(|k| (-2.0 * 0.5_f64.powi(k)).exp()).collect();
                let mut now: Vec<f64> = fades.iter().map(|_| fresh(rng)).collect();
                (0..N)
                    .map(|_| {
                        for (value, fade) in now.iter_mut().zip(&fades) {
                            *value = fade * *value + (1.0 - fade * fade).sqrt() * fresh(rng);
                        }
                        now.iter().sum::<f64>() / (fades.len() as f64).sqrt()
                    })
                    .collect()
            }
        }
    }

    fn directions() -> Vec<[f64; 3]> {
        let at = |k: usize| {
            let (a, b) = (k as f64 * 0.011, k as f64 * 0.0173);
            [a.cos() * b.sin(), a.sin() * b.sin(), b.cos()]
        };
        (0..N).map(at).collect()
    }

    /// What is told of the residual that a turning board makes of its axes' noise, with an error beside it.
    fn detected(colour: Colour, seed: u64, error: impl Fn(usize, &[f64; 3]) -> f64) -> OwnNoise {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let axes = [noise(colour, &mut rng), noise(colour, &mut rng), noise(colour, &mut rng)];
        let directions = directions();
        let seen = |(k, q): (usize, &[f64; 3])| (0..3).map(|i| axes[i][k] * q[i]).sum::<f64>() + error(k, q);
        let residual: Vec<f64> = directions.iter().enumerate().map(seen).collect();
        OwnNoise::of(&residual, &directions, 1, 0.05)
    }

    #[test]
    fn each_colour_is_told() {
        let flicker = Colour::Flicker { exponent: 1.0, white: 0.0 };
        for seed in 0..4 {
            for colour in [
                Colour::White,
                Colour::Ar1(0.4),
                Colour::Ar1(0.85),
                Colour::RollingMean { of: 5, white: 0.0 },
                Colour::RollingMean { of: 8, white: 0.1 },
                flicker,
            ] {
                let found = detected(colour, seed, |_, _| 0.0);
                let near = match (colour, found.colour) {
                    (Colour::White, Colour::White) => true,
                    (Colour::Ar1(a), Colour::Ar1(b)) => (a - b).abs() < 0.05,
                    (Colour::RollingMean { of: a, .. }, Colour::RollingMean { of: b, .. }) => a == b,
                    (Colour::Flicker { .. }, Colour::Flicker { exponent, white }) => {
                        (exponent - 1.0).abs() < 0.21 && white < 0.3
                    }
                    _ => false,
                };
                assert!(near && found.is_noise(), "seed {seed}: {colour:?} is taken for {found:?}");
            }
        }
    }

    #[test]
    fn what_moves_beside_noise_is_no_noise() {
        for seed in 0..4 {
            for period in [3.3, 8.0, 60.0, 400.0] {
                let wave = |k: usize, _: &[f64; 3]| 1.5 * (std::f64::consts::TAU * k as f64 / period).sin();
                let found = detected(Colour::White, seed, wave);
                assert!(!found.is_noise(), "seed {seed}, period {period}: {found:?}");
            }
            let switched =
                |k: usize, q: &[f64; 3]| if (k / 300).is_multiple_of(2) { 1.5 * q[0] } else { -1.5 * q[0] };
            let found = detected(Colour::Ar1(0.5), seed, switched);
            assert!(!found.is_noise(), "seed {seed}: {found:?}");
        }
    }

    #[test]
    fn a_memory_of_seconds_is_none_of_a_sensor() {
        for seed in 0..4 {
            let found = detected(Colour::Ar1(0.99), seed, |_, _| 0.0);
            assert!(!found.is_noise(), "seed {seed}: {found:?}");
            let found = detected(Colour::RollingMean { of: 60, white: 0.02 }, seed, |_, _| 0.0);
            assert!(!found.is_noise(), "seed {seed}: {found:?}");
        }
    }

    #[test]
    fn a_cause_with_the_spectrum_of_noise_has_one_history() {
        for seed in 0..4 {
            let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
            let history = noise(Colour::Flicker { exponent: 1.0, white: 0.0 }, &mut rng);
            let v = [0.8, 0.5, -0.33];
            let along = |k: usize, q: &[f64; 3]| 3.0 * history[k] * (0..3).map(|i| v[i] * q[i]).sum::<f64>();
            let found = detected(Colour::White, seed, along);
            assert!(!found.is_noise(), "seed {seed}: {found:?}");
        }
    }

    #[test]
    fn a_board_at_rest_shows_each_axis_for_itself() {
        let unit = |row: usize| [0, 1, 2].map(|i| f64::from(u8::from(row % 3 == i)));
        let directions: Vec<[f64; 3]> = (0..3 * N).map(unit).collect();
        for seed in 0..4 {
            let mut rng = ChaCha8Rng::seed_from_u64(200 + seed);
            let axes = [(); 3].map(|()| noise(Colour::Ar1(0.7), &mut rng));
            let history = noise(Colour::Ar1(0.95), &mut rng);
            let along = [0.8, 0.5, -0.33];
            let rows = |cause: f64| -> Vec<f64> {
                (0..3 * N)
                    .map(|row| axes[row % 3][row / 3] + cause * along[row % 3] * history[row / 3])
                    .collect()
            };
            let own = OwnNoise::of(&rows(0.0), &directions, 3, 0.05);
            let is_near = matches!(own.colour, Colour::Ar1(rho) if (rho - 0.7).abs() < 0.05);
            assert!(is_near && own.is_noise(), "seed {seed}: {own:?}");
            let moved = OwnNoise::of(&rows(1.5), &directions, 3, 0.05);
            assert!(!moved.is_noise(), "seed {seed}: {moved:?}");
        }
    }

    #[test]
    fn a_resonance_is_a_line_and_a_smooth_filter_is_none() {
        let filtered =
            |ar: &[f64]| is_filtered(&Wander { tau_s: [1.0; 2], size: [0.0; 2] }, ar, 1, 16.0, 0.05);
        // A Butterworth filter of second order, a difference, and a pole near the unit circle.
        assert!(filtered(&[1.0, -1.0, 0.47]));
        assert!(filtered(&[1.0, 0.66, 0.47, 0.27]));
        assert!(!filtered(&[1.0, -1.2, 0.9]));
        assert!(!filtered(&[1.0, -0.98]));
    }
}
