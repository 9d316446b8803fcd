//! The simulated world keeps its promises: the same seed gives the same log, the sphere is covered, an effect has the
//! strength it was asked for.

use ironout_simulation::{EffectSpec, Log, Motion, World, WorldOptions};

fn log(seed: u64, effects: &[&str], motion: Motion) -> Log {
    let effects = effects.iter().map(|text| EffectSpec::parse(text).expect("known effect")).collect();
    World::new(WorldOptions { seed, effects, motion, ..WorldOptions::default() }).run()
}

/// Largest angle from any direction to the nearest direction of the log, degrees.
fn largest_gap_deg(log: &Log) -> f64 {
    let field = log.truth.field_ut;
    (0..500)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 500.0;
            let angle = f64::from(i) * 2.399_963;
            let d = [(1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z];
            let nearest =
                log.truth.body_field_ut.iter().map(|h| (h[0] * d[0] + h[1] * d[1] + h[2] * d[2]) / field);
            nearest.fold(-1.0, f64::max).clamp(-1.0, 1.0).acos().to_degrees()
        })
        .fold(0.0, f64::max)
}

#[test]
fn the_same_seed_gives_the_same_log_and_another_seed_another() {
    let first = log(5, &["offset:temp_c", "eddy=2"], Motion::Sphere);
    assert_eq!(first.columns, log(5, &["offset:temp_c", "eddy=2"], Motion::Sphere).columns);
    assert_ne!(first.columns, log(6, &["offset:temp_c", "eddy=2"], Motion::Sphere).columns);
}

#[test]
fn tumbling_covers_the_sphere_and_the_magnitude_of_the_true_field_is_constant() {
    for seed in 0..20 {
        let log = log(seed, &[], Motion::Sphere);
        assert!(largest_gap_deg(&log) < 40.0, "seed {seed}: gap {}", largest_gap_deg(&log));
        for h in &log.truth.body_field_ut {
            assert!((h.iter().map(|value| value * value).sum::<f64>().sqrt() - 50.0).abs() < 1e-9);
        }
    }
}

#[test]
fn a_cap_keeps_to_its_share_of_the_sphere() {
    let log = log(3, &[], Motion::Cap(0.25));
    let mean = (0..3).map(|i| log.truth.body_field_ut.iter().map(|h| h[i]).sum::<f64>()).collect::<Vec<_>>();
    let norm = mean.iter().map(|value| value * value).sum::<f64>().sqrt();
    for h in &log.truth.body_field_ut {
        let cosine = h.iter().zip(&mean).map(|(a, b)| a * b).sum::<f64>() / (50.0 * norm);
        // A quarter of the area reaches 60 degrees from the axis; the mean direction is only near that axis.
        assert!(cosine > 0.35, "cosine {cosine}");
    }
}

#[test]
fn rates_turn_the_body_field_as_the_model_says() {
    let world = World::new(WorldOptions::default());
    for i in 0..100 {
        let t = 0.7 * f64::from(i);
        let (h, w) = (world.body_field_ut(t), world.rates_radps(t));
        let (before, after) = (world.body_field_ut(t - 1e-4), world.body_field_ut(t + 1e-4));
        let cross = [w[1] * h[2] - w[2] * h[1], w[2] * h[0] - w[0] * h[2], w[0] * h[1] - w[1] * h[0]];
        for axis in 0..3 {
            let slope = (after[axis] - before[axis]) / 2e-4;
            assert!((slope + cross[axis]).abs() < 1e-4, "t {t}: {slope} against {}", -cross[axis]);
        }
    }
}

#[test]
fn an_offset_shows_in_the_magnitude_with_the_strength_asked_for() {
    // The corrected magnitude with the true matrix carries the noise and the disturbance: 1 + 3² times the noise.
    let log = log(8, &["offset:current_a=3"], Motion::Sphere);
    let effect = &log.truth.effects[0];
    let rms = (effect.coefficients().iter().map(|c| c * c).sum::<f64>() / 3.0).sqrt();
    let current = log.column("current_a").expect("current");
    let mean = current.iter().sum::<f64>() / current.len() as f64;
    let spread =
        (current.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / current.len() as f64).sqrt();
    let ratio = rms * spread / 0.25;
    assert!((2.0..4.5).contains(&ratio), "per axis {ratio} times the noise");
}

#[test]
fn specifications_are_read_and_unknown_ones_list_the_known() {
    let spec = EffectSpec::parse("offset:current_a@delay=2.5").expect("known");
    assert_eq!((spec.id().as_str(), spec.strength), ("offset:current_a@delay", 2.5));
    assert_eq!(EffectSpec::parse("lag=18ms").expect("known").delay_s, Some(0.018));
    for bad in ["wobble", "offset:", "drift=much", "drift=-1", "drift=18ms", "gain:"] {
        let error = EffectSpec::parse(bad).expect_err(bad).to_string();
        assert!(error.contains("effect") || error.contains("strength"), "{error}");
    }
}

#[test]
fn another_recording_is_of_the_same_board_with_other_motion_and_currents() {
    let options = WorldOptions {
        seconds: 10.0,
        effects: vec![EffectSpec::parse("offset:current_a=3").expect("an effect")],
        ..WorldOptions::default()
    };
    let world = World::new(options);
    let (first, second) = (world.recording(1).run(), world.recording(2).run());
    assert_eq!(first.column("mx_ut"), world.run().column("mx_ut"), "the first recording is the world itself");
    assert_eq!(first.truth.hard_iron_ut, second.truth.hard_iron_ut);
    assert_eq!(first.truth.soft_iron, second.truth.soft_iron);
    let coefficients = |log: &Log| log.truth.effects[0].coefficients().to_vec();
    assert_eq!(coefficients(&first), coefficients(&second));
    for column in ["mx_ut", "current_a", "temp_c", "gx_radps"] {
        assert_ne!(first.column(column), second.column(column), "{column}");
    }
    assert_ne!(second.column("mx_ut"), world.recording(3).run().column("mx_ut"));
}
