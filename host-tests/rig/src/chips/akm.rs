//! AK09916, and the ICM-20948 that one may be behind.

use std::cell::Cell;
use std::rc::Rc;

use super::register_chip::{Action, Model, Registers, World, period_of_hz, put_16_bit_le};

/// A switch between two parts of one package.
pub type Switch = Rc<Cell<bool>>;

/// AK09916.
pub struct Ak09916Model {
    /// Whether it is on the bus.
    pub connected: Switch,
}

impl Default for Ak09916Model {
    fn default() -> Self {
        Self { connected: Rc::new(Cell::new(true)) }
    }
}

impl Model for Ak09916Model {
    fn power_up(&mut self, registers: &mut Registers) {
        (registers[0x00], registers[0x01]) = (0x48, 0x09);
    }

    fn answers(&self, _registers: &Registers, _ns: u64) -> bool {
        self.connected.get()
    }

    fn next(&self, pointer: u8) -> u8 {
        match pointer {
            0x18 => 0x00,
            0x32 => 0x30,
            other => other.wrapping_add(1),
        }
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x31 => 0x1f,
            0x32 => 0x01,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 0x32 && registers[0x32] & 1 != 0 {
            *registers = [0; 256];
            self.power_up(registers);
        }
        match (register, registers[0x31]) {
            // One measurement, also of the self-test, takes 7.2 ms.
            (0x31, 0x01 | 0x10) => Action::Once(7_200_000),
            (0x31, _) => Action::Restart,
            _ => Action::Settle,
        }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if (0x11..=0x18).contains(&register) {
            registers[0x10] = 0;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        match registers[0x31] {
            0x02 => period_of_hz(10.0),
            0x04 => period_of_hz(20.0),
            0x06 => period_of_hz(50.0),
            0x08 => period_of_hz(100.0),
            _ => None,
        }
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        if registers[0x31] == 0x10 {
            // What the test's own field makes: −500 counts on z.
            let mut test_ut = [1.5, -3.0, -75.0];
            if let Some(axis) = world.dead_axis {
                test_ut[axis] = if axis == 2 { 0.0 } else { 300.0 };
            }
            put_16_bit_le(registers, 0x11, [1.0 / 0.15; 3], test_ut);
            registers[0x18] = 0;
        } else {
            put_16_bit_le(registers, 0x11, [1.0 / 0.15; 3], world.field_ut);
            let sum: f64 = world.field_ut.iter().map(|ut| ut.abs()).sum();
            registers[0x18] = if sum >= 4912.0 { 0x08 } else { 0 };
        }
        registers[0x10] = if registers[0x10] & 1 != 0 { 3 } else { 1 };
        if matches!(registers[0x31], 0x01 | 0x10) {
            registers[0x31] = 0;
        }
    }
}

/// The rest of an ICM-20948, as far as its bypass.
#[derive(Default)]
pub struct Icm20948Model {
    /// To the magnetometer.
    pub bypass: Switch,
    /// Registers of banks 1 to 3 are not of this model: they read zero.
    bank: u8,
}

impl Model for Icm20948Model {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x00] = 0xea;
        // Asleep.
        registers[0x06] = 0x41;
        self.bypass.set(false);
        self.bank = 0;
    }

    fn writable(&self, register: u8) -> u8 {
        match (self.bank, register) {
            (_, 0x7f) => 0x30,
            (0, 0x03 | 0x06 | 0x0f) => 0xff,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, _byte: u8) -> Action {
        if register == 0x7f {
            self.bank = registers[0x7f] >> 4;
        }
        // Reset bits of the user control clear themselves.
        registers[0x03] &= 0xf0;
        let awake = registers[0x06] & 0x40 == 0;
        self.bypass.set(awake && registers[0x0f] & 0x02 != 0 && registers[0x03] & 0x20 == 0);
        Action::Settle
    }

    fn shown(&self, registers: &Registers, register: u8) -> u8 {
        if self.bank == 0 || register == 0x7f { registers[usize::from(register)] } else { 0 }
    }

    fn was_read(&mut self, _registers: &mut Registers, _register: u8) {}

    fn period_ns(&self, _registers: &Registers) -> Option<u64> {
        None
    }

    fn measure(&mut self, _registers: &mut Registers, _world: &World) {}
}
