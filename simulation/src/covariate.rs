//! Histories of the logged covariates, as functions of time.

use crate::options::{Temperature, WorldOptions};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::TAU;

/// A sum of slow sinusoids: `(amplitude, period in s, phase)` each.
type Wander = [(f64, f64, f64); 3];

/// One burst of current: start, end and height.
type Burst = (f64, f64, f64);

/// The drawn histories.
#[derive(Clone, Debug)]
pub(crate) struct Covariates {
    temperature: Temperature,
    seconds: f64,
    seed: u64,
    start_c: f64,
    rise_c: f64,
    warm_s: f64,
    wander_c: Wander,
    bursts: Vec<Burst>,
}

fn draw_wander(rng: &mut ChaCha8Rng, periods: core::ops::Range<f64>) -> Wander {
    core::array::from_fn(|_| {
        (rng.random_range(0.6..1.2), rng.random_range(periods.clone()), rng.random_range(0.0..TAU))
    })
}

fn wander_at(wander: &Wander, t: f64) -> f64 {
    wander.iter().map(|(amplitude, period, phase)| amplitude * (TAU * t / period + phase).sin()).sum()
}

/// A switch that takes about 0.1 s.
fn edge(t: f64) -> f64 {
    0.5 + 0.5 * (t / 0.03).tanh()
}

/// Levels from -1 to 1, a new one every second or two.
fn levels(seed: u64, t: f64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let period: f64 = rng.random_range(0.8..3.0);
    let place = (t / period).floor();
    let level = |place: f64| -> f64 {
        let own = seed ^ (place as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ChaCha8Rng::seed_from_u64(own).random_range(-1.0..1.0)
    };
    let (now, next) = (level(place), level(place + 1.0));
    now + (next - now) * edge(t - (place + 0.9) * period)
}

/// Waves of all periods from 1 s to 80 s, the slower the larger.
fn rough(seed: u64, t: f64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..12)
        .map(|k| {
            let period = 1.0 * 1.49_f64.powi(k) * rng.random_range(0.85..1.18);
            let amplitude = (period / 80.0_f64).sqrt() * rng.random_range(0.5..1.5);
            amplitude * (TAU * t / period + rng.random_range(0.0..TAU)).sin()
        })
        .sum()
}

impl Covariates {
    pub(crate) fn draw(options: &WorldOptions, rng: &mut ChaCha8Rng) -> Covariates {
        let mut bursts = Vec::new();
        let mut t = rng.random_range(0.0..3.0);
        while t < options.seconds {
            let length = rng.random_range(1.0..5.0);
            bursts.push((t, t + length, rng.random_range(3.0..10.0)));
            t += length + rng.random_range(1.5..6.0);
        }
        Covariates {
            temperature: options.temperature,
            seconds: options.seconds,
            seed: rng.random(),
            start_c: rng.random_range(18.0..26.0),
            rise_c: rng.random_range(5.0..10.0),
            warm_s: options.seconds * rng.random_range(0.2..0.4),
            wander_c: draw_wander(rng, 11.0..45.0),
            bursts,
        }
    }

    /// The named covariate at time `t`. `temp_c` warms up, a current comes in bursts, `servo` stands at levels, `load` is as
    /// rough as a random walk, every other name wanders.
    pub(crate) fn at(&self, name: &str, t: f64) -> f64 {
        if name == "temp_c" {
            return match self.temperature {
                Temperature::Ramp => self.start_c + self.rise_c * t / self.seconds,
                Temperature::WarmUp => {
                    self.start_c
                        + self.rise_c * (1.0 - (-t / self.warm_s).exp())
                        + 0.8 * wander_at(&self.wander_c, t)
                }
            };
        }
        if name == "current_a" {
            let now = self.bursts.partition_point(|burst| burst.0 < t);
            let near = &self.bursts[now.saturating_sub(2)..(now + 1).min(self.bursts.len())];
            return 0.4
                + near
                    .iter()
                    .map(|(from, to, height)| height * (edge(t - from) - edge(t - to)))
                    .sum::<f64>();
        }
        // A name's history must not depend on which other names are asked for, so it is drawn from the name.
        let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        if name == "servo" {
            return levels(self.seed ^ hash, t);
        }
        if name == "load" {
            return rough(self.seed ^ hash, t);
        }
        let wander = draw_wander(&mut ChaCha8Rng::seed_from_u64(self.seed ^ hash), 4.0..40.0);
        wander_at(&wander, t)
    }
}
