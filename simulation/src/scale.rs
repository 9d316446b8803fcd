//! How large a hidden effect must be to show with a wanted strength.

use crate::attitude::Motion;
use crate::effects::HiddenEffect;
use crate::scenery::Scenery;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// The factor on the effect's coefficients that makes its rms, in the residual that sees it and beyond what the base
/// model absorbs, equal to one µT of sensor noise.
pub(crate) fn unit_coefficients(effect: &HiddenEffect, world: &Scenery) -> f64 {
    let n = 1500;
    let seconds = world.options.seconds;
    let times: Vec<f64> = (0..n).map(|i| seconds * (i as f64 + 0.37) / n as f64).collect();
    let clean = |t: f64| world.soft_iron * world.body_field(t) + world.hard_iron_ut;
    let hidden = |t: f64| effect.kind.simulated.hidden_from_the_magnitude(&effect.drawn, world, t);
    let shape =
        |t: f64| Vector3::from(hidden(t).unwrap_or_else(|| effect.disturbance(world, t, clean(t).into())));
    let vectors: Vec<Vector3<f64>> = times.iter().map(|t| shape(*t)).collect();
    let mean = vectors.iter().sum::<Vector3<f64>>() / n as f64;
    let vector_rms = (vectors.iter().map(|v| v.norm_squared()).sum::<f64>() / n as f64).sqrt();
    let rms = match (hidden(0.0).is_some(), world.options.motion) {
        (true, _) => vector_rms,
        (_, Motion::Rest) => {
            (vectors.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / (3 * n) as f64).sqrt()
        }
        _ => seen_by_the_magnitude(world, &times, &vectors),
    };
    if rms > 1e-9 * vector_rms && rms > 0.0 { 1.0 / rms } else { 0.0 }
}

fn seen_by_the_magnitude(world: &Scenery, times: &[f64], disturbance: &[Vector3<f64>]) -> f64 {
    let correction = world.soft_iron.try_inverse().unwrap_or_else(Matrix3::identity);
    let mut normal = SMatrix::<f64, 9, 9>::identity() * (1e-9 * times.len() as f64);
    let mut right = SVector::<f64, 9>::zeros();
    let (mut squares, mut noise) = (0.0, 0.0);
    for (t, vector) in times.iter().zip(disturbance) {
        let h = world.body_field(*t);
        let u = h.normalize();
        let row = correction.transpose() * u;
        let v = (world.soft_iron * h) / h.norm();
        let base = SVector::<f64, 9>::from([
            row.x,
            row.y,
            row.z,
            u.x * v.x,
            u.x * v.y,
            u.x * v.z,
            u.y * v.y,
            u.y * v.z,
            u.z * v.z,
        ]);
        let seen = row.dot(vector);
        normal += base * base.transpose();
        right += base * seen;
        squares += seen * seen;
        noise += row.norm_squared();
    }
    let absorbed = normal.cholesky().map_or(0.0, |factor| right.dot(&factor.solve(&right)));
    ((squares - absorbed).max(0.0) / noise).sqrt()
}
