//! Rotation vectors summed up from a gyro.

use crate::vector::{cross, dot, plus, scaled};

/// A longer time without a rate of turn is a gap, s.
const MAX_STEP_S: f32 = 0.5;
/// A longer way from one look to the next is not used, s: the zero error of the gyro has turned it too far.
const MAX_WAY_S: f32 = 10.0;
/// Not known: it makes every sum with it unknown.
const UNKNOWN: [f32; 3] = [f32::NAN; 3];

/// The rotation vector of a turn by `first` and then by `second`, both in the axes of a board that turns (Baker, Campbell and
/// Hausdorff to the third order).
#[inline(never)]
fn then(first: [f32; 3], second: [f32; 3]) -> [f32; 3] {
    let both = cross(first, second);
    let third = cross(plus(first, scaled(second, -1.0)), both);
    plus(plus(first, second), plus(scaled(both, 0.5), scaled(third, 1.0 / 12.0)))
}

/// The turn from one look to the next: a rotation vector, rad, not finite where it is not known, and the time, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    turn_rad: [f32; 3],
    way_s: f32,
}

impl Link {
    pub(super) const NONE: Self = Self { turn_rad: [0.0; 3], way_s: 0.0 };

    /// `None` where the turn is not known.
    #[inline(never)]
    pub(super) fn known(&self) -> Option<([f32; 3], f32)> {
        let is_known = dot(self.turn_rad, self.turn_rad) < f32::INFINITY && self.way_s < MAX_WAY_S;
        is_known.then_some((self.turn_rad, self.way_s))
    }
}

/// The way from the mean of the last look to now.
#[derive(Clone, Debug)]
pub(super) struct Way {
    /// The last rate of turn, rad/s, and when.
    rate: [f32; 3],
    t_ms: u64,
    /// From the mean of the last look to the beginning of the open one, rad and s.
    before: [f32; 3],
    before_s: f32,
    /// From there to now, rad, and its sum over the readings of the open look.
    since: [f32; 3],
    sum: [f32; 3],
}

impl Way {
    /// What comes before the first look is not used.
    pub(super) const fn new() -> Self {
        let zero = [0.0; 3];
        Self { rate: zero, t_ms: 0, before: zero, before_s: 0.0, since: zero, sum: zero }
    }

    /// Goes on to this time with this rate of turn, rad/s.
    #[inline(never)]
    pub(super) fn step(&mut self, t_ms: u64, rate: Option<[f32; 3]>) {
        let step_s = t_ms.saturating_sub(self.t_ms) as f32 * 1e-3;
        let rate = rate.unwrap_or(UNKNOWN);
        let turn = if step_s < MAX_STEP_S { scaled(plus(self.rate, rate), 0.5 * step_s) } else { UNKNOWN };
        self.since = then(self.since, turn);
        (self.rate, self.t_ms) = (rate, t_ms);
    }

    /// Counts the reading of now to the open look.
    pub(super) fn count(&mut self) {
        self.sum = plus(self.sum, self.since);
    }

    /// A look of so many readings, which took so long, ends now, and another one begins.
    #[inline(never)]
    pub(super) fn close(&mut self, readings: u16, took_s: f32) -> Link {
        let mean = scaled(self.sum, 1.0 / f32::from(readings));
        let link = Link { turn_rad: then(self.before, mean), way_s: self.before_s + 0.5 * took_s };
        (self.before, self.before_s) = (then(scaled(mean, -1.0), self.since), 0.5 * took_s);
        (self.since, self.sum) = ([0.0; 3], [0.0; 3]);
        link
    }

    /// What is open after so long a time is no look; another one begins.
    pub(super) fn skip(&mut self, took_s: f32) {
        self.before_s += took_s;
        self.before = if self.before_s < MAX_WAY_S { then(self.before, self.since) } else { UNKNOWN };
        (self.since, self.sum) = ([0.0; 3], [0.0; 3]);
    }
}
