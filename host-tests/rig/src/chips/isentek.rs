//! IST8310.

use super::register_chip::{Action, Model, Registers, World, put_16_bit_le};

/// IST8310.
pub struct Ist8310Model {
    /// The offset of its own, µT: the self-test does not turn it around.
    pub offset_ut: [f64; 3],
}

impl Model for Ist8310Model {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x00] = 0x10;
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x0a => 0x0f,
            0x0b => 0x0d,
            0x0c => 0x40,
            0x0d => 0x70,
            0x41 => 0x3f,
            0x42 => 0xc0,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        match (register, registers[0x0a]) {
            // Sixteen averages take 6 ms, one 1.5.
            (0x0a, 1) => Action::Once(if registers[0x41] == 0x24 { 6_000_000 } else { 1_500_000 }),
            _ => Action::Settle,
        }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x08 {
            registers[0x02] = 0;
        }
    }

    fn period_ns(&self, _registers: &Registers) -> Option<u64> {
        None
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = std::array::from_fn(|axis| if registers[0x0d] & 0x10 << axis != 0 { 13.2 } else { 3.3 });
        let field_ut = std::array::from_fn(|axis| {
            let turned = registers[0x0c] & 0x40 != 0 && world.dead_axis != Some(axis);
            self.offset_ut[axis] + if turned { -world.field_ut[axis] } else { world.field_ut[axis] }
        });
        put_16_bit_le(registers, 0x03, per_ut, field_ut);
        registers[0x02] = if registers[0x02] & 1 != 0 { 3 } else { 1 };
        registers[0x0a] = 0;
    }
}
