//! How people and machines turn a board, in closed form.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Drawn numbers of a path, shares from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    shares: [f64; 24],
}

impl Default for Path {
    fn default() -> Self {
        Path { shares: [0.5; 24] }
    }
}

impl Path {
    pub(crate) fn draw(rng: &mut ChaCha8Rng) -> Path {
        Path { shares: core::array::from_fn(|_| rng.random()) }
    }

    /// The drawn number `index` between two ends.
    fn between(&self, index: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.shares[index % self.shares.len()]
    }

    fn phase(&self, index: usize) -> f64 {
        TAU * self.shares[index % self.shares.len()]
    }

    /// A number of its own for each of many turns of one kind.
    fn of_turn(&self, turn: f64, kind: usize) -> f64 {
        let mixed = (turn * 0.618_033_988_75 + self.shares[kind % self.shares.len()] * 7.0).fract();
        (mixed * 97.0 + self.shares[(kind + 5) % self.shares.len()]).fract()
    }
}

/// From 0 to 1 with rest at both ends.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
}

fn euler(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
    *Rotation3::from_euler_angles(roll, pitch, yaw).matrix()
}

/// Irregular tumbling, fast and slow by turns.
pub(crate) fn tumbling(path: &Path, t: f64) -> Matrix3<f64> {
    let angle = |i: usize| {
        let rate = path.between(i, 0.06, 0.35);
        let wave = path.between(i + 3, 0.03, 0.12);
        path.phase(i + 6) + TAU * rate * t + 1.8 * (TAU * wave * t + path.phase(i + 9)).sin()
    };
    euler(angle(0), angle(1), angle(2))
}

/// Figures of eight, their plane turning slowly.
pub(crate) fn eights(path: &Path, t: f64) -> Matrix3<f64> {
    let rate = path.between(0, 0.25, 0.7);
    let (wide, high) = (path.between(1, 0.9, 1.5), path.between(2, 0.5, 1.1));
    let roll = wide * (TAU * rate * t + path.phase(3)).sin();
    let pitch = high * (2.0 * TAU * rate * t + path.phase(4)).sin();
    let turning = euler(
        path.phase(5) + TAU * path.between(6, 0.01, 0.03) * t,
        1.2 * (TAU * path.between(7, 0.008, 0.02) * t + path.phase(8)).sin(),
        path.phase(9) + TAU * path.between(10, 0.02, 0.06) * t,
    );
    turning * euler(roll, pitch, 0.3 * (TAU * 0.9 * rate * t).sin())
}

/// Waved by hand: sums of incommensurate swings about an attitude that wanders over the sphere.
pub(crate) fn waving(path: &Path, t: f64) -> Matrix3<f64> {
    let swing = |axis: usize| -> f64 {
        (0..3)
            .map(|k| {
                let at = 3 * axis + k;
                let rate = path.between(at, 0.12, 0.45) * (k + 1) as f64;
                (0.7 / (k + 1) as f64) * (TAU * rate * t + path.phase(at + 9)).sin()
            })
            .sum()
    };
    let wander = euler(
        path.phase(18) + TAU * path.between(19, 0.015, 0.05) * t,
        path.phase(20) + TAU * path.between(21, 0.01, 0.04) * t,
        path.phase(22) + TAU * path.between(23, 0.02, 0.06) * t,
    );
    wander * euler(swing(0), swing(1), swing(2))
}

/// Attitudes of a board with each of its sides down.
fn side(index: usize) -> Matrix3<f64> {
    match index % 6 {
        0 => euler(0.0, 0.0, 0.0),
        1 => euler(FRAC_PI_2, 0.0, 0.0),
        2 => euler(0.0, FRAC_PI_2, 0.0),
        3 => euler(2.0 * FRAC_PI_2, 0.0, 0.0),
        4 => euler(-FRAC_PI_2, 0.0, 0.0),
        _ => euler(0.0, -FRAC_PI_2, 0.0),
    }
}

/// From one attitude to the next the short way.
fn blend(from: Matrix3<f64>, to: Matrix3<f64>, share: f64) -> Matrix3<f64> {
    let turn = Rotation3::from_matrix_unchecked(from.transpose() * to);
    match turn.axis_angle() {
        Some((axis, angle)) => from * Rotation3::from_axis_angle(&axis, angle * share).matrix(),
        None => from,
    }
}

/// On a table: a side down, a full turn in four steps with pauses, the next side; tilted by some degrees as by hand.
pub(crate) fn table(path: &Path, t: f64) -> Matrix3<f64> {
    let period = path.between(0, 6.0, 12.0);
    let turn = (t / period).floor();
    let phase = t / period - turn;
    let place = turn as usize;
    let tilted = |place: usize| {
        let lean = |k: usize| 0.35 * (path.of_turn(place as f64, k) - 0.5);
        euler(lean(1), lean(2), 0.0) * side(place + (path.between(3, 0.0, 6.0) as usize))
    };
    // Four quarter turns in the first 80 %, then over to the next side.
    let steps = (phase / 0.2).min(4.0);
    let quarter = steps.floor() + smooth((steps - steps.floor()) / 0.6);
    let yaw = path.phase(4) + 0.7 * turn + FRAC_PI_2 * quarter.min(4.0);
    let over = smooth((phase - 0.8) / 0.2);
    let next_yaw = path.phase(4) + 0.7 * (turn + 1.0) + 4.0 * FRAC_PI_2;
    let tremor = euler(
        0.004 * (TAU * 6.1 * t + path.phase(5)).sin(),
        0.004 * (TAU * 7.3 * t + path.phase(6)).sin(),
        0.0,
    );
    let from = euler(0.0, 0.0, yaw) * tilted(place);
    let to = euler(0.0, 0.0, next_yaw) * tilted(place + 1);
    blend(from, to, over) * tremor
}

/// Full circles about one axis of the board after the other, the axes spread over the sphere.
pub(crate) fn rings(path: &Path, t: f64) -> Matrix3<f64> {
    let period = path.between(0, 5.0, 9.0);
    let turn = (t / period).floor();
    let phase = t / period - turn;
    let axis = |turn: f64| {
        let z = 2.0 * path.of_turn(turn, 1) - 1.0;
        let angle = TAU * path.of_turn(turn, 2);
        let r = (1.0 - z * z).sqrt();
        Unit::new_normalize(Vector3::new(r * angle.cos(), r * angle.sin(), z))
    };
    let start = |turn: f64| {
        euler(TAU * path.of_turn(turn, 3), 1.4 * (path.of_turn(turn, 4) - 0.5), TAU * path.of_turn(turn, 5))
    };
    let circle = TAU * smooth(phase / 0.85);
    let ring = start(turn) * Rotation3::from_axis_angle(&axis(turn), circle).matrix();
    blend(ring, start(turn + 1.0), smooth((phase - 0.85) / 0.15))
}

/// Acrobatic flight: level with banked turns, and every few seconds a roll or a flip.
pub(crate) fn acro(path: &Path, t: f64) -> Matrix3<f64> {
    let period = path.between(0, 2.0, 4.0);
    let turn = (t / period).floor();
    let phase = t / period - turn;
    let quick = smooth(phase / path.between(1, 0.35, 0.6));
    let which = path.of_turn(turn, 2);
    let whole = |yes: bool| if yes { TAU * quick } else { 0.0 };
    // Some stop on their back, and the next one comes round.
    let inverted = |turn: f64| if path.of_turn(turn, 7) > 0.7 { 2.0 * FRAC_PI_2 } else { 0.0 };
    let half = inverted(turn) + (inverted(turn + 1.0) - inverted(turn)) * quick;
    let bank = 0.7 * (TAU * path.between(3, 0.08, 0.2) * t + path.phase(4)).sin();
    let nose = 0.5 * (TAU * path.between(5, 0.05, 0.15) * t + path.phase(6)).sin();
    let roll = bank + half + whole(which < 0.4);
    let pitch = nose + whole((0.4..0.75).contains(&which));
    let yaw = path.phase(8) + TAU * path.between(9, 0.03, 0.09) * t;
    euler(0.0, 0.0, yaw) * euler(roll, 0.0, 0.0) * euler(0.0, pitch, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Every path turns smoothly, and carries a direction over most of the sphere.
    #[test]
    fn paths_are_rotations_without_jumps_that_cover_the_sphere() {
        for (name, path_of) in [
            ("tumbling", tumbling as fn(&Path, f64) -> Matrix3<f64>),
            ("eights", eights),
            ("waving", waving),
            ("table", table),
            ("rings", rings),
            ("acro", acro),
        ] {
            for seed in 0..5 {
                let path = Path::draw(&mut ChaCha8Rng::seed_from_u64(seed));
                let mut octants = [false; 8];
                let mut last = path_of(&path, 0.0);
                for step in 1..20_000 {
                    let now = path_of(&path, f64::from(step) * 0.005);
                    assert!((now * now.transpose() - Matrix3::identity()).norm() < 1e-9, "{name} {seed}");
                    // 0.2 rad in 5 ms would be 40 rad/s.
                    assert!(
                        (now - last).norm() < 0.2,
                        "{name} {seed} jumps at {step}: {}",
                        (now - last).norm()
                    );
                    let down = now.transpose() * Vector3::new(0.5, 0.0, 0.87);
                    let bit = |value: f64| usize::from(value > 0.0);
                    octants[bit(down.x) + 2 * bit(down.y) + 4 * bit(down.z)] = true;
                    last = now;
                }
                let seen = octants.iter().filter(|seen| **seen).count();
                assert!(seen >= 7, "{name} {seed}: {seen} octants");
            }
        }
    }
}
