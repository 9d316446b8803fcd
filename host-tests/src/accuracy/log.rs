//! A simulated recording: a board with hard and soft iron, moved in some way, read by a sensor with noise and steps.

use super::attitude::Motion;
use ironout_simulation::paper::{Sampler, Truth};
use nalgebra::{Matrix3, Vector3};

/// The field of every log, µT.
pub const FIELD_UT: f64 = 50.0;
/// Samples per second.
pub const RATE_HZ: f64 = 50.0;

/// A recording and the truth behind it.
pub struct Log {
    /// The truth in units of the field.
    pub truth: Truth,
    /// How the board was moved.
    pub motion: Motion,
    /// The sensor's scale, µT per count.
    pub ut_per_count: f64,
    /// Noise on each axis, µT.
    pub noise_ut: f64,
    /// Correlation of the noise from sample to sample.
    pub rho: f64,
    /// What the sensor said.
    pub counts: Vec<[i16; 3]>,
}

impl Log {
    /// A board, sensor and noise drawn from what there is: hard iron 0 … 5 fields, soft iron up to 30 %, noise 0.05 … 2 % of
    /// the field (a third of the logs with correlated noise), steps of 0.02 … 1.5 µT, 8 … 120 s.
    pub fn draw(seed: u64, motion: impl FnOnce(&mut Sampler) -> Motion) -> Self {
        let mut sampler = Sampler::new(seed);
        let motion = motion(&mut sampler);
        let mut log_uniform = |low: f64, high: f64| (sampler.uniform(low.ln(), high.ln())).exp();
        let noise = log_uniform(0.0005, 0.02);
        let ut_per_count = log_uniform(0.02, 1.5);
        let soft = log_uniform(0.01, 0.3);
        let n = log_uniform(400.0, 6000.0) as usize;
        let mut truth = Truth { b: Vector3::zeros(), a: Matrix3::identity() };
        for r in 0..3 {
            for c in r..3 {
                truth.a[(r, c)] += sampler.uniform(-soft, soft);
            }
        }
        let far = sampler.uniform(0.0, 5.0);
        truth.b = sampler.direction(Vector3::z(), 1.0) * far;
        let rho = if sampler.uniform(0.0, 1.0) < 1.0 / 3.0 { sampler.uniform(0.3, 0.95) } else { 0.0 };
        let noise_ut = noise * FIELD_UT;
        let mut state = sampler.normal3();
        let counts = motion
            .directions(&mut sampler, n, RATE_HZ)
            .into_iter()
            .map(|u| {
                state = state * rho + sampler.normal3() * f64::sqrt(1.0 - rho * rho);
                let x = (truth.a * u + truth.b) * FIELD_UT + state * noise_ut;
                std::array::from_fn(|a| (x[a] / ut_per_count).round() as i16)
            })
            .collect();
        Self { truth, motion, ut_per_count, noise_ut, rho, counts }
    }

    /// The largest error of a corrected vector over the field, over 600 directions.
    pub fn worst_error(&self, b_ut: &Vector3<f64>, c: &Matrix3<f64>) -> f64 {
        let mut worst = 0.0f64;
        const DIRECTIONS: usize = 600;
        for i in 0..DIRECTIONS {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
            let angle = 2.399_963_229_728_653 * i as f64;
            let r = (1.0 - z * z).sqrt();
            let u = Vector3::new(r * angle.cos(), r * angle.sin(), z);
            let measured = (self.truth.a * u + self.truth.b) * FIELD_UT;
            let off = c * (measured - b_ut) / FIELD_UT - u;
            // Written so that a NaN is the worst.
            if !(off.norm() <= worst) {
                worst = off.norm();
            }
        }
        worst
    }
}
