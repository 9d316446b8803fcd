//! The paper's simulation (Dong, Chou, Fang 2014, eq. (16)) and its Cramér–Rao bound.
//!
//! Directions are uniform on the unit sphere, or on a cap of it; the noise is white and Gaussian, σ on each axis.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use rand::{RngExt, SeedableRng, rngs::ChaCha12Rng};
use rand_distr::{Distribution, StandardNormal};

/// A truth: hard iron and soft iron of a sensor in a unit field.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// Hard iron `b`, fields.
    pub b: Vector3<f64>,
    /// Soft iron `A`, upper triangular.
    pub a: Matrix3<f64>,
}

/// The paper's truth, eq. (16).
pub fn eq_16() -> Truth {
    Truth {
        b: Vector3::new(0.5, 0.0, 0.75f64.sqrt()),
        a: Matrix3::new(0.64, 0.16, 0.25, 0.0, 0.62, 0.71, 0.0, 0.0, 0.79),
    }
}

/// The paper's own estimate, eq. (17).
pub fn eq_17() -> Truth {
    Truth {
        b: Vector3::new(0.51, 0.1, 0.95),
        a: Matrix3::new(0.64, 0.16, 0.27, 0.0, 0.63, 0.72, 0.0, 0.0, 0.78),
    }
}

/// A seeded source of samples.
pub struct Sampler {
    rng: ChaCha12Rng,
}

impl Sampler {
    /// The same samples for the same seed.
    pub fn new(seed: u64) -> Self {
        Self { rng: ChaCha12Rng::seed_from_u64(seed) }
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }

    /// A vector of three standard normal numbers.
    pub fn normal3(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }

    /// A uniform number between `low` and `high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.rng.random_range(low..high)
    }

    /// A direction uniform over a cap about `pole` that holds `fraction` of the sphere.
    pub fn direction(&mut self, pole: Vector3<f64>, fraction: f64) -> Vector3<f64> {
        let z = 1.0 - self.rng.random_range(0.0..=1.0) * 2.0 * fraction;
        let angle = self.rng.random_range(0.0..std::f64::consts::TAU);
        let side = pole.cross(&if pole.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() }).normalize();
        let up = pole.cross(&side);
        pole * z + (side * angle.cos() + up * angle.sin()) * (1.0 - z * z).max(0.0).sqrt()
    }

    /// A soft iron within `spread` of the identity, upper triangular, and a hard iron of up to a field.
    pub fn mild_truth(&mut self, spread: f64) -> Truth {
        let mut a = Matrix3::identity();
        for r in 0..3 {
            for c in r..3 {
                a[(r, c)] += self.uniform(-spread, spread);
            }
        }
        Truth { b: Vector3::from_fn(|_, _| self.uniform(-1.0, 1.0)), a }
    }
}

impl Truth {
    /// Measured samples, noise `sigma` on each axis, directions over a cap of `fraction` about `pole`; the unit is the field.
    pub fn samples(
        &self,
        sampler: &mut Sampler,
        n: usize,
        sigma: f64,
        pole: Vector3<f64>,
        fraction: f64,
    ) -> Vec<[f64; 3]> {
        (0..n)
            .map(|_| {
                let u = sampler.direction(pole, fraction);
                (self.a * u + self.b + sampler.normal3() * sigma).into()
            })
            .collect()
    }

    /// The nine numbers: b, then A's upper triangle row by row.
    pub fn nine(&self) -> SVector<f64, 9> {
        let (a, b) = (&self.a, &self.b);
        SVector::from_column_slice(&[
            b[0],
            b[1],
            b[2],
            a[(0, 0)],
            a[(0, 1)],
            a[(0, 2)],
            a[(1, 1)],
            a[(1, 2)],
            a[(2, 2)],
        ])
    }

    /// Cramér–Rao bound of the rms norm of the error of the nine numbers, for `n` samples of noise `sigma`.
    pub fn bound(&self, n: usize, sigma: f64, pole: Vector3<f64>, fraction: f64) -> f64 {
        let inverse = self.a.try_inverse().expect("the truth is invertible");
        let mut sampler = Sampler::new(0xb0d);
        let mut information = SMatrix::<f64, 9, 9>::zeros();
        const DRAWS: usize = 20_000;
        for _ in 0..DRAWS {
            let u = sampler.direction(pole, fraction);
            // f = ‖A⁻¹(x−b)‖ − 1: ∂f/∂b = −A⁻ᵀu, ∂f/∂A_jk = −(A⁻ᵀu)_j u_k, variance σ²‖A⁻ᵀu‖².
            let w = inverse.transpose() * u;
            let mut g = SVector::<f64, 9>::zeros();
            let mut at = 3;
            for j in 0..3 {
                g[j] = -w[j];
                for k in j..3 {
                    g[at] = -w[j] * u[k];
                    at += 1;
                }
            }
            information += g * g.transpose() / (w.norm_squared() * sigma * sigma);
        }
        let information = information * (n as f64 / DRAWS as f64);
        information.try_inverse().map_or(f64::INFINITY, |c| c.trace().sqrt())
    }
}
