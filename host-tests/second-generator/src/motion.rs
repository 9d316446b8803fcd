//! Motion of a rigid body: orientation, angular rate and specific force at any time.
//!
//! Body frame x forward, y right, z down; world frame NED.

use crate::linalg::{
    Quat, Vec3, add_scaled, cross, quat_from_vector, quat_inverse, quat_mul, quat_to_vector, scale, sub,
    to_body, to_ned,
};
use crate::random::{Source, chance, direction, log_uniform, orientation, sign, uniform};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Gravity in NED, m/s².
pub const GRAVITY: Vec3 = [0.0, 0.0, 9.806_65];
const X: Vec3 = [1.0, 0.0, 0.0];
const Y: Vec3 = [0.0, 1.0, 0.0];
const Z: Vec3 = [0.0, 0.0, 1.0];

/// Manner in which the body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Figure-eights in a hand, with the sensor turned over and over.
    FigureEight,
    /// Slow tumble about three axes.
    Tumble,
    /// Quick turns by a hand from one rest to the next.
    JerkyHand,
    /// Machine that turns about two axes at constant rates.
    TwoAxisMachine,
    /// Drone with flips, rolls and inverted flight.
    Aerobatic,
    /// Level car that turns at corners.
    Car,
    /// Boat that rocks by 10° to 15° and turns slowly.
    Boat,
    /// Ordinary drone flight, tilted by up to 25°.
    Flight,
    /// Hasty calibration by hand, with few orientations.
    HastyHand,
}

/// Smooth function of time: a start, a constant rate, waves and single turns with smooth ends.
#[derive(Default)]
struct Curve {
    start: f64,
    rate: f64,
    /// Amplitude, angular frequency in rad/s, phase in rad.
    waves: Vec<[f64; 3]>,
    /// Beginning in s, duration in s, size.
    turns: Vec<[f64; 3]>,
}

impl Curve {
    fn at(&self, t: f64) -> f64 {
        let waves: f64 = self.waves.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum();
        let turns: f64 = self.turns.iter().map(|[from, d, size]| size * smooth_step((t - from) / d)).sum();
        self.start + self.rate * t + waves + turns
    }

    fn rate(start: f64, rate: f64) -> Self {
        Curve { start, rate, ..Curve::default() }
    }

    /// Adds `count` waves whose amplitudes sum to `amplitude`, with periods in s between the limits.
    fn with_waves(mut self, rng: &mut Source, count: usize, amplitude: f64, periods: [f64; 2]) -> Self {
        let shares: Vec<f64> = (0..count).map(|_| uniform(rng, 0.5, 1.5)).collect();
        let total: f64 = shares.iter().sum();
        for share in shares {
            let period = log_uniform(rng, periods[0], periods[1]);
            self.waves.push([amplitude * share / total, TAU / period, uniform(rng, 0.0, TAU)]);
        }
        self
    }

    /// Adds turns all along the log: pauses and durations in s, sizes from `size`.
    fn with_turns(
        mut self,
        rng: &mut Source,
        length: f64,
        pauses: [f64; 2],
        durations: [f64; 2],
        mut size: impl FnMut(&mut Source) -> f64,
    ) -> Self {
        let mut t = uniform(rng, 0.0, pauses[1]);
        while t < length {
            let duration = uniform(rng, durations[0], durations[1]);
            let turn = size(rng);
            self.turns.push([t, duration, turn]);
            t += duration + uniform(rng, pauses[0], pauses[1]);
        }
        self
    }
}

/// From 0 to 1 with zero velocity and acceleration at both ends (minimum jerk).
fn smooth_step(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// One turn of a hand from a rest to the next.
struct Turn {
    begin_s: f64,
    duration_s: f64,
    from: Quat,
    /// Rotation vector in the body frame, rad.
    by: Vec3,
}

enum Attitude {
    /// Turns about fixed axes, one inside the other, the outermost first.
    Chain(Vec<(Vec3, Curve)>),
    Turns(Vec<Turn>),
}

enum Drive {
    /// Velocity of the hand in NED, m/s.
    Hand([Curve; 3]),
    /// Speed along the car's x axis, m/s.
    Car(Curve),
    /// Thrust per mass along -z of the body, m/s², or the climb's acceleration at held altitude; drag in 1/s.
    Air { curve: Curve, hold: bool, drag: f64 },
}

/// One drawn motion.
pub struct Motion {
    attitude: Attitude,
    drive: Drive,
    /// From the point that `drive` moves to the accelerometer, body frame, m.
    arm: Vec3,
}

impl Motion {
    /// Draws a motion of a style for a log of a length in s.
    pub fn draw(style: Style, rng: &mut Source, length: f64) -> Self {
        let mut drive = Drive::Hand(Default::default());
        let mut arm = scale(log_uniform(rng, 0.02, 0.12), direction(rng));
        let tempo = log_uniform(rng, 0.7, 1.4);
        let start = uniform(rng, 0.0, TAU);
        let attitude = match style {
            Style::FigureEight => {
                drive = sway(rng, 0.15);
                let period = 2.5 * tempo;
                let (slow, quick) = ([3.0 * period, 9.0 * period], [0.9 * period, 1.1 * period]);
                let eight = [0.5 * period, 0.55 * period];
                let yaw_rate = sign(rng) * TAU / uniform(rng, 12.0, 30.0);
                let yaw = Curve::rate(start, yaw_rate).with_waves(rng, 2, 0.8, slow);
                let pitch =
                    Curve::rate(0.0, 0.0).with_waves(rng, 1, 0.8, eight).with_waves(rng, 2, 1.0, slow);
                let roll_rate = sign(rng) * TAU / uniform(rng, 15.0, 40.0);
                let roll = Curve::rate(start, roll_rate)
                    .with_waves(rng, 1, 2.2, quick)
                    .with_waves(rng, 2, 0.6, slow);
                Attitude::Chain(vec![(Z, yaw), (Y, pitch), (X, roll)])
            }
            Style::Tumble => {
                drive = sway(rng, 0.05);
                let period = (length / 7.0).clamp(4.0, 12.0) * tempo;
                let mut axes = || {
                    let rate = sign(rng) * TAU / (period * uniform(rng, 0.7, 1.6));
                    (direction(rng), Curve::rate(start, rate).with_waves(rng, 3, 0.9, [period, 4.0 * period]))
                };
                Attitude::Chain(vec![axes(), axes(), axes()])
            }
            Style::JerkyHand => Attitude::Turns(hand_turns(rng, length, [0.3, 1.2], [0.1, 1.2], [0.7, 2.8])),
            Style::HastyHand => {
                drive = sway(rng, 0.3);
                Attitude::Turns(hand_turns(rng, length, [0.3, 0.7], [0.0, 0.15], [0.8, 2.4]))
            }
            Style::TwoAxisMachine => {
                // The outer frame turns once or a few times; the inner one makes many turns meanwhile.
                let outer = TAU * uniform(rng, 1.0, 4.0) / length;
                let inner = TAU / (length / 12.0).clamp(2.0, 12.0) / tempo;
                let tilt = FRAC_PI_2 + uniform(rng, -0.25, 0.25);
                Attitude::Chain(vec![
                    (direction(rng), Curve::rate(start, sign(rng) * outer)),
                    (X, Curve::rate(tilt, 0.0)),
                    (Z, Curve::rate(0.0, sign(rng) * inner)),
                ])
            }
            Style::Aerobatic => {
                let flip = |rng: &mut Source| sign(rng) * if chance(rng, 0.5) { TAU } else { PI };
                let yaw = Curve::rate(start, 0.0).with_turns(rng, length, [0.5, 3.0], [1.0, 3.0], |rng| {
                    sign(rng) * uniform(rng, 0.5, 3.0)
                });
                let loops = Curve::default().with_waves(rng, 3, 0.7, [1.5, 8.0]);
                let pitch = loops.with_turns(rng, length, [2.0, 7.0], [1.2, 2.5], |rng| sign(rng) * TAU);
                let rolls = Curve::default().with_waves(rng, 3, 0.7, [1.5, 8.0]);
                let roll = rolls.with_turns(rng, length, [1.0, 5.0], [0.8, 1.8], flip);
                let curve = Curve::rate(11.0, 0.0).with_waves(rng, 4, 7.0, [0.8, 6.0]);
                drive = Drive::Air { curve, hold: false, drag: uniform(rng, 0.3, 0.6) };
                Attitude::Chain(vec![(Z, yaw), (Y, pitch), (X, roll)])
            }
            Style::Flight => {
                let turn = |rng: &mut Source| sign(rng) * uniform(rng, 0.5, 3.5);
                let yaw = Curve::rate(start, 0.0).with_waves(rng, 2, 0.15, [3.0, 20.0]);
                let yaw = yaw.with_turns(rng, length, [1.0, 8.0], [1.5, 5.0], turn);
                let most = uniform(rng, 15.0, 25.0_f64).to_radians();
                let mut tilt = || Curve::default().with_waves(rng, 5, most, [1.5, 12.0]);
                let (pitch, roll) = (tilt(), tilt());
                let curve = Curve::default().with_waves(rng, 4, 2.0, [2.0, 10.0]);
                drive = Drive::Air { curve, hold: true, drag: uniform(rng, 0.3, 0.6) };
                Attitude::Chain(vec![(Z, yaw), (Y, pitch), (X, roll)])
            }
            Style::Car => {
                let corner = |rng: &mut Source| sign(rng) * FRAC_PI_2 * uniform(rng, 0.5, 1.1);
                let yaw = Curve::rate(start, 0.0).with_waves(rng, 2, 0.15, [10.0, 40.0]);
                let yaw = yaw.with_turns(rng, length, [1.0, 9.0], [4.0, 8.0], corner);
                let mut tilt = |degrees: f64| {
                    let slope = Curve::default().with_waves(rng, 2, degrees.to_radians(), [10.0, 60.0]);
                    slope.with_waves(rng, 3, 0.01, [0.4, 1.5])
                };
                let (pitch, roll) = (tilt(3.0), tilt(1.5));
                drive = Drive::Car(Curve::rate(5.0, 0.0).with_waves(rng, 3, 3.5, [10.0, 40.0]));
                arm = add_scaled(arm, 1.0, X);
                Attitude::Chain(vec![(Z, yaw), (Y, pitch), (X, roll)])
            }
            Style::Boat => {
                let rate = sign(rng) * TAU / (length / uniform(rng, 1.5, 4.0)).clamp(20.0, 120.0);
                let yaw = Curve::rate(start, rate).with_waves(rng, 2, 0.2, [5.0, 20.0]);
                let roll_deg = uniform(rng, 10.0, 15.0_f64);
                let roll = Curve::default().with_waves(rng, 3, roll_deg.to_radians(), [3.0, 7.0]);
                let pitch = Curve::default().with_waves(rng, 3, (0.7 * roll_deg).to_radians(), [4.0, 8.0]);
                drive = sway(rng, 0.5);
                arm = scale(uniform(rng, 0.5, 2.5), direction(rng));
                Attitude::Chain(vec![(Z, yaw), (Y, pitch), (X, roll)])
            }
        };
        Motion { attitude, drive, arm }
    }

    /// Orientation at a time in s.
    pub fn orientation(&self, t: f64) -> Quat {
        match &self.attitude {
            Attitude::Chain(axes) => axes.iter().fold([1.0, 0.0, 0.0, 0.0], |q, (axis, angle)| {
                quat_mul(q, quat_from_vector(scale(angle.at(t), *axis)))
            }),
            Attitude::Turns(turns) => {
                let turn = &turns[turns.partition_point(|turn| turn.begin_s <= t).max(1) - 1];
                let part = smooth_step((t - turn.begin_s) / turn.duration_s);
                quat_mul(turn.from, quat_from_vector(scale(part, turn.by)))
            }
        }
    }

    /// Angular rate in the body frame at a time in s, rad/s.
    pub fn angular_rate(&self, t: f64) -> Vec3 {
        let h = 1e-4;
        let turned = quat_mul(quat_inverse(self.orientation(t - h)), self.orientation(t + h));
        scale(0.5 / h, quat_to_vector(turned))
    }

    /// Thrust of a drone per weight at a time in s; `None` for what does not fly.
    pub fn thrust(&self, t: f64) -> Option<f64> {
        match &self.drive {
            Drive::Air { curve, hold: true, .. } => {
                let upright = to_ned(self.orientation(t), Z)[2];
                Some((GRAVITY[2] + curve.at(t)) / upright.max(0.5) / GRAVITY[2])
            }
            Drive::Air { curve, hold: false, .. } => Some(curve.at(t).max(1.0) / GRAVITY[2]),
            _ => None,
        }
    }

    /// What an ideal accelerometer reads at the times in s: the specific force in the body frame, m/s².
    pub fn specific_force(&self, times: &[f64]) -> Vec<Vec3> {
        let h = 1e-3;
        let mut air_velocity = [0.0; 3];
        let mut last = times[0];
        let mut force = Vec::with_capacity(times.len());
        for &t in times {
            let q = self.orientation(t);
            let mut acceleration = scale(0.5 / h, sub(self.velocity(t + h), self.velocity(t - h)));
            if let (Drive::Air { drag, .. }, Some(thrust)) = (&self.drive, self.thrust(t)) {
                // A drone feels only its thrust and the drag of the air.
                let push = to_ned(q, [0.0, 0.0, -thrust * GRAVITY[2]]);
                let flying = add_scaled(add_scaled(GRAVITY, 1.0, push), -drag, air_velocity);
                air_velocity = add_scaled(air_velocity, t - last, flying);
                acceleration = add_scaled(acceleration, 1.0, flying);
            }
            force.push(to_body(q, sub(acceleration, GRAVITY)));
            last = t;
        }
        force
    }

    /// Velocity of the accelerometer in NED, m/s, without that of a drone's centre.
    fn velocity(&self, t: f64) -> Vec3 {
        let q = self.orientation(t);
        let lever = to_ned(q, cross(self.angular_rate(t), self.arm));
        match &self.drive {
            Drive::Hand(curves) => {
                add_scaled(lever, 1.0, [curves[0].at(t), curves[1].at(t), curves[2].at(t)])
            }
            Drive::Car(speed) => add_scaled(lever, speed.at(t).max(0.0), to_ned(q, X)),
            Drive::Air { .. } => lever,
        }
    }
}

/// Hand or hull that sways with a speed in m/s.
fn sway(rng: &mut Source, speed: f64) -> Drive {
    Drive::Hand(std::array::from_fn(|_| Curve::default().with_waves(rng, 3, speed, [1.0, 4.0])))
}

/// Turns from rest to rest: durations and rests in s, angles in rad.
fn hand_turns(
    rng: &mut Source,
    length: f64,
    durations: [f64; 2],
    rests: [f64; 2],
    angles: [f64; 2],
) -> Vec<Turn> {
    let mut turns = Vec::new();
    let mut from = orientation(rng);
    let mut begin_s = 0.3;
    while begin_s < length {
        let duration_s = uniform(rng, durations[0], durations[1]);
        let by = scale(uniform(rng, angles[0], angles[1]), direction(rng));
        turns.push(Turn { begin_s, duration_s, from, by });
        from = quat_mul(from, quat_from_vector(by));
        begin_s += duration_s + uniform(rng, rests[0], rests[1]);
    }
    turns
}
