//! The noise of a residual: white, a vector that wanders in the sensor's axes, and a short autoregressive memory.
//!
//! The residual of sample k is `qₖ·(e₁ + e₂)(tₖ) + wₖ`: two Ornstein–Uhlenbeck vectors (fast and slow) seen along the unit gradient
//! q of the model, and white noise. A Kalman filter turns it into independent innovations in O(n); its gains do not depend on the
//! data, so that every column of a linear model passes the same filter. What memory the innovations still have (a driver's rolling
//! mean, differenced noise) is autoregressive. The whole map is triangular: the likelihood is that of the last white residual.

use crate::bounds::MAX_AR_ORDER;
use crate::noise::autoregression::burg;

/// The search for the likeliest wander ends with factors below this: the parabola through three of them gives its top.
const FINEST: f64 = 1.4;
/// Passes of the search for the likeliest wander, at most.
const MOST_PATTERNS: usize = 40;

/// Sizes and time constants of the wander; sizes relative to the white noise of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wander {
    /// Time constants of the fast and the slow vector, s.
    pub tau_s: [f64; 2],
    /// Their standard deviation per axis over that of the white noise.
    pub size: [f64; 2],
}

/// Where the residual is seen: time, direction and number of samples of each block.
#[derive(Debug, Clone, Default)]
pub struct Track {
    /// Mean times, s.
    pub time_s: Vec<f64>,
    /// Unit gradients in the sensor's axes.
    pub direction: Vec<[f64; 3]>,
    /// How the slow vector is seen where that is not along the gradient: a single cause behind it has one direction.
    pub slow: Option<Vec<[f64; 3]>>,
    /// Samples of each block.
    pub weight: Vec<f64>,
    /// Whether a short autoregressive memory is left out.
    pub without_memory: bool,
}

/// A noise model, ready to whiten columns.
#[derive(Debug, Clone)]
pub struct Noise {
    /// The wander.
    pub wander: Wander,
    /// Coefficients of the autoregressive part; the first is 1.
    pub ar: Vec<f64>,
    /// Variance of the white noise of one sample after the autoregressive part, µT².
    pub variance: f64,
    /// −2 log likelihood without constants, the price of the autoregressive order included.
    pub cost: f64,
    filter: Filter,
}

/// `N` independent processes of first order, followed along a series that shows a sum of them beside white noise.
pub struct Kalman<const N: usize> {
    square: [f64; N],
    covariance: [[f64; N]; N],
    state: [f64; N],
}

impl<const N: usize> Kalman<N> {
    /// Nothing seen yet, with the standard deviation of each process.
    pub fn new(size: impl Fn(usize) -> f64) -> Self {
        let square: [f64; N] = core::array::from_fn(|i| size(i).powi(2));
        let mut covariance = [[0.0; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = square[i];
        }
        Kalman { square, covariance, state: [0.0; N] }
    }

    /// Goes on to a value, `decay` of each process later, that sees them by these weights beside white noise of this variance: what was not
    /// expected of it, its variance, and the gains.
    pub fn step(
        &mut self,
        decay: &[f64; N],
        seen: &[f64; N],
        white: f64,
        value: f64,
    ) -> (f64, f64, [f64; N]) {
        let v = &mut self.covariance;
        let mut vh = [0.0; N];
        for i in 0..N {
            let mut sum = 0.0;
            for j in 0..N {
                v[i][j] *= decay[i] * decay[j];
                sum += v[i][j] * seen[j];
            }
            let fresh = self.square[i] * (1.0 - decay[i] * decay[i]);
            v[i][i] += fresh;
            vh[i] = sum + fresh * seen[i];
            self.state[i] *= decay[i];
        }
        let (mut variance, mut innovation) = (white, value);
        for i in 0..N {
            variance += seen[i] * vh[i];
            innovation -= seen[i] * self.state[i];
        }
        let variance = variance.max(white);
        let gain = vh.map(|vh| vh / variance);
        // One triangle and its mirror: rounding must not make it lopsided.
        for i in 0..N {
            self.state[i] += gain[i] * innovation;
            for j in i..N {
                v[i][j] -= gain[i] * vh[j];
                v[j][i] = v[i][j];
            }
        }
        (innovation, variance, gain)
    }
}

/// The Kalman gains of one wander.
#[derive(Debug, Clone)]
struct Filter {
    decay: Vec<[f64; 2]>,
    gain: Vec<[f64; 6]>,
    /// One over the standard deviation of each innovation.
    scale: Vec<f64>,
    log_det: f64,
}

impl Filter {
    /// Gains along a track, with the innovations of one series at once.
    fn run(track: &Track, wander: &Wander, series: &[f64]) -> (Filter, Vec<f64>) {
        match wander.size.map(|size| size > 0.0) {
            [false, false] => Self::white(track, series),
            [true, false] => Self::states::<3>(track, wander, 0, series),
            [false, true] => Self::states::<3>(track, wander, 3, series),
            [true, true] => Self::states::<6>(track, wander, 0, series),
        }
    }

    /// Without a wander nothing is to be followed.
    fn white(track: &Track, series: &[f64]) -> (Filter, Vec<f64>) {
        let scale: Vec<f64> = track.weight.iter().map(|weight| weight.sqrt()).collect();
        let innovations = series.iter().zip(&scale).map(|(value, scale)| value * scale).collect();
        let log_det = -track.weight.iter().map(|weight| weight.ln()).sum::<f64>();
        (Filter { decay: Vec::new(), gain: Vec::new(), scale, log_det }, innovations)
    }

    /// `N` states, the first of which is the number `first` of six.
    fn states<const N: usize>(
        track: &Track,
        wander: &Wander,
        first: usize,
        series: &[f64],
    ) -> (Filter, Vec<f64>) {
        let n = series.len();
        let mut out = Filter {
            decay: Vec::with_capacity(n),
            gain: Vec::with_capacity(n),
            scale: Vec::with_capacity(n),
            log_det: 0.0,
        };
        let mut innovations = Vec::with_capacity(n);
        let mut kalman = Kalman::<N>::new(|i| wander.size[(first + i) / 3]);
        let mut last = track.time_s.first().copied().unwrap_or(0.0);
        let (mut step, mut phi) = (f64::NAN, [1.0; 2]);
        // Products of many variances: one logarithm for all of them.
        let mut product = 1.0;
        for k in 0..n {
            let dt = (track.time_s[k] - last).max(0.0);
            last = track.time_s[k];
            if dt != step {
                step = dt;
                phi = wander.tau_s.map(|tau| (-dt / tau).exp());
            }
            let (q, p) = (track.direction[k], track.slow_direction(k));
            let all = [q[0], q[1], q[2], p[0], p[1], p[2]];
            let decay = core::array::from_fn(|i| phi[(first + i) / 3]);
            let seen = core::array::from_fn(|i| all[first + i]);
            let (innovation, f, gain) = kalman.step(&decay, &seen, 1.0 / track.weight[k], series[k]);
            let mut whole = [0.0; 6];
            whole[first..first + N].copy_from_slice(&gain);
            let scale = 1.0 / f.sqrt();
            out.decay.push(phi);
            out.gain.push(whole);
            out.scale.push(scale);
            product *= f;
            if !(1e-100..1e100).contains(&product) {
                out.log_det += product.ln();
                product = 1.0;
            }
            innovations.push(innovation * scale);
        }
        out.log_det += product.ln();
        (out, innovations)
    }

    /// Innovations of `width` columns, row by row, in place.
    fn apply(&self, track: &Track, wander: &Wander, width: usize, columns: &mut [f64]) {
        let first = if wander.size[0] > 0.0 { 0 } else { 3 };
        let last = if wander.size[1] > 0.0 { 6 } else { 3 };
        let mut state = vec![0.0; 6 * width];
        for (k, row) in columns.chunks_exact_mut(width).enumerate() {
            let (phi, gain, scale) = (self.decay[k], self.gain[k], self.scale[k]);
            let (q, p) = (track.direction[k], track.slow_direction(k));
            let seen = [q[0], q[1], q[2], p[0], p[1], p[2]];
            for i in first..last {
                let (seen, phi) = (seen[i], phi[i / 3]);
                for (value, state) in row.iter_mut().zip(&mut state[i * width..][..width]) {
                    *state *= phi;
                    *value -= seen * *state;
                }
            }
            for i in first..last {
                let gain = gain[i];
                for (value, state) in row.iter().zip(&mut state[i * width..][..width]) {
                    *state += gain * *value;
                }
            }
            row.iter_mut().for_each(|value| *value *= scale);
        }
    }
}

impl Track {
    fn slow_direction(&self, block: usize) -> [f64; 3] {
        self.slow.as_ref().map_or(self.direction[block], |slow| slow[block])
    }
}

impl Wander {
    /// No wander at all.
    pub fn none(track: &Track) -> Wander {
        let step = typical_step(track);
        let length = length_s(track);
        Wander { tau_s: [4.0 * step, (length / 10.0).max(8.0 * step)], size: [0.0; 2] }
    }

    /// With one of its four parameters, time constants and then sizes, moved by a factor, in a log of this step and length; `None` where
    /// there is nothing to move.
    fn moved(&self, which: usize, factor: f64, [step, length]: [f64; 2]) -> Option<Wander> {
        let mut wander = *self;
        if which < 2 {
            if wander.size[which] == 0.0 {
                return None;
            }
            // A vector that stands still over the log is an offset, not a wander.
            let most = if which == 0 { 0.1 * length } else { 0.3 * length };
            wander.tau_s[which] = (wander.tau_s[which] * factor).clamp(0.7 * step, most);
            return (wander.tau_s[0] <= wander.tau_s[1]).then_some(wander);
        }
        let size = &mut wander.size[which - 2];
        *size = match *size {
            0.0 if factor > 1.0 => 0.3,
            0.0 => return None,
            size if factor < 1.0 && size < 0.03 => 0.0,
            size => (size * factor).min(100.0),
        };
        Some(wander)
    }

    /// Price of its parameters, a size and a time constant of each part, in a series of `n` values.
    pub fn price(&self, n: usize) -> f64 {
        let parts = self.size.iter().filter(|size| **size > 0.0).count();
        2.0 * parts as f64 * (n as f64).ln()
    }

    /// Whether both sizes are zero.
    pub fn is_none(&self) -> bool {
        self.size == [0.0; 2]
    }

    /// The fast and the slow vector behind a residual, block by block, µT: the mean of what the filter holds after a block on its way
    /// forwards and on its way back.
    pub fn history(&self, track: &Track, residual: &[f64]) -> Vec<[[f64; 3]; 2]> {
        let forwards = self.held(track, residual);
        let back = |list: &[[f64; 3]]| list.iter().rev().copied().collect::<Vec<_>>();
        let mirror = Track {
            time_s: track.time_s.iter().rev().map(|time| -time).collect(),
            direction: back(&track.direction),
            slow: track.slow.as_deref().map(back),
            weight: track.weight.iter().rev().copied().collect(),
            without_memory: track.without_memory,
        };
        let reversed: Vec<f64> = residual.iter().rev().copied().collect();
        let backwards = self.held(&mirror, &reversed);
        let mean = |(a, b): (&[f64; 6], &[f64; 6])| {
            core::array::from_fn(|part| core::array::from_fn(|i| 0.5 * (a[3 * part + i] + b[3 * part + i])))
        };
        forwards.iter().zip(backwards.iter().rev()).map(mean).collect()
    }

    /// What the filter holds after each block.
    fn held(&self, track: &Track, residual: &[f64]) -> Vec<[f64; 6]> {
        let (filter, _) = Filter::run(track, self, residual);
        let mut state = [0.0; 6];
        let mut out = Vec::with_capacity(residual.len());
        for (k, (value, (phi, gain))) in
            residual.iter().zip(filter.decay.iter().zip(&filter.gain)).enumerate()
        {
            let seen = [track.direction[k], track.slow_direction(k)];
            let mut innovation = *value;
            for i in 0..6 {
                state[i] *= phi[i / 3];
                innovation -= seen[i / 3][i % 3] * state[i];
            }
            for i in 0..6 {
                state[i] += gain[i] * innovation;
            }
            out.push(state);
        }
        out
    }
}

fn typical_step(track: &Track) -> f64 {
    (length_s(track) / (track.time_s.len().max(2) - 1) as f64).max(1e-9)
}

fn length_s(track: &Track) -> f64 {
    track.time_s.last().zip(track.time_s.first()).map_or(1.0, |(last, first)| (last - first).max(1e-6))
}

impl Noise {
    /// The noise with this wander, the autoregressive part as a residual shows it.
    pub fn with(track: &Track, wander: Wander, residual: &[f64]) -> Noise {
        let (filter, innovations) = Filter::run(track, &wander, residual);
        let most = if track.without_memory { 0 } else { MAX_AR_ORDER };
        let (ar, variance, cost) = burg(&innovations, most);
        let cost = cost + filter.log_det;
        Noise { wander, ar, variance, cost, filter }
    }

    /// White noise as strong as a residual.
    pub fn white(track: &Track, residual: &[f64]) -> Noise {
        let wander = Wander::none(track);
        let (filter, innovations) = Filter::run(track, &wander, residual);
        let variance = innovations.iter().map(|v| v * v).sum::<f64>() / innovations.len().max(1) as f64;
        let cost = innovations.len() as f64 * variance.max(1e-300).ln() + filter.log_det;
        Noise { wander, ar: vec![1.0], variance, cost, filter }
    }

    /// The likeliest noise of a residual, its wander less than `most_ut`. `from` begins the search near a known one.
    pub fn fit(track: &Track, residual: &[f64], from: Option<Wander>, most_ut: f64) -> Noise {
        let (step, length) = (typical_step(track), length_s(track));
        let mut starts = Vec::new();
        match from {
            Some(wander) => starts.push(wander),
            None => {
                let slow = (length / 12.0).max(8.0 * step);
                let fast = (8.0 * step).min(length / 20.0).max(2.0 * step);
                for size in [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]] {
                    starts.push(Wander { tau_s: [fast, slow], size });
                }
            }
        }
        let mut best: Option<Noise> = None;
        for start in starts {
            let noise = Noise::with(track, start, residual);
            if best.as_ref().is_none_or(|best| noise.cost < best.cost) {
                best = Some(noise);
            }
        }
        let mut best = best.unwrap_or_else(|| Noise::white(track, residual));
        // A pattern search along each parameter, and where no neighbour is likelier the top of the parabola through them.
        let mut factor = if from.is_some() { 1.6 } else { 3.0 };
        for _ in 0..MOST_PATTERNS {
            let before = best.cost;
            let mut top = best.wander;
            for which in 0..4 {
                let mut beside = [None; 2];
                for (direction, cost) in [factor, 1.0 / factor].into_iter().zip(&mut beside) {
                    let Some(wander) = best.wander.moved(which, direction, [step, length]) else { continue };
                    let noise = Noise::with(track, wander, residual);
                    if noise.cost < best.cost - 0.05 && noise.wander_ut().0 < most_ut {
                        (best, top) = (noise, wander);
                        break;
                    }
                    *cost = Some(noise.cost - best.cost);
                }
                if let [Some(up), Some(down)] = beside
                    && up + down > 0.0
                {
                    let share = 0.5 * (down - up) / (up + down);
                    top = top.moved(which, factor.powf(share), [step, length]).unwrap_or(top);
                }
            }
            if before - best.cost < 0.3 {
                let noise = Noise::with(track, top, residual);
                if noise.cost < best.cost && noise.wander_ut().0 < most_ut {
                    best = noise;
                }
                if factor < FINEST {
                    break;
                }
                factor = factor.sqrt();
            }
        }
        best
    }

    /// Whitens `width` columns, row by row, in place: their rows are then independent with the variance of the noise.
    pub fn whiten(&self, track: &Track, width: usize, columns: &mut [f64]) {
        if width == 0 {
            return;
        }
        if self.wander.is_none() {
            for (row, scale) in columns.chunks_exact_mut(width).zip(&self.filter.scale) {
                row.iter_mut().for_each(|value| *value *= scale);
            }
        } else {
            self.filter.apply(track, &self.wander, width, columns);
        }
        let rows = columns.len() / width;
        let order = self.ar.len() - 1;
        if order > 0 {
            for k in (0..rows).rev() {
                let (before, row) = columns.split_at_mut(k * width);
                let row = &mut row[..width];
                // The first rows have a shorter past: they keep what of the filter they can have.
                for lag in 1..=order.min(k) {
                    let past = &before[(k - lag) * width..][..width];
                    let a = self.ar[lag];
                    row.iter_mut().zip(past).for_each(|(value, past)| *value += a * past);
                }
            }
        }
    }

    /// −2 log likelihood of another residual under this noise, its variance free, without constants.
    pub fn cost_of(&self, whitened: &[f64]) -> f64 {
        let n = whitened.len() as f64;
        let variance = whitened.iter().map(|v| v * v).sum::<f64>() / n.max(1.0);
        n * variance.max(1e-300).ln() + self.filter.log_det + (self.ar.len() - 1) as f64 * n.ln()
    }

    /// Standard deviation per axis of the whole wander, µT, and its time constant, s: that of the larger part.
    pub fn wander_ut(&self) -> (f64, f64) {
        let [fast, slow] = self.wander.size;
        let tau = if fast > slow { self.wander.tau_s[0] } else { self.wander.tau_s[1] };
        (fast.hypot(slow) * self.variance.sqrt(), tau)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
    }

    /// A board that tumbles, and an offset that wanders by `size` with the time constant `tau_s` under white noise of 1 µT.
    fn wandering(size: f64, tau_s: f64, seed: u64) -> (Track, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (n, step) = (2000, 0.1);
        let mut track = Track::default();
        let mut state = [0.0; 3].map(|_: f64| size * normal(&mut rng));
        let keep = (-step / tau_s).exp();
        let mut series = Vec::new();
        for k in 0..n {
            let t = step * k as f64;
            let (a, b) = (0.7 * t, 0.31 * t);
            let q = [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()];
            state
                .iter_mut()
                .for_each(|v| *v = keep * *v + size * (1.0 - keep * keep).sqrt() * normal(&mut rng));
            series.push((0..3).map(|i| q[i] * state[i]).sum::<f64>() + normal(&mut rng));
            track.time_s.push(t);
            track.direction.push(q);
            track.weight.push(1.0);
        }
        (track, series)
    }

    #[test]
    fn white_noise_has_its_variance_and_no_wander_to_speak_of() {
        for seed in 0..4 {
            let (track, series) = wandering(0.0, 5.0, seed);
            let noise = Noise::fit(&track, &series, None, f64::INFINITY);
            assert!((noise.variance - 1.0).abs() < 0.1, "{}", noise.variance);
            assert!(noise.wander_ut().0 < 0.25, "{:?}", noise.wander);
        }
    }

    #[test]
    fn a_wander_is_found_with_its_size_and_its_time_constant() {
        for seed in 0..4 {
            let (track, series) = wandering(2.0, 5.0, seed);
            let noise = Noise::fit(&track, &series, None, f64::INFINITY);
            let (size, tau_s) = noise.wander_ut();
            assert!((1.4..2.8).contains(&size) && (2.0..12.0).contains(&tau_s), "{size} µT over {tau_s} s");
            assert!(noise.cost + 500.0 < Noise::white(&track, &series).cost);
        }
    }

    #[test]
    fn every_column_passes_the_filter_of_the_residual() {
        let (track, series) = wandering(2.0, 5.0, 9);
        let noise = Noise::fit(&track, &series, None, f64::INFINITY);
        let mut columns: Vec<f64> = series.iter().flat_map(|v| [*v, -2.0 * v]).collect();
        noise.whiten(&track, 2, &mut columns);
        let mut alone = series.clone();
        noise.whiten(&track, 1, &mut alone);
        for (pair, alone) in columns.chunks_exact(2).zip(&alone) {
            assert!((pair[0] - alone).abs() < 1e-12 && (pair[1] + 2.0 * alone).abs() < 1e-12);
        }
        // What is left is white: neighbours do not know each other.
        let lagged: f64 = alone.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let squares: f64 = alone.iter().map(|v| v * v).sum();
        assert!((lagged / squares).abs() < 4.0 / (alone.len() as f64).sqrt(), "{}", lagged / squares);
        assert!(
            (noise.cost_of(&alone) - noise.cost).abs() < 10.0,
            "{} {}",
            noise.cost_of(&alone),
            noise.cost
        );
    }
}
