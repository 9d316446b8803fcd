//! Smooth attitude in closed form, so that a world can be asked for any instant.

use crate::paths::{self, Path};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// How the board is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Tumbling that carries the field over the whole sphere of body directions.
    Sphere,
    /// The field stays in a cap of the sphere with this fraction of its area (0..1).
    Cap(f64),
    /// Level turns with a wobble of half a degree.
    Planar,
    /// The sphere by hand: moves with rests between them, tremor, and the lever arm's accelerations.
    Hand,
    /// On the bench.
    Rest,
    /// Irregular tumbling, fast and slow by turns.
    Tumbling,
    /// Figures of eight in the air, their plane turning slowly.
    Eights,
    /// Waved by hand: smooth, aimless, with the lever arm's accelerations.
    Waving,
    /// On a table: each of six sides down, turned about the vertical, with pauses.
    Table,
    /// Full circles about one axis of the board after the other.
    Rings,
    /// Acrobatic flight: level, with fast rolls and flips.
    Acro,
}

/// A drawn trajectory.
#[derive(Clone, Debug)]
pub(crate) struct Attitude {
    motion: Motion,
    field: Unit<Vector3<f64>>,
    start: [f64; 3],
    frequency_hz: [f64; 3],
    wobble_hz: [f64; 3],
    axis: Matrix3<f64>,
    path: Path,
}

/// A triangle wave between 0 and 1 with rounded corners: equal areas of a cap get equal times.
fn triangle(phase: f64) -> f64 {
    0.5 + (0.995 * phase.sin()).asin() / PI
}

impl Attitude {
    pub(crate) fn draw(motion: Motion, field: Vector3<f64>, rng: &mut ChaCha8Rng) -> Attitude {
        let mut sign = || if rng.random::<bool>() { 1.0 } else { -1.0 };
        let signs = [sign(), sign(), sign()];
        let ranges = [0.12..0.19, 0.07..0.11, 0.04..0.07];
        let start = core::array::from_fn(|_| rng.random_range(0.0..TAU));
        let frequency_hz = core::array::from_fn(|i| signs[i] * rng.random_range(ranges[i].clone()));
        let wobble_hz = core::array::from_fn(|_| rng.random_range(0.05..0.13));
        let angles: [f64; 3] = core::array::from_fn(|_| rng.random_range(0.0..TAU));
        let axis = *Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).matrix();
        let path = match motion {
            Motion::Tumbling
            | Motion::Eights
            | Motion::Waving
            | Motion::Table
            | Motion::Rings
            | Motion::Acro => Path::draw(rng),
            _ => Path::default(),
        };
        Attitude { motion, field: Unit::new_normalize(field), start, frequency_hz, wobble_hz, axis, path }
    }

    /// The path of the hand: 2.5 s of movement, then 1.5 s of rest.
    fn hand_time(t: f64) -> f64 {
        let (period, moving) = (4.0, 2.5);
        let turn = (t / period).floor();
        let x = ((t - turn * period) / moving).clamp(0.0, 1.0);
        (turn + x * x * (3.0 - 2.0 * x)) * 3.0
    }

    fn tumble(&self, t: f64) -> Matrix3<f64> {
        let a: [f64; 3] = core::array::from_fn(|i| {
            self.start[i]
                + TAU * self.frequency_hz[i] * t
                + 0.9 * (TAU * self.wobble_hz[i] * t + self.start[2 - i]).sin()
        });
        *Rotation3::from_euler_angles(a[0], a[1], a[2]).matrix()
    }

    /// Rotation from body to world (north, east, down) at time `t`.
    pub(crate) fn body_to_world(&self, t: f64) -> Matrix3<f64> {
        match self.motion {
            Motion::Sphere => self.tumble(t),
            Motion::Hand => {
                let tremor = 0.004 * (TAU * 5.3 * t + self.start[0]).sin();
                let second = 0.003 * (TAU * 7.9 * t + self.start[1]).sin();
                self.tumble(Self::hand_time(t)) * Rotation3::from_euler_angles(tremor, second, 0.0).matrix()
            }
            Motion::Rest => self.tumble(0.0),
            Motion::Tumbling => paths::tumbling(&self.path, t),
            Motion::Eights => paths::eights(&self.path, t),
            Motion::Waving => paths::waving(&self.path, t),
            Motion::Table => paths::table(&self.path, t),
            Motion::Rings => paths::rings(&self.path, t),
            Motion::Acro => paths::acro(&self.path, t),
            Motion::Planar => {
                let wobble = 0.009 * (TAU * self.wobble_hz[0] * t).sin();
                let second = 0.009 * (TAU * self.wobble_hz[1] * t).sin();
                *Rotation3::from_euler_angles(wobble, second, self.start[0] + TAU * 0.11 * t).matrix()
            }
            Motion::Cap(fraction) => {
                let height = 2.0 * fraction.clamp(1e-3, 0.999) * triangle(TAU * 0.031 * t + self.start[0]);
                let polar = (1.0 - height).clamp(-1.0, 1.0).acos();
                let azimuth = self.start[1] + TAU * 0.21 * self.frequency_hz[0].signum() * t;
                let about = Unit::new_normalize(Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0));
                let to_direction = self.axis * Rotation3::from_axis_angle(&about, polar).matrix();
                let spin = Rotation3::from_axis_angle(
                    &Vector3::z_axis(),
                    self.start[2] + TAU * self.frequency_hz[1] * t,
                );
                let to_field = Rotation3::rotation_between(&Vector3::z(), &self.field)
                    .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI));
                to_field.matrix() * spin.matrix() * to_direction.transpose()
            }
        }
    }

    /// Rate of turn in the body frame at time `t`, rad/s, by central differences of the closed form.
    pub(crate) fn rates(&self, t: f64) -> Vector3<f64> {
        let step = 1e-4;
        let before = self.body_to_world(t - step);
        let after = self.body_to_world(t + step);
        let w = self.body_to_world(t).transpose() * (after - before) / (2.0 * step);
        Vector3::new(w[(2, 1)] - w[(1, 2)], w[(0, 2)] - w[(2, 0)], w[(1, 0)] - w[(0, 1)]) * 0.5
    }

    /// Acceleration of the sensor in the body frame beyond gravity: a 10 cm lever arm where a hand turns the board.
    pub(crate) fn lever_acceleration(&self, t: f64) -> Vector3<f64> {
        if !matches!(self.motion, Motion::Hand | Motion::Waving | Motion::Eights) {
            return Vector3::zeros();
        }
        let lever = Vector3::new(0.1, 0.0, 0.03);
        let step = 2e-3;
        let turn = self.rates(t);
        let angular = (self.rates(t + step) - self.rates(t - step)) / (2.0 * step);
        angular.cross(&lever) + turn.cross(&turn.cross(&lever))
    }
}
