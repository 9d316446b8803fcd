//! Tests of the colours.

use crate::noise::colour::{Colour, Described, Seen};
use crate::noise::shared::together;
use crate::noise::still::Still;
use crate::noise::turning::Turning;
use ironout::calibration::Calibration;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

const N: usize = 4000;
const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn fresh(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
}

/// Noise of one axis, of unit variance.
fn noise(colour: Colour, rng: &mut ChaCha8Rng) -> Vec<f64> {
    match colour {
        Colour::White => (0..N).map(|_| fresh(rng)).collect(),
        Colour::Ar1(rho) => {
            let mut now = fresh(rng);
            (0..N)
                .map(|_| {
                    now = rho * now + (1.0 - rho * rho).sqrt() * fresh(rng);
                    now
                })
                .collect()
        }
        Colour::RollingMean { of, white } => {
            let all: Vec<f64> = (0..N + of).map(|_| fresh(rng)).collect();
            let mean = |at: usize| all[at..at + of].iter().sum::<f64>() / (of as f64).sqrt();
            (0..N).map(|at| (1.0 - white).sqrt() * mean(at) + white.sqrt() * fresh(rng)).collect()
        }
        Colour::Flicker { .. } => {
            // Octave by octave, each as strong as the others.
            let fades: Vec<f64> = (0..12).map(|k| (-2.0 * 0.5_f64.powi(k)).exp()).collect();
            let mut now: Vec<f64> = fades.iter().map(|_| fresh(rng)).collect();
            (0..N)
                .map(|_| {
                    for (value, fade) in now.iter_mut().zip(&fades) {
                        *value = fade * *value + (1.0 - fade * fade).sqrt() * fresh(rng);
                    }
                    now.iter().sum::<f64>() / (fades.len() as f64).sqrt()
                })
                .collect()
        }
    }
}

fn directions() -> Vec<[f64; 3]> {
    (0..N)
        .map(|at| {
            let (a, b) = (at as f64 * 0.011, at as f64 * 0.0173);
            [a.cos() * b.sin(), a.sin() * b.sin(), b.cos()]
        })
        .collect()
}

/// The residual that a turning board makes of the noise of its axes, with `more` beside it.
fn described(colour: Colour, seed: u64, more: impl Fn(usize) -> f64) -> Described {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let axes = [noise(colour, &mut rng), noise(colour, &mut rng), noise(colour, &mut rng)];
    let directions = directions();
    let residual: Vec<f64> =
        (0..N).map(|at| (0..3).map(|i| axes[i][at] * directions[at][i]).sum::<f64>() + more(at)).collect();
    let turning = Turning::of(directions.into_iter(), &UNIT);
    // Nothing was fitted here.
    Seen::of(&residual, &turning, &[], 0.0).describe()
}

#[test]
fn each_colour_is_told() {
    let flicker = Colour::Flicker { exponent: 1.0, white: 0.0, folded: true };
    for seed in 0..6 {
        for colour in [
            Colour::White,
            Colour::Ar1(0.4),
            Colour::Ar1(0.9),
            Colour::RollingMean { of: 5, white: 0.0 },
            Colour::RollingMean { of: 3, white: 0.05 },
            Colour::RollingMean { of: 8, white: 0.2 },
            flicker,
        ] {
            let found = described(colour, seed, |_| 0.0);
            let near = match (colour, found.colour) {
                (Colour::White, Colour::White) => true,
                (Colour::Ar1(a), Colour::Ar1(b)) => (a - b).abs() < 0.05,
                (Colour::RollingMean { of: a, white: p }, Colour::RollingMean { of: b, white: q }) => {
                    a == b && (p - q).abs() <= 0.4 * p
                }
                (Colour::Flicker { .. }, Colour::Flicker { exponent, white, .. }) => {
                    (exponent - 1.0).abs() < 0.21 && white < 0.3
                }
                _ => false,
            };
            assert!(near && found.is_noise(0.02), "seed {seed}: {colour:?} is taken for {:?}", found.colour);
        }
    }
}

#[test]
fn what_moves_beside_noise_is_no_noise() {
    for seed in 0..6 {
        for period in [8.0, 60.0, 400.0] {
            let wave = |at: usize| 1.5 * (std::f64::consts::TAU * at as f64 / period).sin();
            let found = described(Colour::White, seed, wave);
            assert!(
                !found.is_noise(0.02),
                "seed {seed}, period {period}: {:?} {}",
                found.colour,
                found.misfit()
            );
            assert!(found.excess > 0.2, "seed {seed}, period {period}: {}", found.excess);
        }
        let switched = |at: usize| if (at / 300).is_multiple_of(2) { 1.5 } else { -1.5 };
        let found = described(Colour::Ar1(0.5), seed, switched);
        assert!(!found.is_noise(0.02), "seed {seed}: {:?} {}", found.colour, found.misfit());
    }
}

#[test]
fn a_memory_of_seconds_is_none_of_a_sensor() {
    assert!(Colour::Ar1(0.9).is_of_a_sensor(0.02) && Colour::Ar1(0.95).is_of_a_sensor(0.02));
    assert!(!Colour::Ar1(0.95).is_of_a_sensor(0.1) && !Colour::Ar1(0.99).is_of_a_sensor(0.0));
    assert!(
        Colour::RollingMean { of: 8, white: 0.0 }.is_of_a_sensor(0.1)
            && !Colour::RollingMean { of: 30, white: 0.0 }.is_of_a_sensor(0.1)
    );
    assert!(!Colour::Flicker { exponent: 1.5, white: 0.0, folded: true }.is_of_a_sensor(0.02));
}

#[test]
fn a_cause_moves_the_axes_together_and_noise_does_not() {
    let matrix = [[1.1, 0.1, -0.05], [0.0, 0.95, 0.08], [0.0, 0.0, 1.2]];
    // All round, and a hand that waves about one attitude.
    let waved = |at: usize| {
        let (a, b) = (0.6 * (at as f64 * 0.021).sin(), 0.4 * (at as f64 * 0.013).sin() + 0.7);
        [a.cos() * b.sin(), a.sin() * b.sin(), b.cos()]
    };
    for directions in [directions(), (0..N).map(waved).collect()] {
        let turning = Turning::of(directions.into_iter(), &matrix);
        let seen = |axes: &[Vec<f64>]| -> Vec<f64> {
            (0..N).map(|at| (0..3).map(|i| axes[i][at] * turning.weights[at][i]).sum()).collect()
        };
        let colours = [
            Colour::Ar1(0.9),
            Colour::RollingMean { of: 5, white: 0.0 },
            Colour::Flicker { exponent: 1.0, white: 0.0, folded: true },
        ];
        for (seed, colour) in (0..4).flat_map(|seed| colours.map(|colour| (seed, colour))) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let apart = [(); 3].map(|()| noise(colour, &mut rng));
            assert!(!together(&seen(&apart), &turning, colour, 0.0), "seed {seed}: {colour:?}");
            // Along one direction, beside a little of each axis' own.
            let cause = noise(colour, &mut rng);
            let along = [0.6, -0.5, 0.6];
            let both: [Vec<f64>; 3] = std::array::from_fn(|i| {
                cause.iter().zip(&apart[i]).map(|(cause, own)| along[i] * cause + 0.3 * own).collect()
            });
            assert!(together(&seen(&both), &turning, colour, 0.0), "seed {seed}: {colour:?}");
        }
    }
}

#[test]
fn noise_that_was_filtered_before_its_sampling_is_noise() {
    // 1/f by its transform, and nothing of what lies beyond half the sampling rate.
    let size = 2 * N.next_power_of_two();
    let directions = directions();
    for seed in 0..4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let axes = [(); 3].map(|()| {
            let mut data: Vec<(f64, f64)> = (0..size).map(|_| (fresh(&mut rng), 0.0)).collect();
            crate::samples::fft::forward(&mut data);
            for (bin, value) in data.iter_mut().enumerate() {
                let by = (bin.min(size - bin).max(1) as f64).powf(-0.5);
                *value = (value.0 * by, value.1 * by);
            }
            crate::samples::fft::forward(&mut data);
            data.into_iter().take(N).map(|value| value.0).collect::<Vec<f64>>()
        });
        let residual: Vec<f64> =
            (0..N).map(|at| (0..3).map(|i| axes[i][at] * directions[at][i]).sum()).collect();
        let turning = Turning::of(directions.iter().copied(), &UNIT);
        let found = Seen::of(&residual, &turning, &[], 0.0).describe();
        assert!(found.is_noise(0.02), "seed {seed}: {:?} {}", found.colour, found.misfit());
        assert!(
            matches!(found.colour, Colour::Flicker { folded: false, .. }),
            "seed {seed}: {:?}",
            found.colour
        );
        assert!(found.misfit() < 4.0, "seed {seed}: {}", found.misfit());
    }
}

/// The residual of the board that turns, and readings of it at rest in this noise of its axes.
fn beside_rest(moving: Colour, at_rest: Colour, seed: u64) -> (Vec<f64>, Turning) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (axes, rest) = ([0; 3].map(|_| noise(moving, &mut rng)), [0; 3].map(|_| noise(at_rest, &mut rng)));
    let dirs = directions();
    let residuals = (0..N).map(|at| (0..3).map(|i| dirs[at][i] * axes[i][at]).sum()).collect();
    let still: Vec<[f64; 3]> =
        (0..1600).map(|at| std::array::from_fn(|i| 40.0 * dirs[7][i] + rest[i][at])).collect();
    let calibration = Calibration::identity(40.0);
    (residuals, Turning::of(dirs.into_iter(), &UNIT).beside(&[still], 1, &calibration))
}

#[test]
fn noise_is_the_same_at_rest_and_what_comes_with_the_turning_is_not() {
    for seed in 0..20 {
        for colour in [Colour::White, Colour::Ar1(0.7), Colour::RollingMean { of: 5, white: 0.0 }] {
            let (residuals, turning) = beside_rest(colour, colour, seed);
            let still = Still::of(&residuals, &turning, colour, 0.0).unwrap();
            assert!(still.sigmas.abs() < 4.5 && (0.7..1.4).contains(&still.share), "{colour:?} {still:?}");
        }
        // An error as slow as the turning, on a sensor whose own noise is white and a third as large.
        let (residuals, turning) = beside_rest(Colour::Ar1(0.9), Colour::White, seed);
        let mut small = turning.clone();
        small.rest.iter_mut().flat_map(|rest| &mut rest.residuals).for_each(|r| *r *= 0.33);
        let still = Still::of(&residuals, &small, Colour::Ar1(0.9), 0.0).unwrap();
        assert!(still.sigmas < -5.0 && still.share < 0.8, "{still:?}");
        // Where rounding is most of it nothing is said of the rest.
        let rounded = Still::of(&residuals, &small, Colour::Ar1(0.9), 0.5).unwrap();
        assert_eq!(rounded.samples + 1600, still.samples, "{rounded:?}");
    }
}

#[test]
fn readings_that_are_not_of_the_field_tell_nothing_of_the_noise() {
    let calibration = Calibration::identity(40.0);
    let beside = |reading: [f64; 3]| {
        Turning::of(directions().into_iter(), &UNIT).beside(&[vec![reading; 50]], 1, &calibration).rest.len()
    };
    assert_eq!(beside([0.0, 0.0, 41.0]), 1);
    assert_eq!(beside([0.0, 0.0, 0.1]), 0, "a sensor that is off");
    assert_eq!(beside([0.0, 0.0, 0.0]), 0, "no direction");
    assert_eq!(beside([0.0, 90.0, 40.0]), 0, "a magnet beside the board");
}
