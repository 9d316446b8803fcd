//! A small part of the table of correlated noise: honest errors and no wrong acceptance, however the samples are spaced.

use ironout_host_tests::accuracy::correlated::{Case, Tally, run};

/// Rms of the offset's errors over their standard errors, and no sure calibration that is wrong.
fn hold(what: &str, tally: &Tally) {
    let (z, error) = tally.z_rms();
    assert!(tally.fits * 2 > tally.logs, "{what}: {tally:?}");
    assert!(z <= 1.3 && z > 0.4, "{what}: {z} +- {error}, {tally:?}");
    assert!(tally.wrong * 100 <= tally.sure, "{what}: {tally:?}");
}

#[test]
fn a_chip_of_75_hz_read_at_50_hz() {
    for speed_radps in [1.0, 2.5] {
        let tally = run(&Case::polled(speed_radps), 0..40);
        hold(&format!("{speed_radps} rad/s"), &tally);
        // Of samples with a correlation of 0.9, one in 19 is independent.
        assert!((0.03..0.08).contains(&tally.share()), "{speed_radps} rad/s: {tally:?}");
    }
}

#[test]
fn a_shaken_board_does_not_look_like_white_noise() {
    hold("shaken", &run(&Case { shake_deg: 0.3, ..Case::polled(1.0) }, 0..40));
}

#[test]
fn slow_noise_under_white_noise_is_seen() {
    for (rho, samples) in [(0.9, 1000), (0.97, 4000)] {
        let mixed = Case { white: 0.5, rho, samples, ..Case::even(50.0, 0.0, 1.0, rho) };
        let tally = run(&mixed, 0..30);
        let (z, _) = tally.z_rms();
        assert!(z < 1.7, "half {rho}: {z} {tally:?}");
    }
}

#[test]
fn whatever_the_rate_the_jitter_the_speed_and_the_memory() {
    for (rate_hz, speed_radps) in [(10.0, 0.3), (25.0, 3.0), (50.0, 1.0), (100.0, 2.0)] {
        for jitter_s in [0.0, 0.02] {
            for rho in [0.0, 0.5, 0.95] {
                let case = Case::even(rate_hz, jitter_s, speed_radps, rho);
                hold(&format!("{case:?}"), &run(&case, 100..125));
            }
        }
    }
}

#[test]
fn white_noise_loses_nothing() {
    for jitter_s in [0.0, 0.02] {
        let tally = run(&Case::even(50.0, jitter_s, 2.0, 0.0), 0..40);
        assert!(tally.share() > 0.9, "{tally:?}");
        let (z, _) = tally.z_rms();
        assert!((0.75..1.25).contains(&z), "{z} {tally:?}");
    }
}
