//! Noise of eight colours and white noise, all with a standard deviation of 1.

use crate::random::{Source, chance, log_uniform, normal, uniform};
use rand::RngExt;
use rand_distr::StudentT;

/// Colour of the magnetometer's noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Independent normal samples.
    White,
    /// First-order autoregressive: short or long memory.
    Ar1,
    /// Equal power in every octave.
    OneOverF,
    /// Mean of the last samples, as a driver's filter makes it.
    RollingMean,
    /// Random walk that returns to zero (Ornstein-Uhlenbeck).
    Wander,
    /// Differences of white noise.
    Blue,
    /// White noise and a slow one together.
    TwoScales,
    /// Student's t: rare large errors.
    HeavyTails,
    /// Steps of the converter larger than the noise before it.
    Quantised,
}

impl Colour {
    /// The eight that are not white.
    pub const COLOURED: [Colour; 8] = [
        Colour::Ar1,
        Colour::OneOverF,
        Colour::RollingMean,
        Colour::Wander,
        Colour::Blue,
        Colour::TwoScales,
        Colour::HeavyTails,
        Colour::Quantised,
    ];

    /// Draws noise for the three axes, `n` samples at `rate` Hz, and describes it.
    pub fn draw(self, rng: &mut Source, n: usize, rate: f64) -> ([Vec<f64>; 3], String) {
        let length = n as f64 / rate;
        match self {
            Colour::White => (each_axis(|| white(rng, n)), "white".into()),
            Colour::Quantised => (each_axis(|| white(rng, n)), "white under a coarse quantisation".into()),
            Colour::Ar1 => {
                let memory = log_uniform(rng, 0.7, 40.0);
                let spread = if chance(rng, 0.5) { 2.0 } else { 1.0 };
                let memories = [memory / spread, memory, memory * spread];
                let mut axis = memories.iter();
                let noise = each_axis(|| ar1(rng, n, *axis.next().unwrap_or(&memory)));
                (noise, format!("AR(1), memory per axis {memories:.1?} samples"))
            }
            Colour::OneOverF => {
                (each_axis(|| one_over_f(rng, n)), "1/f from the sample time to the log's length".into())
            }
            Colour::RollingMean => {
                let width = rng.random_range(2..=12);
                let noise = each_axis(|| {
                    let raw = white(rng, n + width - 1);
                    let k = 1.0 / (width as f64).sqrt();
                    raw.windows(width).map(|w| k * w.iter().sum::<f64>()).collect()
                });
                (noise, format!("rolling mean of {width} samples"))
            }
            Colour::Wander => {
                let memory_s = log_uniform(rng, 0.5, length / 10.0);
                let noise = each_axis(|| ar1(rng, n, memory_s * rate));
                (noise, format!("Ornstein-Uhlenbeck, memory {memory_s:.2} s"))
            }
            Colour::Blue => {
                let noise = each_axis(|| {
                    let raw = white(rng, n + 1);
                    raw.windows(2).map(|w| (w[1] - w[0]) / 2.0_f64.sqrt()).collect()
                });
                (noise, "blue: differences of white noise".into())
            }
            Colour::TwoScales => {
                let memory_s = log_uniform(rng, 0.2, length / 20.0);
                let share = uniform(rng, 0.2, 0.7);
                let noise = each_axis(|| {
                    let slow = ar1(rng, n, memory_s * rate);
                    let mix = |s: f64, w: f64| share.sqrt() * s + (1.0 - share).sqrt() * w;
                    slow.into_iter().zip(white(rng, n)).map(|(s, w)| mix(s, w)).collect()
                });
                (
                    noise,
                    format!(
                        "two time scales: {:.0} % of the variance has a memory of {memory_s:.2} s",
                        100.0 * share
                    ),
                )
            }
            Colour::HeavyTails => {
                let freedom = uniform(rng, 2.8, 5.0);
                let k = ((freedom - 2.0) / freedom).sqrt();
                let draw = |rng: &mut Source| StudentT::new(freedom).map_or(0.0, |t| k * rng.sample(t));
                (
                    each_axis(|| (0..n).map(|_| draw(rng)).collect()),
                    format!("Student's t, {freedom:.1} degrees of freedom"),
                )
            }
        }
    }
}

fn each_axis(mut draw: impl FnMut() -> Vec<f64>) -> [Vec<f64>; 3] {
    std::array::from_fn(|_| draw())
}

/// White noise.
pub fn white(rng: &mut Source, n: usize) -> Vec<f64> {
    (0..n).map(|_| normal(rng)).collect()
}

/// First-order autoregressive noise with a memory in samples, stationary from its first sample.
pub fn ar1(rng: &mut Source, n: usize, memory: f64) -> Vec<f64> {
    let keep = (-1.0 / memory.max(0.05)).exp();
    let new = (1.0 - keep * keep).sqrt();
    let mut state = normal(rng);
    let mut noise = Vec::with_capacity(n);
    for _ in 0..n {
        noise.push(state);
        state = keep * state + new * normal(rng);
    }
    noise
}

/// Noise of one autoregressive part per factor of two in time, all with equal variance: nearly 1/f.
fn one_over_f(rng: &mut Source, n: usize) -> Vec<f64> {
    let octaves = ((n as f64).log2() - 1.0).ceil().max(1.0) as i32;
    let mut sum = vec![0.0; n];
    for octave in 0..octaves {
        let part = ar1(rng, n, 0.5 * 2.0_f64.powi(octave));
        sum.iter_mut().zip(part).for_each(|(s, p)| *s += p / f64::from(octaves).sqrt());
    }
    sum
}
