//! BMM150, with trimming: what its registers hold is the field before compensation.

use super::register_chip::{Action, Model, Registers, World, counts, period_of_hz};

/// The trimming that a chip was given.
#[derive(Clone, Copy, Debug)]
pub struct Trimming {
    /// x and y: offset, gain.
    pub xy: [(i8, i8); 2],
    /// z1 to z4.
    pub z: (u16, i16, i16, i16),
    /// How the gain of x and y goes with the Hall resistance: xy1, xy2.
    pub bend: (u8, i8),
    /// The Hall resistance of the trimming.
    pub xyz1: u16,
}

impl Default for Trimming {
    /// As chips have it.
    fn default() -> Self {
        Self { xy: [(1, 26), (-2, 27)], z: (23_500, 640, 25, 30), bend: (29, -3), xyz1: 6600 }
    }
}

/// BMM150.
pub struct Bmm150Model {
    trimming: Trimming,
    awake: bool,
    starting: bool,
}

impl Bmm150Model {
    /// A chip with this trimming, suspended.
    pub fn new(trimming: Trimming) -> Self {
        Self { trimming, awake: false, starting: false }
    }

    fn hall(&self, temperature_c: f64) -> f64 {
        // Some 0.2 % a degree.
        (f64::from(self.trimming.xyz1) * (1.0 + 0.002 * (temperature_c - 25.0))).round()
    }
}

impl Model for Bmm150Model {
    fn power_up(&mut self, _registers: &mut Registers) {
        (self.awake, self.starting) = (false, false);
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x4b => 0x87,
            0x4c..=0x52 if self.awake => 0xff,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        match register {
            0x4b if registers[0x4b] & 1 == 0 => {
                self.awake = false;
                Action::Settle
            }
            0x4b if !self.awake => {
                self.starting = true;
                Action::Once(2_900_000)
            }
            // The self-test is done asleep.
            0x4c if registers[0x4c] & 0x07 == 0x07 => Action::Once(5_000_000),
            0x4c => Action::Restart,
            _ => Action::Settle,
        }
    }

    fn shown(&self, registers: &Registers, register: u8) -> u8 {
        if self.awake || register == 0x4b { registers[usize::from(register)] } else { 0 }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x49 {
            registers[0x48] &= !1;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if !self.awake || registers[0x4c] & 0x06 != 0 {
            return None;
        }
        period_of_hz([10.0, 2.0, 6.0, 8.0, 15.0, 20.0, 25.0, 30.0][usize::from(registers[0x4c] >> 3 & 7)])
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let Trimming { xy, z: (z1, z2, z3, z4), bend: (xy1, xy2), xyz1 } = self.trimming;
        if std::mem::take(&mut self.starting) {
            self.awake = true;
            registers[0x40] = 0x32;
            registers[0x4c] = 0x06;
            registers[0x4e] = 0x07;
            let mut put = |at: usize, bytes: &[u8]| registers[at..at + bytes.len()].copy_from_slice(bytes);
            put(0x5d, &[xy[0].0 as u8, xy[1].0 as u8]);
            put(0x62, &z4.to_le_bytes());
            put(0x64, &[xy[0].1 as u8, xy[1].1 as u8]);
            put(0x68, &z2.to_le_bytes());
            put(0x6a, &z1.to_le_bytes());
            put(0x6c, &xyz1.to_le_bytes());
            put(0x6e, &z3.to_le_bytes());
            put(0x70, &[xy2 as u8, xy1]);
            return;
        }
        if registers[0x4c] & 0x07 == 0x07 {
            registers[0x4c] &= !1;
            for (axis, at) in [0x42, 0x44, 0x46].into_iter().enumerate() {
                registers[at] = registers[at] & !1 | u8::from(world.dead_axis != Some(axis));
            }
            return;
        }
        let hall = self.hall(world.temperature_c);
        // The published compensation in floating point, turned around.
        let off = f64::from(xyz1) * 16_384.0 / hall - 16_384.0;
        let gain = f64::from(xy2) * off * off / 268_435_456.0 + off * f64::from(xy1) / 16_384.0 + 256.0;
        for axis in 0..2 {
            let (first, second) = xy[axis];
            let value = (world.field_ut[axis] * 16.0 - f64::from(first) * 8.0) * 8192.0
                / (gain * (f64::from(second) + 160.0));
            let (count, beyond) = counts(value, -4095, 4095);
            let count = if beyond { -4096 } else { count };
            let bytes = ((count as i16) << 3 | 1).to_le_bytes();
            registers[0x42 + 2 * axis..0x44 + 2 * axis].copy_from_slice(&bytes);
        }
        let slope = f64::from(z2) + f64::from(z1) * hall / 32_768.0;
        let drift = f64::from(z3) * (hall - f64::from(xyz1));
        let value = (world.field_ut[2] * 64.0 * slope + drift) / 131_072.0 + f64::from(z4);
        let (count, beyond) = counts(value, -16_383, 16_383);
        let count = if beyond { -16_384 } else { count };
        registers[0x46..0x48].copy_from_slice(&((count as i16) << 1 | 1).to_le_bytes());
        registers[0x48..0x4a].copy_from_slice(&((hall as u16) << 2 | 1).to_le_bytes());
    }
}
