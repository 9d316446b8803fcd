//! The colour of the magnetometer's noise.

use nalgebra::Vector3;

/// How the noise of one sample follows from those before. All have the same standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Noise {
    /// White, or of first order with the correlation of the options.
    #[default]
    Memory,
    /// 1/f: equal power in every octave, from the Nyquist frequency down to a period of the log.
    Flicker,
    /// A driver's rolling mean over so many samples.
    RollingMean(usize),
}

/// Fading processes whose sum is the noise.
pub(crate) struct Source {
    kind: Noise,
    rho: f64,
    sigma: f64,
    /// By process.
    now: Vec<Vector3<f64>>,
    fades: Vec<f64>,
    at: usize,
}

impl Source {
    /// For `rows` samples. `normal` draws.
    pub(crate) fn new(
        kind: Noise,
        rho: f64,
        sigma: f64,
        rows: usize,
        normal: &mut impl FnMut() -> f64,
    ) -> Self {
        let mut fresh = || Vector3::from_fn(|_, _| normal());
        let (now, fades) = match kind {
            Noise::Memory => (vec![fresh() * sigma], vec![rho]),
            Noise::RollingMean(of) => ((0..of.max(1)).map(|_| fresh()).collect(), Vec::new()),
            Noise::Flicker => {
                let octaves = (rows.max(2) as f64).log2().ceil() as i32;
                let fades: Vec<f64> = (0..octaves).map(|k| (-(0.5_f64.powi(k)) * 2.0).exp()).collect();
                (fades.iter().map(|_| fresh()).collect(), fades)
            }
        };
        Source { kind, rho, sigma, now, fades, at: 0 }
    }

    /// The noise of the next sample.
    pub(crate) fn next(&mut self, normal: &mut impl FnMut() -> f64) -> Vector3<f64> {
        let mut fresh = || Vector3::from_fn(|_, _| normal());
        match self.kind {
            Noise::Memory => {
                let drawn = fresh() * self.sigma;
                self.now[0] = self.now[0] * self.rho + drawn * (1.0 - self.rho * self.rho).sqrt();
                self.now[0]
            }
            Noise::RollingMean(_) => {
                let of = self.now.len();
                self.now[self.at % of] = fresh();
                self.at += 1;
                self.now.iter().sum::<Vector3<f64>>() * (self.sigma / (of as f64).sqrt())
            }
            Noise::Flicker => {
                for (value, fade) in self.now.iter_mut().zip(&self.fades) {
                    *value = *value * *fade + fresh() * (1.0 - fade * fade).sqrt();
                }
                self.now.iter().sum::<Vector3<f64>>() * (self.sigma / (self.fades.len() as f64).sqrt())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn series(kind: Noise, n: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut source = Source::new(kind, 0.5, 2.0, n, &mut normal);
        (0..n).map(|_| source.next(&mut normal).x).collect()
    }

    fn correlation(values: &[f64], lag: usize) -> f64 {
        let square: f64 = values.iter().map(|v| v * v).sum();
        values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / square
    }

    #[test]
    fn each_colour_has_its_size_and_its_memory() {
        for kind in [Noise::Memory, Noise::RollingMean(4), Noise::Flicker] {
            let values = series(kind, 40_000);
            let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
            assert!((rms / 2.0 - 1.0).abs() < 0.2, "{kind:?}: {rms}");
        }
        let mean = series(Noise::RollingMean(4), 40_000);
        assert!((correlation(&mean, 1) - 0.75).abs() < 0.03 && correlation(&mean, 5).abs() < 0.03);
        // Every factor of sixteen in the lag costs about the same.
        let flicker = series(Noise::Flicker, 40_000);
        let [a, b, c] = [2, 32, 512].map(|lag| correlation(&flicker, lag));
        assert!(((a - b) / (b - c) - 1.0).abs() < 0.5, "{a} {b} {c}");
    }
}
