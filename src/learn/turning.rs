//! How the field turns in the board's axes: against a gyro, or by itself where there is none.

use super::sums::Sums;
use crate::vector::{cross, dot, minus, scaled};

/// A direction is held against where a gyro turns it over this time, s: long against the sensor's noise, short against a movement.
const SPAN_S: f32 = 0.1;
/// Of three moments between which the field shows how it turns, one is at least so long after the other, ms.
const APART_MS: u32 = 40;
/// Columns of the turning: a rotation between the sensor's axes and the gyro's (3), and the delay (1).
pub(super) const TURNING: usize = 4;
pub(super) const TURNING_ENTRIES: usize = TURNING * (TURNING + 1) / 2;
/// Its base.
pub(super) const TURNING_BASE: usize = 3;

fn sum(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// One direction held against where the gyro has turned it since another one.
///
/// A field `n` that is late by `τ` goes `ṅ = −ω × n + τ ω̇ × n`: what is left of its way beyond `−∫ω × n` follows the change of the
/// rate of turn, whatever the accelerometer feels meanwhile. A rotation `δ` between the axes leaves `∫(ω × δ) × n`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByGyro {
    t_ms: u32,
    /// Of it so much has gone; below zero nothing has begun.
    span_s: f32,
    from: [f32; 3],
    last: [f32; 3],
    turn_radps: [f32; 3],
    way: [f32; 3],
    late: [f32; 3],
    skew: [[f32; 3]; 3],
    /// From one sample to the next, s, on average of late.
    beat_s: f32,
}

impl ByGyro {
    pub(super) const fn new() -> Self {
        Self {
            t_ms: 0,
            span_s: -1.0,
            from: [0.0; 3],
            last: [0.0; 3],
            turn_radps: [0.0; 3],
            way: [0.0; 3],
            late: [0.0; 3],
            skew: [[0.0; 3]; 3],
            beat_s: 0.0,
        }
    }

    fn begin(&mut self, direction: [f32; 3]) {
        (self.span_s, self.from) = (0.0, direction);
        (self.way, self.late, self.skew) = ([0.0; 3], [0.0; 3], [[0.0; 3]; 3]);
    }

    /// Takes a direction; adds rows where a span is full.
    #[inline]
    pub(super) fn push(
        &mut self,
        direction: [f32; 3],
        turn_radps: [f32; 3],
        t_ms: u64,
        sums: &mut Sums<TURNING, TURNING_ENTRIES>,
    ) {
        let step_s = (t_ms as u32).wrapping_sub(self.t_ms) as f32 * 1e-3;
        let (last, before) = (self.last, self.turn_radps);
        (self.t_ms, self.last, self.turn_radps) = (t_ms as u32, direction, turn_radps);
        if self.span_s < 0.0 || !(step_s > 0.0 && step_s < SPAN_S) {
            return self.begin(direction);
        }
        self.beat_s += if self.beat_s > 0.0 { 0.02 * (step_s - self.beat_s) } else { step_s };
        let (middle, turn) = (scaled(sum(last, direction), 0.5), scaled(sum(before, turn_radps), 0.5));
        self.way = minus(self.way, scaled(cross(turn, middle), step_s));
        self.late = sum(self.late, cross(minus(turn_radps, before), middle));
        let along = dot(turn, middle) * step_s;
        let [x, y, z] = middle;
        for (axis, row) in self.skew.iter_mut().enumerate() {
            let own = turn[axis] * step_s;
            *row = [row[0] - own * x, row[1] - own * y, row[2] - own * z];
            row[axis] += along;
        }
        self.span_s += step_s;
        if self.span_s < SPAN_S {
            return;
        }
        let left = minus(minus(direction, self.from), self.way);
        let finite = |v: &[f32; 3]| v.iter().all(|value| value.is_finite());
        if finite(&left) && finite(&self.late) && self.skew.iter().all(finite) {
            for axis in 0..3 {
                let [x, y, z] = self.skew[axis];
                // The columns of what is to be taken off.
                sums.push(&[-x, -y, -z, -self.late[axis]], left[axis]);
            }
        }
        self.begin(direction);
    }

    pub(super) fn interrupt(&mut self) {
        self.span_s = -1.0;
    }

    pub(super) fn beat_s(&self) -> f32 {
        self.beat_s
    }
}

/// Three moments: how the field turned at the middle one, with the direction down there. The noise of the middle one is not in the
/// way between the others.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByField {
    /// From the oldest to the newest: time, direction, down.
    moments: [(u32, [f32; 3], [f32; 3]); 3],
    known: u8,
}

impl ByField {
    pub(super) const fn new() -> Self {
        Self { moments: [(0, [0.0; 3], [0.0; 3]); 3], known: 0 }
    }

    /// Takes a direction; the middle one of three, its down and how it turned, 1/s, where there is a new one.
    #[inline]
    pub(super) fn push(
        &mut self,
        direction: [f32; 3],
        down: [f32; 3],
        t_ms: u64,
    ) -> Option<([f32; 3], [f32; 3], [f32; 3])> {
        let t_ms = t_ms as u32;
        let [_, second, third] = self.moments;
        if self.known > 0 && t_ms.wrapping_sub(third.0) < APART_MS {
            return None;
        }
        self.moments = [second, third, (t_ms, direction, down)];
        self.known = (self.known + 1).min(3);
        let [first, middle, last] = self.moments;
        let way_s = last.0.wrapping_sub(first.0) as f32 * 1e-3;
        if self.known < 3 || way_s > 8.0 * APART_MS as f32 * 1e-3 {
            return None;
        }
        Some((middle.1, middle.2, scaled(minus(last.1, first.1), 1.0 / way_s)))
    }

    pub(super) fn interrupt(&mut self) {
        self.known = 0;
    }
}

/// What the field is held against.
#[derive(Clone, Copy, Debug)]
pub(super) enum Turning {
    Gyro(ByGyro),
    Field(ByField),
}

impl Turning {
    /// The time from one sample to the next, s.
    pub(super) fn beat_s(&self) -> f32 {
        match self {
            Self::Gyro(gyro) => gyro.beat_s(),
            Self::Field(_) => 0.0,
        }
    }

    pub(super) fn interrupt(&mut self) {
        match self {
            Self::Gyro(gyro) => gyro.interrupt(),
            Self::Field(field) => field.interrupt(),
        }
    }
}
