//! Whether the sensor is late: the angle between field and gravity, which the magnitude cannot see.

use super::blocks::Blocks;
use super::memory::Memory;
use super::point::dip;
use crate::real::decompose::Decompose;
use crate::vector::{dot, norm, product, scaled, times};

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

/// The small study of the dip.
#[derive(Clone, Debug)]
pub(super) struct Late {
    /// From the magnitude's triangular frame to the accelerometer's.
    pub(super) rotation: [[f32; 3]; 3],
    sine: f32,
    pub(super) blocks: Blocks<DIP, DIP_ENTRIES>,
    pub(super) memory: Memory,
    /// Rows at which it is looked whether it stands well.
    look_at: u32,
    begun: bool,
}

/// Rows before it is looked for the first time whether it stands well.
const LOOK_AT: u32 = 200;
/// More than this is no rotation that so few rows tell, rad.
const ABSURD_RAD: f32 = 0.8;
/// A rotation further than this from where it was linearised begins anew, rad.
const FAR_RAD: f32 = 0.04;

impl Late {
    pub(super) const fn new() -> Self {
        Self {
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            sine: 0.0,
            blocks: Blocks::new(),
            memory: Memory::new(),
            look_at: LOOK_AT,
            begun: false,
        }
    }

    pub(super) fn begin(&mut self, rotation: [[f32; 3]; 3]) {
        self.blocks.clear();
        self.memory = Memory::new();
        (self.rotation, self.look_at, self.begun) = (rotation, LOOK_AT, false);
    }

    /// Takes a corrected direction.
    #[inline]
    pub(super) fn push(&mut self, direction: [f32; 3], motion: &Motion) {
        let (Some(down), Some(_)) = (motion.down(), motion.turn_radps) else { return };
        let direction = times(&self.rotation, direction);
        if !self.begun {
            self.begun = true;
            self.sine = dot(direction, down);
        }
        let look = dip(direction, down, motion.turn_radps, self.sine);
        if !(look.residual.is_finite() && look.row.iter().all(|value| value.is_finite())) {
            return;
        }
        self.blocks.push(&look.row, look.residual);
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
        if far > FAR_RAD && far < ABSURD_RAD && factor.largest_error(&work) < FAR_RAD {
            self.rotation = product(&f32::rotation([x, y, z]), &self.rotation);
            self.sine = (self.sine + sine).clamp(-0.99, 0.99);
            self.blocks.clear();
            self.memory = Memory::new();
            self.look_at = LOOK_AT;
        }
    }

    pub(super) fn interrupt(&mut self) {
        self.memory.interrupt();
    }

    /// The same rows about another point, the correction itself late by `delay_s` less.
    pub(super) fn shift(&mut self, delta: &[f32; DIP]) {
        self.blocks.iter_mut().for_each(|block| block.shift(delta));
        let [x, y, z, sine, _] = *delta;
        self.rotation = product(&f32::rotation([x, y, z]), &self.rotation);
        self.sine = (self.sine + sine).clamp(-0.99, 0.99);
    }
}
