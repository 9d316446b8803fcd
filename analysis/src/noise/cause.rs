//! Whether what wanders has one cause: a single history in a fixed direction, instead of a vector whose axes go their own ways.
//!
//! A sensor's own noise is independent per axis. A cause that nobody logged adds `v·s(t)`, or bends the gain by `diag(v)·x·s(t)`: one
//! history s for all axes. Both are the same Kalman filter with another view of the slow state; the likelier one wins.

use crate::bounds::SHORTEST_CAUSE_BLOCKS;
use crate::noise::model::{Noise, Track, Wander};
use nalgebra::Vector3;

/// Directions of half a sphere that a cause is looked for in at first.
const DIRECTIONS: usize = 13;
/// Rounds that bring the direction near, and their angles.
const NEARER: [f64; 3] = [0.35, 0.17, 0.08];

fn seen(track: &Track, by: impl Fn(usize) -> f64) -> Track {
    let slow = (0..track.weight.len()).map(|block| [by(block), 0.0, 0.0]).collect();
    Track { slow: Some(slow), without_memory: true, ..track.clone() }
}

/// What a cause moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moves {
    /// The offset, along a direction.
    Offset,
    /// The gain of each axis.
    Gain,
    /// The strength of the field, whatever the attitude.
    Field,
}

/// A single cause behind what a fit leaves.
pub struct Cause {
    /// By how much −2 log likelihood falls with it instead of independent axes, its direction paid for.
    pub gain: f64,
    /// Unit vector in the sensor's axes.
    pub direction: Vector3<f64>,
    /// What it moves.
    pub moves: Moves,
    /// Its time constant, s.
    pub time_constant_s: f64,
    /// −2 log likelihood with the price of all its parameters.
    pub cost: f64,
    noise: Noise,
    track: Track,
}

impl Cause {
    /// Its standard deviation, µT.
    pub fn size_ut(&self) -> f64 {
        self.noise.wander.size[1] * self.noise.variance.sqrt()
    }

    /// Its history block by block, µT: seen from the past and from the future alike.
    fn history_ut(&self, residual: &[f64]) -> Vec<f64> {
        let history = self.noise.wander.history(&self.track, residual);
        history.iter().map(|[.., slow]| slow[0]).collect()
    }

    /// What it adds to the offset block by block, µT: its history along its direction.
    pub fn trace_ut(&self, residual: &[f64]) -> Vec<[f64; 3]> {
        self.history_ut(residual).iter().map(|size| (self.direction * *size).into()).collect()
    }

    /// Share of the squared residual that it explains.
    pub fn share(&self, residual: &[f64]) -> f64 {
        let view = self.track.slow.iter().flatten();
        let left = |((r, view), size): ((&f64, &[f64; 3]), &f64)| (r - view[0] * size).powi(2);
        let history = self.history_ut(residual);
        let left: f64 = residual.iter().zip(view).zip(&history).map(left).sum();
        (1.0 - left / residual.iter().map(|r| r * r).sum::<f64>()).clamp(0.0, 1.0)
    }

    /// Of a view, from a wander nearby. `None` where its history is as short as a block: white noise may differ between axes.
    fn of(view: Track, residual: &[f64], noise: &Noise, wander: Wander, price: f64) -> Option<Cause> {
        // It is found without a short memory, which would stand for anything; then that may have its part.
        let near = Noise::fit(&view, residual, Some(wander), f64::INFINITY);
        let whole = Track { without_memory: false, ..view.clone() };
        let best = Noise::fit(&whole, residual, Some(near.wander), f64::INFINITY);
        let best = if best.cost < near.cost { best } else { near };
        let length = view.time_s.last()? - view.time_s.first()?;
        let time_constant_s = best.wander.tau_s[1];
        let cause = Cause {
            gain: noise.cost - best.cost - price,
            direction: Vector3::zeros(),
            moves: Moves::Field,
            time_constant_s,
            cost: best.cost + best.wander.price(residual.len()) + price,
            noise: best,
            track: view,
        };
        (time_constant_s >= SHORTEST_CAUSE_BLOCKS * length / residual.len() as f64).then_some(cause)
    }
}

/// Wanders that a cause is looked for from: what moves may hide in the short memory too, so that several time constants are tried.
fn starts(track: &Track, known: Wander) -> Option<Vec<Wander>> {
    let length = track.time_s.last()? - track.time_s.first()?;
    let mut starts =
        vec![Wander { tau_s: [known.tau_s[0].min(length / 100.0), length / 10.0], size: [0.0, 3.0] }];
    starts.push(Wander { tau_s: [starts[0].tau_s[0], length / 50.0], size: [0.0, 3.0] });
    if known.size[1] > 0.0 {
        starts.push(Wander { size: [known.size[0], known.size[1] * 3f64.sqrt()], ..known });
    } else if known.size[0] > 0.0 {
        starts.push(Wander {
            tau_s: [known.tau_s[0], known.tau_s[0]],
            size: [0.0, known.size[0] * 3f64.sqrt()],
        });
    }
    Some(starts)
}

/// The likeliest strength of the field that changes along the way, where a block shows so much of it.
pub fn changing_field(
    track: &Track,
    residual: &[f64],
    noise: &Noise,
    view: impl Fn(usize) -> f64,
) -> Option<Cause> {
    let view = seen(track, view);
    let cost = |wander: &Wander| Noise::with(&view, *wander, residual).cost;
    let wander = starts(track, noise.wander)?.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
    Cause::of(view, residual, noise, wander, 0.0)
}

/// The likeliest single cause that adds to the offset, behind a residual that is most like this noise.
pub fn single_cause(track: &Track, residual: &[f64], noise: &Noise) -> Option<Cause> {
    likeliest(track, residual, noise, Moves::Offset, |block, v| Vector3::from(track.direction[block]).dot(v))
}

/// The likeliest direction and history of what `moves`, where `view` says how a direction shows in a block.
pub fn likeliest(
    track: &Track,
    residual: &[f64],
    noise: &Noise,
    moves: Moves,
    view: impl Fn(usize, &Vector3<f64>) -> f64,
) -> Option<Cause> {
    let starts = starts(track, noise.wander)?;
    let n = residual.len() as f64;
    // The direction and one size less for independent axes: two parameters.
    let price = 2.0 * n.ln();
    let view = |v: &Vector3<f64>| seen(track, |block| view(block, v));
    let cost = |v: &Vector3<f64>, wander: Wander| Noise::with(&view(v), wander, residual).cost;
    let first = Vector3::new(1.0, 1.0, 1.0).normalize();
    let wander = starts.iter().copied().min_by(|a, b| {
        let least = |w: &Wander| {
            let axes = [first, Vector3::x(), Vector3::y(), Vector3::z()];
            axes.iter().map(|v| cost(v, *w)).fold(f64::INFINITY, f64::min)
        };
        least(a).total_cmp(&least(b))
    })?;
    let mut top: Option<(f64, Vector3<f64>)> = None;
    let try_it = |v: Vector3<f64>, top: &mut Option<(f64, Vector3<f64>)>| {
        let now = cost(&v, wander);
        if top.is_none_or(|(least, _)| now < least) {
            *top = Some((now, v));
        }
    };
    for place in 0..DIRECTIONS {
        let z = (place as f64 + 0.5) / DIRECTIONS as f64;
        let across = (1.0 - z * z).sqrt();
        let (sine, cosine) = (place as f64 * 2.399_963_229_728_653).sin_cos();
        try_it(Vector3::new(across * cosine, across * sine, z), &mut top);
    }
    for angle in NEARER {
        let Some((_, v)) = top else { break };
        let a = v.cross(&Vector3::ith(v.iamin(), 1.0)).normalize();
        let b = v.cross(&a);
        for step in [a, -a, b, -b] {
            try_it((v + step * angle).normalize(), &mut top);
        }
    }
    let (_, direction) = top?;
    Some(Cause { direction, moves, ..Cause::of(view(&direction), residual, noise, wander, price)? })
}
