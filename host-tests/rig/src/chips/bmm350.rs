//! BMM350, with its OTP memory: what its registers hold is the field before compensation, and after a strong field an offset.

use super::register_chip::{Action, Model, Registers, World, counts, period_of_hz};

/// What the OTP memory of a chip says, in its own units.
#[derive(Clone, Copy, Debug)]
pub struct OtpMemory {
    /// Offset, µT.
    pub offset: [i16; 3],
    /// Sensitivity, 1/256.
    pub sensitivity: [i8; 3],
    /// Coefficient of temperature of the offset, 1/32 µT/°C.
    pub offset_drift: [i8; 3],
    /// Coefficient of temperature of the sensitivity, 1/16384 per °C.
    pub sensitivity_drift: [i8; 3],
    /// y in x, x in y, x in z, y in z, 1/800.
    pub cross: [i8; 4],
    /// Offset (1/5 °C) and sensitivity (1/512) of the temperature.
    pub celsius: (i8, i8),
    /// The temperature of the trimming, 1/512 °C from 23 °C.
    pub reference: i16,
}

impl Default for OtpMemory {
    /// Every term at work, and both signs.
    fn default() -> Self {
        Self {
            offset: [-37, 121, -1450],
            sensitivity: [-9, 14, 5],
            offset_drift: [12, -20, 7],
            sensitivity_drift: [-31, 18, -6],
            cross: [11, -7, 16, -23],
            celsius: (-8, 13),
            reference: -700,
        }
    }
}

impl OtpMemory {
    fn word(&self, address: u8) -> u16 {
        let byte = |low: i8, high: i8| u16::from_le_bytes([low as u8, high as u8]);
        let [x, y, z] = self.offset.map(|offset| offset as u16 & 0x0fff);
        match address {
            0x0d => byte(self.celsius.0, self.celsius.1),
            0x0e => x | (y & 0x0f00) << 4,
            0x0f => y & 0x00ff | z & 0x0f00,
            0x10 => z & 0x00ff | u16::from(self.sensitivity[0] as u8) << 8,
            0x11 => byte(self.sensitivity[1], self.sensitivity[2]),
            0x12..=0x14 => {
                let axis = usize::from(address - 0x12);
                byte(self.offset_drift[axis], self.sensitivity_drift[axis])
            }
            0x15 => byte(self.cross[0], self.cross[1]),
            0x16 => byte(self.cross[2], self.cross[3]),
            0x18 => self.reference as u16,
            // What else is in the memory is nobody's business.
            _ => 0x5a5a,
        }
    }
}

/// What the chip is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    None,
    Start,
    Word(u8),
    Command(u8),
}

/// BMM350.
pub struct Bmm350Model {
    memory: OtpMemory,
    /// The offset that a strong field left, µT; a bit reset and then a flux-guide reset take it out.
    pub magnetised_ut: [f64; 3],
    bit_was_reset: bool,
    task: Task,
    /// Rate and averaging as taken over.
    aggregation: u8,
    awake: bool,
}

impl Bmm350Model {
    /// A chip with this memory, suspended, magnetised like this.
    pub fn new(memory: OtpMemory, magnetised_ut: [f64; 3]) -> Self {
        Self {
            memory,
            magnetised_ut,
            bit_was_reset: false,
            task: Task::None,
            aggregation: 0x14,
            awake: false,
        }
    }
}

impl Model for Bmm350Model {
    fn power_up(&mut self, registers: &mut Registers) {
        (registers[0x00], registers[0x04]) = (0x33, 0x14);
        (self.bit_was_reset, self.task, self.aggregation, self.awake) = (false, Task::None, 0x14, false);
    }

    fn dummies(&self) -> u8 {
        2
    }

    fn writable(&self, register: u8) -> u8 {
        match register {
            0x04 => 0x3f,
            0x05 => 0x07,
            0x06 => 0x0f,
            0x2e => 0x8f,
            0x50 => 0xff,
            _ => 0,
        }
    }

    fn written(&mut self, registers: &mut Registers, register: u8, byte: u8) -> Action {
        match register {
            0x7e if byte == 0xb6 => {
                *registers = [0; 256];
                self.power_up(registers);
                // While it starts it has no identity.
                registers[0x00] = 0;
                self.task = Task::Start;
                Action::Once(23_000_000)
            }
            0x50 => {
                registers[0x55] = 0;
                if byte & 0xe0 == 0x20 {
                    self.task = Task::Word(byte & 0x1f);
                    return Action::Once(400_000);
                }
                if byte != 0x80 {
                    registers[0x55] = 0xa0;
                }
                Action::Settle
            }
            0x06 => {
                let command = registers[0x06];
                let takes_ns = match command {
                    0 => 5_000_000,
                    1 => 28_000_000,
                    2 => 900_000,
                    5 => 17_500_000,
                    7 => 13_500_000,
                    _ => 0,
                };
                let resets_awake = matches!(command, 5..=8) && self.awake;
                if takes_ns == 0 || resets_awake {
                    registers[0x07] |= 0x10;
                    return Action::Settle;
                }
                registers[0x07] |= 1;
                self.task = Task::Command(command);
                Action::Once(takes_ns)
            }
            _ => Action::Settle,
        }
    }

    fn was_read(&mut self, registers: &mut Registers, register: u8) {
        if register == 0x30 {
            registers[0x30] &= !0x04;
        }
    }

    fn period_ns(&self, _registers: &Registers) -> Option<u64> {
        if !self.awake {
            return None;
        }
        let rate = self.aggregation & 0x0f;
        if !(2..=10).contains(&rate) { None } else { period_of_hz(1600.0 / f64::from(1_u32 << rate)) }
    }

    fn measure(&mut self, registers: &mut Registers, world: &World) {
        match std::mem::replace(&mut self.task, Task::None) {
            Task::Start => return registers[0x00] = 0x33,
            Task::Word(address) => {
                let [high, low] = self.memory.word(address).to_be_bytes();
                (registers[0x52], registers[0x53], registers[0x55]) = (high, low, 1);
                return;
            }
            Task::Command(command) => {
                match command {
                    0 => self.awake = false,
                    1 => self.awake = true,
                    2 => self.aggregation = registers[0x04],
                    5 if self.bit_was_reset => self.magnetised_ut = [0.0; 3],
                    7 => self.bit_was_reset = true,
                    _ => {}
                }
                registers[0x07] = command << 5 | if self.awake { 0x08 } else { 0 };
                return;
            }
            Task::None => {}
        }
        // The compensation that Bosch publishes, turned around.
        let OtpMemory { offset, sensitivity, offset_drift, sensitivity_drift, cross, celsius, reference } =
            self.memory;
        let warmer = world.temperature_c - (f64::from(reference) / 512.0 + 23.0);
        let [y_in_x, x_in_y, x_in_z, y_in_z] = cross.map(|part| f64::from(part) / 800.0);
        let [bx, by, bz] = world.field_ut;
        let mixed = [bx + y_in_x * by, by + x_in_y * bx, bz + x_in_z * bx + y_in_z * by];
        let soldered = [(0.0, 0.0), (0.01, 0.0), (0.0, -0.0001)];
        for axis in 0..3 {
            let drift = f64::from(sensitivity_drift[axis]) / 16_384.0 + soldered[axis].1;
            let uncompensated = mixed[axis] * (1.0 + drift * warmer)
                - f64::from(offset_drift[axis]) / 32.0 * warmer
                - f64::from(offset[axis])
                + self.magnetised_ut[axis];
            let scale = 1.0 + f64::from(sensitivity[axis]) / 256.0 + soldered[axis].0;
            let per_count = [0.007_069_979, 0.007_069_979, 0.007_174_964][axis];
            let (count, _) = counts(uncompensated / scale / per_count, -1_048_576, 1_048_575);
            registers[0x31 + 3 * axis..0x34 + 3 * axis].copy_from_slice(&count.to_le_bytes()[..3]);
        }
        let (zero, scale) = (f64::from(celsius.0) / 5.0, 1.0 + f64::from(celsius.1) / 512.0);
        let (count, _) =
            counts(((world.temperature_c - zero) / scale + 25.49) / 0.000_981_282, -8_388_608, 8_388_607);
        registers[0x3a..0x3d].copy_from_slice(&count.to_le_bytes()[..3]);
        if registers[0x2e] & 0x80 != 0 {
            registers[0x30] |= 0x04;
        }
    }
}
