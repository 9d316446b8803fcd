//! The direction down of a vehicle that drives circles.
//!
//! A vehicle that turns is pushed sideways: the accelerometer then shows a direction down that leans outwards, to one side in a left turn
//! and to the other in a right turn. The mean of both is without it, as far as the speeds were the same.

use crate::math::sqrtf;
use crate::vector::{cross, dot, minus, norm, scaled};

/// The field moves by this much, µT, from one knot to the next.
const KNOT_UT: f32 = 6.0;
/// Knots in a sense of turning, half a circle: fewer are no mean.
const MIN_KNOTS: u16 = 8;
/// Share of the sideways acceleration that the mean of left and right turns still has: the speeds differ by 15 %.
const UNBALANCED: f32 = 0.3;
/// Sideways acceleration over gravity where only one sense of turning was seen, 1σ.
const ONE_SENSE: f32 = 0.1;

/// Direction down, board's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Down {
    /// Unit vector.
    pub direction: [f32; 3],
    /// Its standard error, rad.
    pub error_rad: f32,
}

/// Sums of the specific force at the knots of one sense of turning.
#[derive(Clone, Copy, Debug, Default)]
struct Sense {
    sum: [f32; 3],
    squares: f32,
    knots: u16,
}

impl Sense {
    fn push(&mut self, force: [f32; 3]) {
        self.sum = plus(self.sum, force);
        self.squares += dot(force, force);
        self.knots = self.knots.saturating_add(1);
    }

    /// The mean, and the variance of the mean along each of the two axes that tilts turn it to.
    fn mean(&self) -> Option<([f32; 3], f32)> {
        let n = f32::from(self.knots);
        let mean = scaled(self.sum, 1.0 / n);
        let variance = (self.squares / n - dot(mean, mean)).max(0.0) / (2.0 * n);
        (self.knots >= MIN_KNOTS).then_some((mean, variance))
    }
}

/// Specific forces while the vehicle turns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Forces {
    senses: [Sense; 2],
    /// Sum and number since the last knot.
    open: ([f32; 3], u16),
    /// The last two knots, µT, the newer first, and the number of all.
    knots: [Option<[f32; 3]>; 2],
    count: u16,
    heard: bool,
}

impl Forces {
    /// Takes a reading of the magnetometer, µT, and what a resting accelerometer reads as 9.8 upwards, if there is one.
    pub fn push(&mut self, measured_ut: [f32; 3], force_mps2: Option<[f32; 3]>) {
        if let Some(force) = force_mps2.filter(|force| force.iter().all(|axis| axis.is_finite())) {
            let (sum, count) = self.open;
            self.open = (plus(sum, force), count.saturating_add(1));
            self.heard = true;
        }
        let [Some(last), before] = self.knots else {
            self.knots[0] = Some(measured_ut);
            return;
        };
        // Written so that a NaN is no knot.
        if !(norm(minus(measured_ut, last)) > KNOT_UT) {
            return;
        }
        let (sum, count) = self.open;
        if let (Some(before), true) = (before, count > 0) {
            let force = scaled(sum, 1.0 / f32::from(count));
            // On a circle each chord turns the way the vehicle does.
            let turn = dot(cross(minus(last, before), minus(measured_ut, last)), force);
            let [one, other] = &mut self.senses;
            if turn > 0.0 { one.push(force) } else { other.push(force) }
        }
        self.knots = [Some(measured_ut), Some(last)];
        self.count = self.count.saturating_add(1);
        self.open = ([0.0; 3], 0);
    }

    /// Number of times that the field has moved by 6 µT.
    pub fn count(&self) -> u16 {
        self.count
    }

    /// Whether an accelerometer was heard.
    pub const fn are_heard(&self) -> bool {
        self.heard
    }

    /// The direction down; `None` without an accelerometer or with less than half a circle.
    pub fn down(&self) -> Option<Down> {
        let [one, other] = self.senses.map(|sense| sense.mean());
        let (mean, variance, sideways) = match (one, other) {
            (Some((a, of_a)), Some((b, of_b))) => {
                let half = scaled(minus(a, b), 0.5);
                (scaled(plus(a, b), 0.5), 0.25 * (of_a + of_b), UNBALANCED * norm(half))
            }
            (Some((mean, variance)), None) | (None, Some((mean, variance))) => {
                (mean, variance, ONE_SENSE * norm(mean))
            }
            (None, None) => return None,
        };
        let length = norm(mean);
        let error_rad = sqrtf(variance + sideways * sideways) / length;
        (length > 0.0 && error_rad.is_finite())
            .then(|| Down { direction: scaled(mean, -1.0 / length), error_rad })
    }
}

fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    minus(a, scaled(b, -1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, sin};

    /// Circles with this sideways acceleration, m/s², as many to the right as `right` and to the left as `left`.
    fn driven(right: u32, left: u32, sideways: f32) -> Forces {
        let mut forces = Forces::default();
        for i in 0..1000 * (right + left) {
            let sense = if i < 1000 * right { 1.0 } else { -1.0 };
            let heading = sense * f64::from(i) * 0.006_283_185_307_179_586;
            // Board's axes x forward, y right, z down.
            let field = [20.0 * cos(heading), -20.0 * sin(heading), 45.0].map(|axis| axis as f32);
            forces.push(field, Some([0.3, sense as f32 * sideways, -9.8]));
        }
        forces
    }

    #[test]
    fn left_and_right_turns_together_show_down_without_the_sideways_acceleration() {
        let lean = |down: Down| norm(minus(down.direction, scaled([-0.3, 0.0, 9.8], 1.0 / 9.8046)));
        let both = driven(2, 2, 1.5).down().expect("two senses");
        assert!(lean(both) < 0.01 && both.error_rad > 0.03, "{both:?}");
        let one = driven(2, 0, 1.5).down().expect("one sense");
        assert!(lean(one) > 0.1 && one.error_rad > 0.09, "{one:?}");
        let slow = driven(2, 2, 0.1).down().expect("two senses");
        assert!(slow.error_rad < 0.005, "{slow:?}");
    }

    #[test]
    fn without_an_accelerometer_or_without_turns_there_is_no_down() {
        let mut forces = Forces::default();
        for i in 0..1000 {
            forces.push([20.0, 0.01 * i as f32, 45.0], None);
        }
        assert!(!forces.are_heard() && forces.down().is_none());
        for _ in 0..1000 {
            forces.push([20.0, 10.0, 45.0], Some([0.0, 0.0, -9.8]));
        }
        assert!(forces.are_heard() && forces.down().is_none());
    }
}
