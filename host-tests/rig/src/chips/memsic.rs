//! MMC5983MA and MMC5603.

use super::register_chip::{Action, Model, Registers, World, counts, period_of_hz};

/// MMC5983MA.
pub struct Mmc5983maModel {
    /// The offset of its bridges, µT: it does not turn around with SET and RESET, as the field does.
    pub offset_ut: [f64; 3],
    turned_around: bool,
    measures_temperature: bool,
}

impl Mmc5983maModel {
    /// A chip with this offset of its own.
    pub fn new(offset_ut: [f64; 3]) -> Self {
        Self { offset_ut, turned_around: false, measures_temperature: false }
    }
}

impl Model for Mmc5983maModel {
    fn power_up(&mut self, registers: &mut Registers) {
        registers[0x2f] = 0x30;
        (self.turned_around, self.measures_temperature) = (false, false);
    }

    fn writable(&self, register: u8) -> u8 {
        if (0x09..=0x0c).contains(&register) { 0xff } else { 0 }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, byte: u8) -> Action {
        match register {
            // Written ones clear.
            0x08 => registers[0x08] &= !(byte & 0x03),
            0x09 => {
                if byte & 0x08 != 0 {
                    self.turned_around = false;
                }
                if byte & 0x10 != 0 {
                    self.turned_around = true;
                }
                registers[0x09] &= 0x24;
                if byte & 0x02 != 0 {
                    self.measures_temperature = true;
                    registers[0x08] &= !0x02;
                    return Action::Once(1_000_000);
                }
                if byte & 0x01 != 0 {
                    registers[0x08] &= !0x01;
                    return Action::Once(
                        [8_000_000, 4_000_000, 2_000_000, 500_000][usize::from(registers[0x0a] & 3)],
                    );
                }
            }
            0x0a if byte & 0x80 != 0 => {
                *registers = [0; 256];
                self.power_up(registers);
            }
            0x0b => return Action::Restart,
            _ => {}
        }
        Action::Settle
    }

    fn shown(&self, registers: &Registers, register: u8) -> u8 {
        // The control registers can only be written.
        if (0x09..=0x0c).contains(&register) { 0 } else { registers[usize::from(register)] }
    }

    fn was_read(&mut self, _registers: &mut Registers, _register: u8) {}

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        if registers[0x0b] & 0x08 == 0 {
            return None;
        }
        let rate = usize::from(registers[0x0b] & 7);
        // The two fastest need their bandwidth.
        let fits = match rate {
            6 => registers[0x0a] & 3 >= 1,
            7 => registers[0x0a] & 3 == 3,
            _ => true,
        };
        if fits { period_of_hz([0.0, 1.0, 10.0, 20.0, 50.0, 100.0, 200.0, 1000.0][rate]) } else { None }
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        if std::mem::take(&mut self.measures_temperature) {
            registers[0x07] = ((world.temperature_c + 75.0) / 0.8).round().clamp(0.0, 255.0) as u8;
            registers[0x08] |= 0x02;
            return;
        }
        let sign = if self.turned_around { -1.0 } else { 1.0 };
        registers[0x06] = 0;
        for axis in 0..3 {
            let ut = sign * world.field_ut[axis] + self.offset_ut[axis];
            let (count, _) = counts(ut * 163.84 + 131_072.0, 0, 262_143);
            registers[2 * axis] = (count >> 10) as u8;
            registers[2 * axis + 1] = (count >> 2) as u8;
            registers[0x06] |= ((count & 3) as u8) << (6 - 2 * axis);
        }
        registers[0x08] |= 0x01;
    }
}

/// MMC5603.
pub struct Mmc5603Model {
    /// The offset of its bridges, µT: it does not turn around with SET and RESET, as the field does.
    pub offset_ut: [f64; 3],
    turned_around: bool,
    /// The current of a SET or RESET, which takes a millisecond.
    pulse: Option<u8>,
    measures: u8,
}

impl Mmc5603Model {
    /// A chip with this offset of its own.
    pub fn new(offset_ut: [f64; 3]) -> Self {
        Self { offset_ut, turned_around: true, pulse: None, measures: 0 }
    }
}

impl Model for Mmc5603Model {
    fn power_up(&mut self, registers: &mut Registers) {
        (registers[0x39], registers[0x18]) = (0x10, 0x10);
        (self.turned_around, self.pulse, self.measures) = (true, None, 0);
    }

    fn writable(&self, register: u8) -> u8 {
        if (0x1a..=0x1d).contains(&register) { 0xff } else { 0 }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, byte: u8) -> Action {
        match register {
            0x1b => {
                // All but the rate's bit and the automatic ones fall by themselves.
                registers[0x1b] &= 0xe0;
                if byte & 0x18 != 0 {
                    (self.pulse, self.measures) = (Some(byte & 0x18), 0);
                    return Action::Once(1_000_000);
                }
                self.measures = byte & 0x03;
                if byte & 0x02 != 0 {
                    registers[0x18] &= !0x80;
                    return Action::Once(1_200_000);
                }
                if byte & 0x01 != 0 {
                    registers[0x18] &= !0x40;
                    let bandwidth = usize::from(registers[0x1c] & 3);
                    return Action::Once([6_600_000, 3_500_000, 2_000_000, 1_200_000][bandwidth]);
                }
            }
            0x1c if byte & 0x80 != 0 => {
                *registers = [0; 256];
                self.power_up(registers);
            }
            0x1d => return Action::Restart,
            _ => {}
        }
        Action::Settle
    }

    fn shown(&self, registers: &Registers, register: u8) -> u8 {
        // Rate and control can only be written.
        if (0x1a..=0x1d).contains(&register) { 0 } else { registers[usize::from(register)] }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x08 {
            registers[0x18] &= !0x40;
        }
    }

    fn period_ns(&self, registers: &Registers) -> Option<u64> {
        let rate = registers[0x1a];
        if registers[0x1d] & 0x10 == 0 || registers[0x1b] & 0x80 == 0 {
            return None;
        }
        // Each rate needs its bandwidth.
        let fits = rate <= [75, 150, 255, 255][usize::from(registers[0x1c] & 3)];
        if fits { period_of_hz(f64::from(rate)) } else { None }
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        let wanted = std::mem::take(&mut self.measures);
        if let Some(pulse) = self.pulse.take() {
            // One that the next command cut short has turned nothing around.
            if wanted == 0 {
                self.turned_around = pulse & 0x10 != 0;
                return;
            }
        }
        if wanted & 0x02 != 0 {
            registers[0x09] = ((world.temperature_c + 75.0) / 0.8).round().clamp(0.0, 255.0) as u8;
            registers[0x18] |= 0x80;
            return;
        }
        let sign = if self.turned_around { -1.0 } else { 1.0 };
        for axis in 0..3 {
            let ut = sign * world.field_ut[axis] + self.offset_ut[axis];
            let (count, _) = counts(ut * 163.84 + 524_288.0, 0, 1_048_575);
            registers[2 * axis] = (count >> 12) as u8;
            registers[2 * axis + 1] = (count >> 4) as u8;
            registers[6 + axis] = ((count & 0x0f) as u8) << 4;
        }
        registers[0x18] |= 0x40;
    }
}
