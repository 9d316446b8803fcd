//! The single cause behind what a fit leaves: one that adds to the offset, one that bends the gain, or a field that is stronger in one place
//! than in another.

use crate::evidence::design::Point;
use crate::evidence::fit::Fit;
use crate::noise::cause::{Cause, Moves, changing_field, likeliest, single_cause};
use nalgebra::Vector3;

/// The gain of the likeliest single cause; zero where independent axes are likelier.
pub fn hidden_cause_gain(fit: &Fit) -> f64 {
    hidden_cause(fit).map_or(0.0, |cause| cause.gain.max(0.0))
}

/// The likeliest single cause behind what a fit leaves. `None` where the log has no times, or what moves is shorter than a block.
pub fn hidden_cause(fit: &Fit) -> Option<Cause> {
    let residual = fit.residual();
    let size = fit.track.weight.len();
    let per_block = fit.points.len().div_ceil(size.max(1)).max(1);
    let mean = |chunk: &[Point]| {
        chunk.iter().map(|p| p.closest - fit.model.offset).sum::<Vector3<f64>>() / chunk.len() as f64
    };
    let readings: Vec<Vector3<f64>> = fit.points.chunks(per_block).map(mean).collect();
    let gain = |block: usize, v: &Vector3<f64>| {
        let q = Vector3::from(fit.track.direction[block]);
        q.dot(&readings[block].component_mul(v)) / fit.model.field
    };
    let offset = single_cause(&fit.track, &residual, &fit.noise);
    let gain = likeliest(&fit.track, &residual, &fit.noise, Moves::Gain, gain);
    let stretch: Vec<f64> = fit
        .points
        .chunks(per_block)
        .map(|chunk| chunk.iter().map(|p| p.stretch).sum::<f64>() / chunk.len() as f64)
        .collect();
    let mean = stretch.iter().sum::<f64>() / size as f64;
    let field = changing_field(&fit.track, &residual, &fit.noise, |block| stretch[block] / mean);
    offset
        .into_iter()
        .chain(gain)
        .chain(field)
        .reduce(|most, next| if next.gain > most.gain { next } else { most })
}
