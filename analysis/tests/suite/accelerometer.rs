//! An accelerometer that is not calibrated: its own fit corrects it, and the rotation and the heading with it.

use ironout_analysis::{Options, Table, fit};
use ironout_simulation::{Log, World, WorldOptions};
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// A log whose accelerometer has these offsets and gains, and a hand that shakes it by so much, m/s².
fn log(seed: u64, offset: [f64; 3], gain: [f64; 3], shaken: f64) -> Log {
    let mut log = World::new(WorldOptions { seed, ..WorldOptions::default() }).run();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for (axis, name) in ["ax_mps2", "ay_mps2", "az_mps2"].into_iter().enumerate() {
        let position = log.position(name).unwrap();
        let mut shake = 0.0;
        for value in &mut log.columns[position] {
            shake = 0.9 * shake + 0.75 * shaken * rng.random_range(-1.0..1.0);
            *value = offset[axis] + gain[axis] * (*value + shake);
        }
    }
    log
}

/// The full matrix of a fit, and the dip's spread that it leaves.
fn fitted(log: &Log) -> ironout_analysis::Fitted {
    fit(&Table::from_columns(log.named()).unwrap(), &Options::default()).unwrap()
}

/// By how much the one matrix turns a field against the other, degrees.
fn turned_deg(one: &ironout_analysis::Fitted, other: &ironout_analysis::Fitted) -> f64 {
    let matrix = |fitted: &ironout_analysis::Fitted| {
        let rows = fitted.solution.as_ref().unwrap().calibration.matrix;
        Matrix3::from_fn(|i, j| rows[i][j])
    };
    let between = matrix(one) * matrix(other).try_inverse().unwrap();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    axes.iter().map(|axis| (between * axis).angle(axis).to_degrees()).fold(0.0, f64::max)
}

#[test]
fn offsets_and_gains_of_an_accelerometer_are_found_and_turn_nothing() {
    for seed in 1..=4 {
        let (offset, gain) = ([0.5, -0.3, 0.8], [1.02, 0.98, 0.95]);
        let (right, wrong) =
            (fitted(&log(seed, [0.0; 3], [1.0; 3], 0.0)), fitted(&log(seed, offset, gain, 0.0)));
        assert!(right.accelerometer.is_none(), "seed {seed}: {:?}", right.accelerometer);
        let found = wrong.accelerometer.expect("there is something to correct");
        for axis in 0..3 {
            assert!((found.offset_mps2[axis] - offset[axis]).abs() < 0.02, "seed {seed}: {found:?}");
            assert!((found.matrix[axis][axis] * gain[axis] - 1.0).abs() < 0.003, "seed {seed}: {found:?}");
        }
        assert!(found.after_mps2 < 0.4 * found.before_mps2, "seed {seed}: {found:?}");
        let turned = turned_deg(&wrong, &right);
        assert!(turned < 0.3, "seed {seed}: {turned}");
        let [of_wrong, of_right] = [&wrong, &right].map(|fitted| fitted.heading_error_deg.unwrap());
        assert!((of_wrong / of_right - 1.0).abs() < 0.2, "seed {seed}: {of_wrong} {of_right}");
    }
}

#[test]
fn a_hand_that_shakes_is_no_error_of_the_accelerometer() {
    for seed in 1..=4 {
        let found = fitted(&log(seed, [0.0; 3], [1.0; 3], 3.0)).accelerometer;
        assert!(found.is_none(), "seed {seed}: {found:?}");
    }
}
