//! A vehicle's log of hours: of so many samples not each can be used, and the gyro has to be followed all the same.

use ironout_analysis::{Options, Table, fit};
use nalgebra::{Rotation3, Vector3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

const ROWS: usize = 170_000;
const STEP_S: f64 = 0.1;
const OFFSET_UT: [f64; 3] = [14.0, -22.0, 9.0];

/// A boat that goes round and round in waves: columns by name.
fn boat() -> Vec<(&'static str, Vec<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise = |sigma: f64| {
        let sum: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
        sigma * sum
    };
    let at = |t: f64| {
        let roll = 0.08 * (0.71 * t).sin() + 0.04 * (0.43 * t + 1.0).sin();
        let pitch = 0.05 * (0.57 * t).cos();
        let yaw = 0.06 * t + 0.8 * (0.013 * t).sin();
        Rotation3::from_euler_angles(roll, pitch, yaw)
    };
    let field = Vector3::new(23.0, 0.0, 43.3);
    let names = [
        "t_s", "mx_ut", "my_ut", "mz_ut", "ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps",
    ];
    let mut columns: Vec<(&str, Vec<f64>)> =
        names.iter().map(|name| (*name, Vec::with_capacity(ROWS))).collect();
    for row in 0..ROWS {
        let t = row as f64 * STEP_S;
        let back = at(t).inverse();
        let measured = back * field + Vector3::from(OFFSET_UT);
        let force = back * Vector3::new(0.0, 0.0, -9.81);
        let rate = (at(t - 1e-4).inverse() * at(t + 1e-4)).scaled_axis() / 2e-4;
        let values = std::iter::once(t)
            .chain(measured.iter().map(|value| value + noise(0.3)))
            .chain(force.iter().map(|value| value + noise(0.1)))
            .chain(rate.iter().map(|value| value + noise(0.005)));
        columns.iter_mut().zip(values.collect::<Vec<f64>>()).for_each(|(column, value)| column.1.push(value));
    }
    columns
}

#[test]
fn the_gyro_of_a_log_of_hours_is_used_and_the_offset_is_within_its_error() {
    let columns = boat();
    let table = Table::from_columns(columns.iter().map(|(name, values)| (*name, values.as_slice())))
        .expect("the columns of a log");
    let fitted = fit(&table, &Options::default()).expect("no effect was asked for");
    assert!(fitted.accepted && fitted.holds_for.is_some(), "{:?}", fitted.reasons);
    assert!(fitted.reasons.iter().all(|reason| !reason.contains("without a gyro")), "{:?}", fitted.reasons);
    let solution = fitted.solution.expect("accepted");
    for axis in 0..3 {
        let off = (solution.calibration.offset_ut[axis] - OFFSET_UT[axis]).abs();
        let sigma = solution.std_errors.offset_ut[axis];
        assert!(off < 4.0 * sigma && sigma < 3.0, "axis {axis}: off by {off} µT, predicted {sigma} µT");
    }
}
