//! Tests of the spectrum.

use super::*;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

fn noise(rho: f64, n: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut x = 0.0;
    let mut fresh = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    (0..n)
        .map(|_| {
            x = rho * x + (1.0_f64 - rho * rho).sqrt() * fresh();
            x
        })
        .collect()
}

/// Slow waves, orthogonal to each other and of length one.
fn waves(n: usize, count: usize) -> Vec<Vec<f64>> {
    (1..=count)
        .map(|k| {
            (0..n)
                .map(|t| {
                    let turn = std::f64::consts::PI * k as f64 * (t as f64 + 0.5) / n as f64;
                    (2.0 / n as f64).sqrt() * turn.cos()
                })
                .collect()
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[test]
fn two_real_series_in_one_transform() {
    let (a, b) = (noise(0.5, 100, 1), noise(0.0, 100, 2));
    let both = transforms(&[a.clone(), b.clone()], 128);
    for (series, transform) in [(a, &both[0]), (b, &both[1])] {
        let alone = transforms(&[series], 128).swap_remove(0);
        for (x, y) in alone.iter().zip(transform) {
            assert!((x.0 - y.0).abs() < 1e-9 && (x.1 - y.1).abs() < 1e-9);
        }
    }
}

#[test]
fn what_a_fit_takes_out_of_slow_noise_is_filled_in_again() {
    let n = 4000;
    let waves = waves(n, 30);
    let mut absorbed = vec![0.0; padded(n) / 2 + 1];
    add_power(&mut absorbed, &transforms(&waves, padded(n)), n);
    for rho in [0.0, 0.6, 0.9, 0.95] {
        let known = (1.0 + rho) / (1.0 - rho);
        let (mut filled, mut plain) = (0.0, 0.0);
        for seed in 0..20 {
            let mut series = noise(rho, n, seed);
            for wave in &waves {
                let share = dot(&series, wave);
                for (value, w) in series.iter_mut().zip(wave) {
                    *value -= share * w;
                }
            }
            filled += Spectrum::of(&series, &absorbed).power[0] / known / 20.0;
            plain += Spectrum::of(&series, &[]).power[0] / known / 20.0;
        }
        assert!(
            (filled - 1.0).abs() < 0.18 && filled > plain - 0.01,
            "rho {rho}: {filled:.3}, without filling {plain:.3}"
        );
    }
}

#[test]
fn the_variance_along_a_wave_is_what_its_test_takes_it_for() {
    // Of many series the share along a slow and along a fast wave, against what one series says of it.
    let n = 3000;
    for (rho, wave) in [(0.9, 4), (0.9, 600), (0.5, 50)] {
        let wave = waves(n, wave).pop().expect("a wave");
        let transform = transforms(std::slice::from_ref(&wave), padded(n)).swap_remove(0);
        let seeds = 200;
        let truth = (0..seeds).map(|seed| dot(&noise(rho, n, seed), &wave).powi(2)).sum::<f64>();
        let noise = Spectrum::of(&noise(rho, n, 7), &[]);
        let expected: f64 = transform
            .iter()
            .enumerate()
            .map(|(bin, (re, im))| weight(bin, padded(n)) * noise.power[bin] * (re * re + im * im))
            .sum::<f64>()
            / padded(n) as f64;
        let ratio = truth / seeds as f64 / expected;
        assert!((0.65..1.5).contains(&ratio), "rho {rho}: {ratio:.2}");
    }
}

#[test]
fn noise_of_each_axis_weighs_on_what_turns_with_the_axes() {
    // Three axes that turn fast past the field, each with slow noise: along the drift of one of them.
    let (n, rho) = (3000, 0.99);
    let turned = |t: usize, axis: usize| (0.7 * t as f64 + 2.0 * axis as f64).sin();
    let weights: Vec<[f64; 3]> = (0..n).map(|t| std::array::from_fn(|axis| turned(t, axis))).collect();
    let drift: Vec<f64> = (0..n).map(|t| weights[t][0] * (t as f64 / n as f64 - 0.5)).collect();
    let size = padded(n);
    let shown = |seed: u64| -> Vec<f64> {
        let axes: Vec<Vec<f64>> = (0..3).map(|axis| noise(rho, n, 3 * seed + axis)).collect();
        (0..n).map(|t| (0..3).map(|axis| weights[t][axis] * axes[axis][t]).sum()).collect()
    };
    let seeds = 300;
    let truth = (0..seeds).map(|seed| dot(&shown(seed), &drift).powi(2)).sum::<f64>() / seeds as f64;
    let power: Vec<f64> = (0..=size / 2)
        .map(|bin| {
            let turn = std::f64::consts::TAU * bin as f64 / size as f64;
            (1.0 - rho * rho) / (1.0 - 2.0 * rho * turn.cos() + rho * rho)
        })
        .collect();
    let by_axes = power_by_axes(std::slice::from_ref(&drift), &weights, &power, size)[(0, 0)];
    assert!((0.8..1.25).contains(&(truth / by_axes)), "{truth} of {by_axes}");
}
