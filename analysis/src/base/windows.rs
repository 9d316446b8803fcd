//! Short stretches of a log in which the gyro sums up how the board turned.

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

/// A longer pause between samples ends a window, s ...
const PAUSE_S: f64 = 0.3;
/// ... and so does a turn between two of them that is not summed up well, rad.
const MOST_RAD: f64 = 0.25;
/// What a turn follows to first order: the gyro's bias (3), its gains and axes (9, by columns).
pub const GYRO: usize = 12;

/// One sample of a window.
#[derive(Clone)]
pub struct Stop {
    /// The sample.
    pub sample: usize,
    /// From the board's axes there to its axes at the window's first sample.
    pub turn: Rotation3<f64>,
    /// `∫ turn · ∂ω/∂gyro dt` up to there: a vector `v` there follows as `−[turn v]ₓ follows`.
    pub follows: SMatrix<f64, 3, GYRO>,
}

/// The windows of a log, one after the other, each of `length_s` with its first sample, its last and `between` more, evenly in time. `rate`
/// is the gyro's, rad/s, in the axes of the field.
pub fn windows(time: &[f64], rate: &[Option<Vector3<f64>>], length_s: f64, between: usize) -> Vec<Vec<Stop>> {
    let mut list = Vec::new();
    let start = |sample| Stop { sample, turn: Rotation3::identity(), follows: SMatrix::zeros() };
    let mut at = start(0);
    let mut window = vec![at.clone()];
    let pace_s = length_s / (between + 1) as f64;
    for next in 1..time.len() {
        let pause_s = time[next] - time[next - 1];
        let mean = rate[next - 1].zip(rate[next]).map(|(one, two)| 0.5 * (one + two));
        let sound =
            |mean: &Vector3<f64>| pause_s > 0.0 && pause_s < PAUSE_S && mean.norm() * pause_s < MOST_RAD;
        let Some(mean) = mean.filter(sound) else {
            at = start(next);
            window = vec![at.clone()];
            continue;
        };
        let turn: Matrix3<f64> = *at.turn.matrix() * pause_s;
        for axis in 0..3 {
            for from in 0..3 {
                let entry = turn[(axis, from)];
                at.follows[(axis, from)] += entry;
                (0..3).for_each(|by| at.follows[(axis, 3 + 3 * by + from)] += entry * mean[by]);
            }
        }
        at.turn *= Rotation3::new(mean * pause_s);
        at.sample = next;
        let since_s = time[next] - time[window[0].sample];
        if since_s >= length_s {
            window.push(std::mem::replace(&mut at, start(next)));
            list.push(std::mem::replace(&mut window, vec![at.clone()]));
        } else if since_s >= pace_s * window.len() as f64 {
            window.push(at.clone());
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_of_the_world_stands_still_in_each_window() {
        let rate = Vector3::new(0.3, -0.7, 0.2);
        let time: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.02).collect();
        let list = windows(&time, &vec![Some(rate); 1000], 2.0, 3);
        assert_eq!((list.len(), list[0].len()), (9, 5));
        let world = Vector3::new(20.0, 5.0, 40.0);
        let seen = |sample: usize| Rotation3::new(-rate * time[sample]) * world;
        for window in &list {
            for stop in window {
                let there = stop.turn * seen(stop.sample);
                assert!((there - seen(window[0].sample)).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn a_turn_follows_the_gyros_errors_as_it_says() {
        let time: Vec<f64> = (0..101).map(|i| f64::from(i) * 0.02).collect();
        let rate = |i: usize| Vector3::new((time[i]).sin(), 0.5, (2.0 * time[i]).cos());
        let (bias, gain) =
            (Vector3::new(1e-5, -2e-5, 3e-5), Matrix3::from_fn(|i, j| 1e-5 * (i + 2 * j) as f64));
        let off = |v: Vector3<f64>| v + bias + gain * v;
        let right: Vec<_> = (0..101).map(|i| Some(rate(i))).collect();
        let wrong: Vec<_> = (0..101).map(|i| Some(off(rate(i)))).collect();
        let last = |rate: &[Option<Vector3<f64>>]| windows(&time, rate, 1.9, 0)[0][1].clone();
        let (one, two) = (last(&right), last(&wrong));
        let v = Vector3::new(30.0, -10.0, 40.0);
        let mut gyro = nalgebra::SVector::<f64, GYRO>::zeros();
        gyro.fixed_rows_mut::<3>(0).copy_from(&bias);
        (0..3).for_each(|by| (0..3).for_each(|from| gyro[3 + 3 * by + from] = gain[(from, by)]));
        let expected = -(one.turn * v).cross_matrix() * one.follows * gyro;
        let seen = two.turn * v - one.turn * v;
        assert!((expected - seen).norm() < 2e-2 * seen.norm(), "{expected} {seen}");
    }
}
