//! Draws of numbers and directions.

use crate::linalg::{Quat, Vec3, unit};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;

/// Source of random numbers: the same bits on every machine.
pub type Source = ChaCha8Rng;

/// Source for one log: its name and its number give all 32 bytes of the seed.
pub fn source(name: &str, number: u64) -> Source {
    // FNV-1a from two starts: kinds with similar names get unrelated seeds.
    let hash =
        |start: u64| name.bytes().fold(start, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
    let words = [hash(0xcbf2_9ce4_8422_2325), hash(0x9e37_79b9_7f4a_7c15), number, !number];
    let mut seed = [0; 32];
    for (bytes, word) in seed.chunks_exact_mut(8).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    Source::from_seed(seed)
}

/// Uniform between two limits.
pub fn uniform(rng: &mut Source, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// Uniform in the logarithm.
pub fn log_uniform(rng: &mut Source, low: f64, high: f64) -> f64 {
    uniform(rng, low.ln(), high.ln()).exp()
}

/// True with probability `p`.
pub fn chance(rng: &mut Source, p: f64) -> bool {
    rng.random::<f64>() < p
}

/// One of several.
pub fn choose<T: Copy>(rng: &mut Source, list: &[T]) -> T {
    list[rng.random_range(0..list.len())]
}

/// +1 or -1.
pub fn sign(rng: &mut Source) -> f64 {
    choose(rng, &[-1.0, 1.0])
}

/// Standard normal.
pub fn normal(rng: &mut Source) -> f64 {
    rng.sample(StandardNormal)
}

/// Three independent standard normals.
pub fn normal3(rng: &mut Source) -> Vec3 {
    std::array::from_fn(|_| normal(rng))
}

/// Direction, uniform on the sphere.
pub fn direction(rng: &mut Source) -> Vec3 {
    unit(normal3(rng))
}

/// Orientation, uniform over all rotations.
pub fn orientation(rng: &mut Source) -> Quat {
    let q: Quat = std::array::from_fn(|_| normal(rng));
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    q.map(|c| c / length)
}

/// Random order.
pub fn shuffle<T>(rng: &mut Source, list: &mut [T]) {
    for i in (1..list.len()).rev() {
        list.swap(i, rng.random_range(0..=i));
    }
}
