//! Noise with a memory: the session must see through it, however the samples are spaced.

use super::config::SessionConfig;
use super::machine::Session;
use crate::calibration::Calibration;
use crate::fit::FitReport;
use crate::math;
use crate::sensor::Sample;

/// Seeded noise, mean zero and variance one.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        // Twelve uniform numbers: near enough to a normal one.
        (0..12).map(|_| uniform()).sum()
    }
}

const OFFSET_UT: [f64; 3] = [61.0, -20.0, 33.0];

/// A chip of 75 Hz read 50 times a second, intervals of 13 and 27 ms in turn, turned at `speed_radps`; noise of `noise_ut`
/// with a correlation of `rho` from sample to sample.
fn solve(seed: u64, speed_radps: f64, noise_ut: f64, rho: f64) -> (bool, FitReport) {
    let sensor = Calibration {
        offset_ut: OFFSET_UT,
        matrix: [[1.05, 0.06, -0.03], [0.0, 0.96, 0.04], [0.0, 0.0, 1.01]],
        field_ut: 50.0,
    };
    let config = SessionConfig {
        ut_per_count: [0.1; 3],
        field_ut: Some(50.0),
        #[cfg(feature = "methods")]
        method: crate::fit::Method::Adjusted,
        samples_per_block: 16,
        axes: None,
    };
    let mut noise = Noise(seed);
    for _ in 0..10 {
        noise.next();
    }
    let phase = 3.0 * noise.next();
    let mut state = [noise.next(), noise.next(), noise.next()];
    let mut session = Session::new(config);
    session.start();
    for i in 0..1000u32 {
        let t_s = f64::from(i / 2) * 0.04 + f64::from(i % 2) * 0.04 / 3.0;
        let (turn, tilt) = (speed_radps * t_s, 0.41 * speed_radps * t_s + phase);
        let field = [
            50.0 * math::cos(tilt) * math::cos(turn),
            50.0 * math::cos(tilt) * math::sin(turn),
            50.0 * math::sin(tilt),
        ];
        let measured = sensor.distort(field).expect("the sensor is regular");
        let mut counts = [0; 3];
        for axis in 0..3 {
            state[axis] = rho * state[axis] + math::sqrt(1.0 - rho * rho) * noise.next();
            counts[axis] = math::round((measured[axis] + noise_ut * state[axis]) / 0.1) as i16;
        }
        session.push(Sample::valid(counts));
    }
    let outcome = session.stop().expect("it collects").clone();
    (outcome.verdict.accepted, outcome.report.expect("there is a fit"))
}

/// Over some logs: rms of the offset's errors over their standard errors, and the mean number of independent samples.
fn honesty(speed_radps: f64, noise_ut: f64, rho: f64) -> (f64, f64) {
    const LOGS: u64 = 24;
    let (mut square, mut independent) = (0.0, 0.0);
    for seed in 0..LOGS {
        let (_, report) = solve(seed * 7919 + 1, speed_radps, noise_ut, rho);
        for axis in 0..3 {
            let error = report.calibration.offset_ut[axis] - OFFSET_UT[axis];
            let z = error / report.std_errors.offset_ut[axis];
            square += z * z / 3.0;
        }
        independent += report.effective_samples;
    }
    (math::sqrt(square / LOGS as f64), independent / LOGS as f64)
}

#[test]
fn correlated_noise_is_seen_where_sampling_is_uneven() {
    // Of 1000 samples with a correlation of 0.9, 53 are independent.
    for speed_radps in [1.5, 2.5] {
        let (z, independent) = honesty(speed_radps, 0.5, 0.9);
        assert!((0.4..1.3).contains(&z), "{speed_radps} rad/s: {z}");
        assert!((25.0..100.0).contains(&independent), "{speed_radps} rad/s: {independent}");
    }
}

#[test]
fn white_noise_is_white_where_sampling_is_uneven() {
    for noise_ut in [0.05, 0.5] {
        let (z, independent) = honesty(2.0, noise_ut, 0.0);
        assert!((0.75..1.25).contains(&z), "{noise_ut} uT: {z}");
        assert!((850.0..=1000.0).contains(&independent), "{noise_ut} uT: {independent}");
    }
}

#[test]
fn the_same_noise_is_accepted_white_and_refused_with_a_long_memory() {
    let accepted = |rho| (0..10).filter(|seed| solve(seed * 31 + 5, 2.0, 1.2, rho).0).count();
    assert_eq!(accepted(0.0), 10);
    assert_eq!(accepted(0.95), 0);
}
