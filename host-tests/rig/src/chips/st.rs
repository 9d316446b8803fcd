//! LIS2MDL (and its relatives) and LIS3MDL.

use super::register_chip::{Action, Model, Registers, World, period_of_hz, put_16_bit_le, with_test_field};

/// LIS2MDL, IIS2MDC, and the magnetic half of an LSM303AGR.
pub struct Lis2mdlModel {
    /// The magnetic half of an LSM303AGR has no temperature, and its pointer goes on only with bit 7 of the sub-address.
    pub is_lsm303agr: bool,
}

impl Model for Lis2mdlModel {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x4f] = 0x40;
        // Idle.
        registers[0x60] = 0x03;
    }

    fn pointer(&self, byte: u8) -> (u8, bool) {
        (byte & 0x7f, !self.is_lsm303agr || byte & 0x80 != 0)
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x45..=0x4a | 0x60 | 0x63 | 0x65 | 0x66 => 0xff,
            0x61 => 0x1f,
            0x62 => 0x7f,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 0x60 && registers[0x60] & 0x20 != 0 {
            // Soft reset.
            *registers = [0; 256];
            self.power_up(registers);
        }
        if register == 0x60 { Action::Restart } else { Action::Settle }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x6d {
            registers[0x67] = 0;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[0x60] & 0x03 != 0 {
            return None;
        }
        period_of_hz([10.0, 20.0, 50.0, 100.0][usize::from(registers[0x60] >> 2 & 3)])
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        // 200 mG.
        let test_ut = if registers[0x62] & 0x02 != 0 { [20.0; 3] } else { [0.0; 3] };
        let mut field_ut = with_test_field(world, test_ut);
        for (axis, field) in field_ut.iter_mut().enumerate() {
            let at = 0x45 + 2 * axis;
            *field -= f64::from(i16::from_le_bytes([registers[at], registers[at + 1]])) * 0.15;
        }
        put_16_bit_le(registers, 0x68, [1.0 / 0.15; 3], field_ut);
        if !self.is_lsm303agr {
            let temperature = ((world.temperature_c - 25.0) * 8.0).round() as i16;
            registers[0x6e..0x70].copy_from_slice(&temperature.to_le_bytes());
        }
        // Overrun of all axes where the one before was not read, and new data of all.
        registers[0x67] = if registers[0x67] & 0x08 != 0 { 0xff } else { 0x0f };
    }
}

/// LIS3MDL.
pub struct Lis3mdlModel;

impl Model for Lis3mdlModel {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x0f] = 0x3d;
        registers[0x20] = 0x10;
        // Powered down.
        registers[0x22] = 0x03;
    }

    fn pointer(&self, byte: u8) -> (u8, bool) {
        (byte & 0x7f, byte & 0x80 != 0)
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x05..=0x0a | 0x20 => 0xff,
            0x21 => 0x6c,
            0x22 => 0x27,
            0x23 => 0x0e,
            0x24 => 0xc0,
            _ => 0,
        }
    }

    fn written(&mut self, _registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 0x22 || register == 0x20 { Action::Restart } else { Action::Settle }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x2d {
            registers[0x27] = 0;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[0x22] & 0x03 != 0 {
            return None;
        }
        let control = registers[0x20];
        period_of_hz(if control & 0x02 != 0 {
            [1000.0, 560.0, 300.0, 155.0][usize::from(control >> 5 & 3)]
        } else {
            [0.625, 1.25, 2.5, 5.0, 10.0, 20.0, 40.0, 80.0][usize::from(control >> 2 & 7)]
        })
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let per_ut = [6842.0, 3421.0, 2281.0, 1711.0][usize::from(registers[0x21] >> 5 & 3)] / 100.0;
        let test_ut = if registers[0x20] & 0x01 != 0 { [200.0, 200.0, 50.0] } else { [0.0; 3] };
        put_16_bit_le(registers, 0x28, [per_ut; 3], with_test_field(world, test_ut));
        if registers[0x23] & 0x02 != 0 {
            // High byte first.
            for at in [0x28, 0x2a, 0x2c] {
                registers.swap(at, at + 1);
            }
        }
        if registers[0x20] & 0x80 != 0 {
            let temperature = ((world.temperature_c - 25.0) * 8.0).round() as i16;
            registers[0x2e..0x30].copy_from_slice(&temperature.to_le_bytes());
        }
        registers[0x27] = if registers[0x27] & 0x08 != 0 { 0xff } else { 0x0f };
    }
}
