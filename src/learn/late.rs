//! Whether the sensor is late, which the magnitude cannot see: by the angle between field and gravity, and by how a gyro turns.

use super::blocks::{Blocks, MOST_ROWS};
use super::bounds::{ABSURD_RAD, FAR_RAD, LOOK_AT, MIN_DIRECTION, TRIES};
use super::memory::Memory;
use super::point::dip;
use super::turning::{ByField, ByGyro, TURNING, Turning};
use crate::real::decompose::Decompose;
use crate::study::{Factor, Normal, Role};
use crate::vector::{cross, dot, norm, product, scaled, times};

/// Columns of the dip: a rotation (3), the sine of the dip (1), the delay (1).
pub(super) const DIP: usize = 5;

/// What the accelerometer and the gyro say, in the board's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The specific force, m/s².
    pub accel_mps2: Option<[f32; 3]>,
    /// The rate of turn, rad/s.
    pub turn_radps: Option<[f32; 3]>,
}

impl Motion {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { accel_mps2: None, turn_radps: None };

    /// The direction down: against the specific force.
    pub(super) fn down(&self) -> Option<[f32; 3]> {
        let force = self.accel_mps2?;
        let size = norm(force);
        // Falling, or shaken: no direction.
        (size.is_finite() && size > 1.0).then(|| scaled(force, -1.0 / size))
    }
}

/// The small study of the dip, and of the way between two directions where there is a gyro.
#[derive(Clone, Debug)]
pub(super) struct Late {
    /// From the magnitude's triangular frame to the accelerometer's.
    pub(super) rotation: [[f32; 3]; 3],
    sine: f32,
    pub(super) blocks: Blocks<Normal<f32, DIP>>,
    pub(super) memory: Memory,
    pub(super) turning: Turning,
    pub(super) by_gyro: Normal<f32, TURNING>,
    /// Rows at which it is looked whether it stands well.
    look_at: u32,
    begun: bool,
    /// How often it may still begin anew by itself.
    tries: u8,
}

impl Late {
    pub(super) const fn new() -> Self {
        Self {
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            sine: 0.0,
            blocks: Blocks::new(),
            memory: Memory::new(),
            turning: Turning::Field(ByField::new()),
            by_gyro: Normal::EMPTY,
            look_at: LOOK_AT,
            begun: false,
            tries: TRIES,
        }
    }

    pub(super) fn begin(&mut self, rotation: [[f32; 3]; 3]) {
        self.blocks.clear();
        self.memory = Memory::new();
        (self.rotation, self.look_at, self.begun) = (rotation, LOOK_AT, false);
        self.tries = TRIES;
        self.turning.interrupt();
        self.by_gyro.clear();
    }

    /// Takes a corrected direction.
    #[inline]
    pub(super) fn push(&mut self, direction: [f32; 3], motion: &Motion, t_ms: u64) {
        let direction = times(&self.rotation, direction);
        let (direction, down, rate) = match motion.turn_radps {
            Some(turn_radps) => {
                if !matches!(self.turning, Turning::Gyro(_)) {
                    // What the field alone has told has another noise.
                    self.turning = Turning::Gyro(ByGyro::new());
                    self.begin(self.rotation);
                }
                if let Turning::Gyro(gyro) = &mut self.turning {
                    gyro.push(direction, turn_radps, t_ms, &mut self.by_gyro);
                    if self.by_gyro.rows() > MOST_ROWS {
                        self.by_gyro.halve();
                    }
                }
                let Some(down) = motion.down() else { return };
                (direction, down, scaled(cross(turn_radps, direction), -1.0))
            }
            None => {
                if !matches!(self.turning, Turning::Field(_)) {
                    self.turning = Turning::Field(ByField::new());
                    self.begin(self.rotation);
                }
                let (Turning::Field(field), Some(down)) = (&mut self.turning, motion.down()) else { return };
                let Some(middle) = field.push(direction, down, t_ms) else { return };
                middle
            }
        };
        if !self.begun {
            self.begun = true;
            self.sine = dot(direction, down);
        }
        let look = dip(direction, down, rate, self.sine);
        if !(look.residual.is_finite() && look.row.iter().all(|value| value.is_finite())) {
            return;
        }
        self.blocks.push(|block| block.push(&look.row, look.residual), |_| {});
        self.memory.push(look.residual);
        if self.blocks.rows() == self.look_at {
            self.look();
        }
    }

    /// The sums of all rows.
    pub(super) fn total(&self) -> Normal<f32, DIP> {
        let mut total = Normal::EMPTY;
        self.blocks.iter().for_each(|block| total.merge(block));
        total
    }

    /// Begins anew where the sums say that they were taken far from where they should have been.
    fn look(&mut self) {
        self.look_at = self.look_at.saturating_mul(2);
        let total = self.total();
        // Next to the delay, which turns the field too.
        let mut factor = Factor::new();
        let role = |column| if column + 1 < DIP { Role::Required } else { Role::Optional(MIN_DIRECTION) };
        if factor.extend(&total, DIP, 0.0, &role).is_none() {
            return;
        }
        let delta = total.step(&factor);
        let [x, y, z, sine, _] = delta;
        let far = norm([x, y, z]).max(sine.abs());
        let is_told = factor.largest_error(&total, DIP - 1) < FAR_RAD;
        if self.tries > 0 && far > FAR_RAD && far < ABSURD_RAD && is_told {
            let tries = self.tries - 1;
            self.turn(&delta);
            self.begin(self.rotation);
            (self.begun, self.tries) = (true, tries);
        }
    }

    pub(super) fn interrupt(&mut self) {
        self.memory.interrupt();
        self.turning.interrupt();
    }

    /// The same rows about another point, the correction itself late by the last number less.
    pub(super) fn shift(&mut self, delta: &[f32; DIP]) {
        self.blocks.iter_mut().for_each(|block| block.shift(delta));
        self.turn(delta);
    }

    fn turn(&mut self, [x, y, z, sine, _]: &[f32; DIP]) {
        self.rotation = product(&f32::rotation([*x, *y, *z]), &self.rotation);
        self.sine = (self.sine + sine).clamp(-0.99, 0.99);
    }
}
