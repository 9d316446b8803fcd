//! HMC5883L.

use super::register_chip::{Action, Model, Registers, World, counts, period_of_hz};

/// HMC5883L.
#[derive(Default)]
pub struct Hmc5883lModel {
    /// Gain of the next measurement: a new one holds from the second on.
    gain: usize,
}

const COUNTS_PER_GAUSS: [f64; 8] = [1370.0, 1090.0, 820.0, 660.0, 440.0, 390.0, 330.0, 230.0];
/// The field of the self-test, gauss.
const TEST_GAUSS: [f64; 3] = [1.16, 1.16, 1.08];

impl Model for Hmc5883lModel {
    fn power_up(&mut self, registers: &mut Registers) {
        (registers[0], registers[1], registers[2]) = (0x10, 0x20, 0x01);
        registers[0x0a..0x0d].copy_from_slice(b"H43");
        self.gain = 1;
    }

    fn next(&self, pointer: u8) -> u8 {
        match pointer {
            0x08 => 0x03,
            12.. => 0,
            other => other + 1,
        }
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0 => 0x7f,
            1 => 0xe0,
            2 => 0x83,
            _ => 0,
        }
    }

    fn written(&mut self, _registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 2 { Action::Restart } else { Action::Settle }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x08 {
            registers[9] &= !1;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[2] & 3 != 0 {
            return None;
        }
        period_of_hz([0.75, 1.5, 3.0, 7.5, 15.0, 30.0, 75.0, 0.0][usize::from(registers[0] >> 2 & 7)])
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = COUNTS_PER_GAUSS[self.gain] / 100.0;
        self.gain = usize::from(registers[1] >> 5);
        let sign = [0.0, 1.0, -1.0, 0.0][usize::from(registers[0] & 3)];
        // x, z, y.
        for (place, axis) in [0, 2, 1].into_iter().enumerate() {
            // In a self-test the outputs are what the test's field makes of them.
            let test_ut = if world.dead_axis == Some(axis) { 0.0 } else { sign * TEST_GAUSS[axis] * 100.0 };
            let field_ut = if sign == 0.0 { world.field_ut[axis] } else { test_ut };
            let (count, beyond) = counts(field_ut * per_ut, -2048, 2047);
            let count = if beyond { -4096 } else { count };
            registers[3 + 2 * place..5 + 2 * place].copy_from_slice(&(count as i16).to_be_bytes());
        }
        registers[9] |= 1;
    }
}
