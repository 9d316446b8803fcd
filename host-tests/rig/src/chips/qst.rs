//! QMC5883L and QMC5883P.

use super::register_chip::{Action, Model, Registers, World, period_of_hz, put_16_bit_le};

/// QMC5883L.
pub struct Qmc5883lModel;

impl Model for Qmc5883lModel {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x0d] = 0xff;
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x09 | 0x0b => 0xff,
            0x0a => 0xc1,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 0x0a && registers[0x0a] & 0x80 != 0 {
            *registers = [0; 256];
            self.power_up(registers);
        }
        if register == 0x09 { Action::Restart } else { Action::Settle }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        // Data ready and skipped fall with the reading of the outputs; overflow is of the measurement and stays.
        if register == 0x05 {
            registers[0x06] &= 0x02;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[0x09] & 3 != 1 {
            return None;
        }
        period_of_hz([10.0, 50.0, 100.0, 200.0][usize::from(registers[0x09] >> 2 & 3)])
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = [120.0, 30.0, 30.0, 30.0][usize::from(registers[0x09] >> 4 & 3)];
        let beyond = put_16_bit_le(registers, 0x00, [per_ut; 3], world.field_ut);
        let skipped = if registers[0x06] & 1 != 0 { 4 } else { 0 };
        registers[0x06] = 1 | if beyond { 2 } else { 0 } | skipped;
        // Its zero is not calibrated: 41 °C off, here.
        let temperature = ((world.temperature_c - 41.0) * 100.0).round() as i16;
        registers[0x07..0x09].copy_from_slice(&temperature.to_le_bytes());
    }
}

/// QMC5883P.
pub struct Qmc5883pModel;

impl Model for Qmc5883pModel {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x00] = 0x80;
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x0a | 0x29 => 0xff,
            0x0b => 0xcf,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 0x0b && registers[0x0b] & 0x80 != 0 {
            *registers = [0; 256];
            self.power_up(registers);
        }
        if register == 0x0a { Action::Restart } else { Action::Settle }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x09 {
            registers[0x09] &= 0x02;
        }
    }

    fn shown(&self, registers: &Registers, register: u8) -> u8 {
        registers[usize::from(register)]
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[0x0a] & 3 != 1 {
            return None;
        }
        period_of_hz([10.0, 50.0, 100.0, 200.0][usize::from(registers[0x0a] >> 2 & 3)])
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = [10.0, 25.0, 37.5, 150.0][usize::from(registers[0x0b] >> 2 & 3)];
        let beyond = put_16_bit_le(registers, 0x01, [per_ut; 3], world.field_ut);
        registers[0x09] = 1 | if beyond { 2 } else { 0 };
    }
}
