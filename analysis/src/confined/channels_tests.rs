use super::*;
use crate::confined::log::{Pose, Row};
use nalgebra::{Rotation3, Unit};

/// A boat without noise, and its true parameters.
fn boat() -> (Log, State) {
    let state = State {
        offset_ut: Vector3::new(20.0, -30.0, 10.0),
        matrix: Matrix3::new(1.05, 0.02, -0.03, 0.04, 0.97, 0.01, -0.02, 0.03, 1.01),
        field_ut: 50.0,
        vertical_ut: 43.0,
        gyro: Default::default(),
        delay_s: 0.0,
        zero: Vector3::zeros(),
        tilt: 0.0,
        yaw: Some(0.2),
        yaw_error: [0.01, -0.02, 0.015, 0.005],
        lean: Vector3::new(0.004, -0.002, 0.006),
        attitude_delay_s: 0.0,
        effects: vec![(Vector3::new(0.5, -0.3, 0.8), Vector3::new(0.002, -0.001, 0.0005))],
    };
    let inverse = state.matrix.try_inverse().expect("invertible");
    let at = |t: f64| Rotation3::from_euler_angles(0.2 * (1.3 * t).sin(), 0.15 * (0.9 * t).cos(), 0.3 * t);
    let world = Vector3::new((50.0_f64.powi(2) - 43.0_f64.powi(2)).sqrt(), 0.0, 43.0);
    let time_s: Vec<f64> = (0..2000).map(|i| 0.02 * f64::from(i)).collect();
    let rows = (time_s.iter())
        .map(|&t| {
            let here = at(t).inverse();
            let step = at(t - 1e-4).inverse() * at(t + 1e-4);
            let acts = [(0.7 * t).sin(), 0.0, 0.0, 0.0];
            Row {
                measured_ut: state.offset_ut + acts[0] * state.effects[0].0 + inverse * (here * world),
                acts,
                down: Some(here * Vector3::z()),
                rate_radps: Some(step.scaled_axis() / 2e-4),
            }
        })
        .collect();
    let lean = Rotation3::new(state.lean).inverse();
    let axes = |t: f64| {
        let (sine, cosine) = (0.3 * t).sin_cos();
        let shapes = [sine, cosine, 2.0 * sine * cosine, cosine * cosine - sine * sine];
        let by_heading: f64 = state.yaw_error.iter().zip(shapes).map(|(error, shape)| error * shape).sum();
        let by_effect = (0.7 * t).sin() * state.effects[0].1.dot(&Vector3::new(sine, cosine, 1.0));
        let angle = state.yaw.unwrap_or(0.0) + by_heading + by_effect;
        let world = Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::z()), -angle);
        (lean * at(t).inverse() * world, (sine, cosine))
    };
    let poses = (time_s.iter())
        .map(|&t| {
            let ((one, _), (two, _)) = (axes(t - 1e-4), axes(t + 1e-4));
            let (now, heading) = axes(t);
            Some(Pose { axes: *now.matrix(), per_s: (two.matrix() - one.matrix()) / 2e-4, heading })
        })
        .collect();
    let (mean_down, effects) = (Vector3::z(), vec![0.5]);
    (
        Log {
            time_s,
            rows,
            mean_down,
            stride: 1,
            poses,
            mean_pose_down: mean_down,
            from_north: true,
            effects,
        },
        state,
    )
}

#[test]
fn true_parameters_leave_nothing() {
    let (log, state) = boat();
    for channel in Channel::ALL {
        let sums = Rows::of(channel, &Seen::of(&log, &state), &Share::AS_SHOWN).sums(1.0, state.parameters());
        assert!(sums.rows > 100 && sums.rms_ut < 2e-3, "{channel:?}: {} rows, {}", sums.rows, sums.rms_ut);
    }
}

#[test]
fn residuals_follow_the_parameters_as_their_derivatives_say() {
    let (log, state) = boat();
    for channel in Channel::ALL {
        let before = Rows::of(channel, &Seen::of(&log, &state), &Share::AS_SHOWN);
        for parameter in 0..state.parameters() {
            let mut step = [0.0; COLUMNS];
            step[parameter] = 1e-5;
            let moved = state.stepped(&step);
            let after = Rows::of(channel, &Seen::of(&log, &moved), &Share::AS_SHOWN);
            let (mut off, mut size) = (0.0_f64, 1e-3_f64);
            for ((_, derivative, one), (_, _, two)) in before.list.iter().zip(&after.list) {
                off = off.max((two - one - 1e-5 * derivative[parameter]).abs() / 1e-5);
                size = size.max(derivative[parameter].abs());
            }
            assert!(off < 0.02 * size, "{channel:?} {parameter}: {off} of {size}");
        }
    }
}
