//! Whether the sensor is late, which the magnitude cannot see: by the angle between field and gravity, and by how a gyro turns.

use super::blocks::{Blocks, MOST_ROWS};
use super::memory::Memory;
use super::point::dip;
use super::sums::Sums;
use super::turning::{ByField, ByGyro, TURNING, TURNING_ENTRIES, Turning};
use crate::real::decompose::Decompose;
use crate::vector::{cross, dot, norm, product, scaled, times};

/// Columns of the dip: a rotation (3), the sine of the dip (1), the delay (1).
pub(super) const DIP: usize = 5;
pub(super) const DIP_ENTRIES: usize = DIP * (DIP + 1) / 2;
/// Columns of its base.
pub(super) const DIP_BASE: usize = 4;

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
    pub(super) blocks: Blocks<DIP, DIP_ENTRIES>,
    pub(super) memory: Memory,
    pub(super) turning: Turning,
    pub(super) by_gyro: Sums<TURNING, TURNING_ENTRIES>,
    /// Rows at which it is looked whether it stands well.
    look_at: u32,
    begun: bool,
    /// How often it may still begin anew by itself.
    tries: u8,
}

/// Rows before it is looked for the first time whether it stands well.
const LOOK_AT: u32 = 200;
/// More than this is no rotation that so few rows tell, rad.
const ABSURD_RAD: f32 = 0.8;
/// It begins anew so often at most: an accelerometer that is waved shows another rotation each time.
const TRIES: u8 = 3;
/// A rotation further than this from where it was linearised begins anew, rad.
const FAR_RAD: f32 = 0.04;

impl Late {
    pub(super) const fn new() -> Self {
        Self {
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            sine: 0.0,
            blocks: Blocks::new(),
            memory: Memory::new(),
            turning: Turning::Field(ByField::new()),
            by_gyro: Sums::new(),
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
                    if self.by_gyro.rows > MOST_ROWS {
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
        self.blocks.push(&look.row, look.residual, |_| {});
        self.memory.push(look.residual);
        if self.blocks.rows() == self.look_at {
            self.look();
        }
    }

    /// Begins anew where the sums say that they were taken far from where they should have been.
    fn look(&mut self) {
        use super::solve::{Chosen, Factor};
        use super::sums::Work;
        self.look_at = self.look_at.saturating_mul(2);
        let mut work = Work::new();
        self.blocks.iter().for_each(|block| work.merge(block));
        // Beside the delay, which turns the field too.
        let Some(factor) = Factor::of(&work, Chosen::base(DIP_BASE).with(DIP_BASE, 1), true) else { return };
        let [x, y, z, sine, ..] = factor.step(&work);
        let far = norm([x, y, z]).max(sine.abs());
        if self.tries > 0 && far > FAR_RAD && far < ABSURD_RAD && factor.largest_error(&work) < FAR_RAD {
            self.tries -= 1;
            self.rotation = product(&f32::rotation([x, y, z]), &self.rotation);
            self.sine = (self.sine + sine).clamp(-0.99, 0.99);
            self.blocks.clear();
            self.memory = Memory::new();
            self.look_at = LOOK_AT;
            self.turning.interrupt();
            self.by_gyro.clear();
        }
    }

    pub(super) fn interrupt(&mut self) {
        self.memory.interrupt();
        self.turning.interrupt();
    }

    /// The same rows about another point, the correction itself late by `delay_s` less.
    pub(super) fn shift(&mut self, delta: &[f32; DIP]) {
        self.blocks.iter_mut().for_each(|block| block.shift(delta));
        let [x, y, z, sine, _] = *delta;
        self.rotation = product(&f32::rotation([x, y, z]), &self.rotation);
        self.sine = (self.sine + sine).clamp(-0.99, 0.99);
    }
}
