//! RM3100.

use super::register_chip::{Action, Model, Registers, World, counts, period_of_hz};

/// RM3100.
#[derive(Default)]
pub struct Rm3100Model;

impl Model for Rm3100Model {
    fn power_up(&mut self, registers: &mut Registers) {
        for high in [0x04, 0x06, 0x08] {
            (registers[high], registers[high + 1]) = (0, 200);
        }
        registers[0x0b] = 0x96;
        registers[0x36] = 0x22;
    }

    fn pointer(&self, byte: u8) -> (u8, bool) {
        (byte & 0x7f, true)
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x00 => 0x70,
            0x01 => 0x7d,
            0x04..=0x09 | 0x0b => 0xff,
            0x33 => 0x8f,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        // "Any write lets data ready fall."
        registers[0x34] = 0;
        match register {
            0x00 if registers[0x00] != 0 => Action::Once(10_000_000),
            0x01 => Action::Restart,
            _ => Action::Settle,
        }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if (0x24..=0x2c).contains(&register) {
            registers[0x34] = 0;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[0x01] & 0x71 != 0x71 || !(0x92..=0x9f).contains(&registers[0x0b]) {
            return None;
        }
        let hz = 600.0 / f64::from(1_u32 << (registers[0x0b] - 0x92));
        // No faster than the three coils one after the other.
        let most_hz = 1e6 / (3.0 * (11.0 * f64::from(registers[0x05]) + 60.0));
        period_of_hz(hz.min(most_hz))
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        registers[0x34] = 0x80;
        if registers[0x00] != 0 && registers[0x33] & 0x80 != 0 {
            registers[0x00] = 0;
            for axis in 0..3 {
                let bit = 0x10 << axis;
                let good = world.dead_axis != Some(axis);
                registers[0x33] = if good { registers[0x33] | bit } else { registers[0x33] & !bit };
            }
            return;
        }
        for axis in 0..3 {
            let per_ut = match registers[0x05 + 2 * axis] {
                50 => 20.0,
                100 => 38.0,
                200 => 75.0,
                // Between the points of the table.
                cycles => 0.3671 * f64::from(cycles) + 1.5,
            };
            let (count, _) = counts(world.field_ut[axis] * per_ut, -8_388_608, 8_388_607);
            registers[0x24 + 3 * axis..0x27 + 3 * axis].copy_from_slice(&count.to_be_bytes()[1..]);
        }
    }
}
