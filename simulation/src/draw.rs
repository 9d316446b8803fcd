//! Hidden effects drawn for one world.

use crate::effects::{Drawn, EffectSpec, HiddenEffect};
use crate::scale::unit_coefficients;
use crate::scenery::Scenery;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A disturbed sensor that takes more rounds than this does not settle.
pub(crate) const MOST_ROUNDS: usize = 300;
/// Draws of one effect until its readings are unique.
const MOST_DRAWS: usize = 50;

/// Draws an effect. Its size follows from what the base model of that world does not absorb.
pub(crate) fn draw(spec: &EffectSpec, scenery: &Scenery, rng: &mut ChaCha8Rng) -> HiddenEffect {
    let mut effect = draw_any(spec, scenery, rng);
    // A strong nonlinearity may fold back, so that two fields give one reading: no sensor that anybody would use.
    for _ in 0..MOST_DRAWS {
        if settles(&effect, scenery) {
            break;
        }
        effect = draw_any(spec, scenery, rng);
    }
    effect
}

/// Whether every true field has a reading of its own, with a margin: between the instants looked at, too.
fn settles(effect: &HiddenEffect, scenery: &Scenery) -> bool {
    let n = 1000;
    let alone = std::slice::from_ref(effect);
    (0..n).all(|i| {
        let t = scenery.options.seconds * f64::from(i) / f64::from(n);
        let clean = scenery.clean(t) + scenery.hard_iron_ut;
        scenery.settled(alone, t, clean, MOST_ROUNDS / 3).is_some()
    })
}

fn draw_any(spec: &EffectSpec, scenery: &Scenery, rng: &mut ChaCha8Rng) -> HiddenEffect {
    let (options, simulated) = (&scenery.options, spec.kind.simulated);
    let seconds = options.seconds;
    let count = simulated.coefficients();
    let mut coefficients: Vec<f64> = (0..count).map(|_| StandardNormal.sample(rng)).collect();
    simulated.balance(&mut coefficients, options.field_ut);
    let nyquist = options.rate_hz / 2.0;
    let drawn = Drawn {
        coefficients,
        reference: 0.0,
        at_s: seconds * rng.random_range(0.25..0.75),
        frequency_hz: rng.random_range(1.5..(nyquist * 0.95).max(1.6)),
        delay_s: rng.random_range(0.15..0.6),
        // Of what the log is long enough to show.
        time_constant_s: if spec.kind.slow { seconds * rng.random_range(0.02..0.15) } else { 0.0 },
        rotation: None,
    };
    let mut effect = HiddenEffect { kind: spec.kind.clone(), drawn };
    effect.drawn.rotation = simulated.rotation(spec.strength, &mut || StandardNormal.sample(rng));
    if effect.drawn.rotation.is_some() {
        return effect;
    }
    effect.drawn.reference = mean_input(&effect, scenery);
    let scale = match spec.delay_s {
        Some(delay) => delay / effect.drawn.theta(0),
        None => spec.strength * options.noise_ut * unit_coefficients(&effect, scenery),
    };
    for coefficient in &mut effect.drawn.coefficients {
        *coefficient *= scale;
    }
    simulated.settle(&mut effect.drawn);
    effect
}

fn mean_input(effect: &HiddenEffect, scenery: &Scenery) -> f64 {
    let n = 2000;
    let at = |i: i32| scenery.options.seconds * f64::from(i) / f64::from(n);
    (0..n).map(|i| effect.input(scenery, at(i))).sum::<f64>() / f64::from(n)
}
