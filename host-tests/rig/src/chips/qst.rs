//! QMC5883L, QMC5883P, QMC6309 and QMC6310.

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

/// What reading the status does to the chips that clear their flags then.
fn clear_flags(registers: &mut Registers, register: u8) {
    if register == 0x09 {
        registers[0x09] &= !0x03;
    }
}

/// Outputs from 0x01 on, and the flags: an axis beyond this count is an overflow, before 16 bits end.
fn put_flagged(registers: &mut Registers, per_ut: f64, most: f64, world: &World) {
    put_16_bit_le(registers, 0x01, [per_ut; 3], world.field_ut);
    let beyond = world.field_ut.iter().any(|ut| (ut * per_ut).round().abs() > most);
    registers[0x09] = registers[0x09] & !0x03 | 1 | if beyond { 2 } else { 0 };
}

/// QMC6310: the registers of a QMC5883P.
pub struct Qmc6310Model;

impl Model for Qmc6310Model {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x00] = 0x80;
    }

    fn writable(&self, register: u8) -> u8 {
        Qmc5883pModel.writable(register)
    }

    fn written(&mut self, registers: &mut Registers, register: u8, byte: u8) -> Action {
        Qmc5883pModel.written(registers, register, byte)
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        clear_flags(registers, register);
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        Qmc5883pModel.period_ns(registers)
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = [10.0, 25.0, 37.5, 150.0][usize::from(registers[0x0b] >> 2 & 3)];
        put_flagged(registers, per_ut, 30_000.0, world);
    }
}

/// QMC6309.
#[derive(Default)]
pub struct Qmc6309Model {
    /// It was switched from one mode to another without being suspended between: it measures nothing.
    confused: bool,
    mode: u8,
}

impl Model for Qmc6309Model {
    fn power_up(&mut self, registers: &mut Registers) {
        (registers[0x00], registers[0x09]) = (0x90, 0x18);
        (self.confused, self.mode) = (false, 0);
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x0a => 0xfb,
            0x0b => 0xff,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        match register {
            0x0b if registers[0x0b] & 0x80 != 0 => {
                *registers = [0; 256];
                self.power_up(registers);
                Action::Settle
            }
            0x0a => {
                let mode = registers[0x0a] & 3;
                self.confused = mode != 0 && (self.confused || self.mode != 0 && self.mode != mode);
                self.mode = mode;
                Action::Restart
            }
            _ => Action::Settle,
        }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        clear_flags(registers, register);
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if self.confused || registers[0x0a] & 3 != 1 {
            return None;
        }
        let rate = usize::from(registers[0x0b] >> 4 & 7).min(4);
        period_of_hz([1.0, 10.0, 50.0, 100.0, 200.0][rate])
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = [10.0, 20.0, 40.0, 10.0][usize::from(registers[0x0b] >> 2 & 3)];
        put_flagged(registers, per_ut, 32_000.0, world);
    }
}
