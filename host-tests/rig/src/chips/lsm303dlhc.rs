//! The magnetic half of an LSM303DLHC, as its datasheet describes it: registers, conversions, data ready.
//!
//! Stricter than the emulated chip of QEMU where the datasheet is: outputs change only with the data rate, data-ready falls
//! when they were read, an axis out of range reads −4096, temperature is left-justified, registers that are read-only stay as
//! they are, and the address pointer goes from 8 to 3 and from 12 and above to 0.

use ironout_drivers::lsm303dlhc::register as reg;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::bus::{Chip, Clock, Direction};
use crate::chips::field::FieldSource;

/// Data rates of register CRA, Hz.
const RATES_HZ: [f64; 8] = [0.75, 1.5, 3.0, 7.5, 15.0, 30.0, 75.0, 220.0];
/// Counts per gauss of x and y, and of z, by the range bits of register CRB. The first is not documented.
const GAINS: [(f64, f64); 8] = [
    (1100.0, 980.0),
    (1100.0, 980.0),
    (855.0, 760.0),
    (670.0, 600.0),
    (450.0, 400.0),
    (400.0, 355.0),
    (330.0, 295.0),
    (230.0, 205.0),
];
const LAST_OUTPUT: u8 = 0x08;
const REGISTERS: usize = 0x33;

/// The chip.
pub struct Lsm303dlhcChip {
    field: Box<dyn FieldSource>,
    noise_ut: f64,
    rng: ChaCha8Rng,
    /// °C.
    pub temperature_c: f64,
    registers: [u8; REGISTERS],
    pointer: u8,
    expects_pointer: bool,
    converting_since_ns: u64,
    conversions: u64,
}

impl Lsm303dlhcChip {
    /// A chip after power-up (asleep), in this field, with this noise on each axis and the noise's seed.
    pub fn new(field: impl FieldSource + 'static, noise_ut: f64, seed: u64) -> Self {
        let mut chip = Self {
            field: Box::new(field),
            noise_ut,
            rng: ChaCha8Rng::seed_from_u64(seed),
            temperature_c: 25.0,
            registers: [0; REGISTERS],
            pointer: 0,
            expects_pointer: false,
            converting_since_ns: 0,
            conversions: 0,
        };
        chip.power_cycle();
        chip
    }

    /// Puts the chip into another field.
    pub fn set_field(&mut self, field: impl FieldSource + 'static) {
        self.field = Box::new(field);
    }

    /// Loses the configuration, as after a dip of the supply.
    pub fn power_cycle(&mut self) {
        self.registers = [0; REGISTERS];
        self.registers[usize::from(reg::CRA)] = 0x10;
        self.registers[usize::from(reg::CRB)] = 0x20;
        self.registers[usize::from(reg::MR)] = 0x03;
        self.registers[usize::from(reg::IRA)..][..3].copy_from_slice(&reg::IDENTITY);
        self.conversions = 0;
    }

    /// Makes the chip identify itself as another one.
    pub fn set_identity(&mut self, identity: [u8; 3]) {
        self.registers[usize::from(reg::IRA)..][..3].copy_from_slice(&identity);
    }

    /// The level of the data-ready line: whether a conversion waits to be read.
    pub fn data_ready_line(&mut self, clock: &Clock) -> bool {
        self.convert(clock);
        self.register(reg::SR) & reg::SR_DRDY != 0
    }

    fn register(&self, register: u8) -> u8 {
        self.registers.get(usize::from(register)).copied().unwrap_or(0)
    }

    /// Does the conversions that were due up to now; the last one counts.
    fn convert(&mut self, clock: &Clock) {
        if self.register(reg::MR) & 0x03 != reg::MR_CONTINUOUS {
            return;
        }
        let rate_hz = RATES_HZ[usize::from(self.register(reg::CRA) >> 2 & 7)];
        let due = ((clock.ns() - self.converting_since_ns) as f64 * 1e-9 * rate_hz) as u64;
        if due <= self.conversions {
            return;
        }
        self.conversions = due;
        let t_s = self.converting_since_ns as f64 * 1e-9 + due as f64 / rate_hz;
        let field = self.field.field_ut(t_s);
        let (xy, z) = GAINS[usize::from(self.register(reg::CRB) >> 5)];
        let counts: [i16; 3] = core::array::from_fn(|axis| {
            let noise: f64 = StandardNormal.sample(&mut self.rng);
            let gauss = (field[axis] + self.noise_ut * noise) / 100.0;
            let count = (gauss * if axis == 2 { z } else { xy }).round();
            if (-2048.0..=2047.0).contains(&count) { count as i16 } else { reg::OVERFLOW }
        });
        for (place, count) in [counts[0], counts[2], counts[1]].into_iter().enumerate() {
            let at = usize::from(reg::OUT_X_H) + 2 * place;
            self.registers[at..at + 2].copy_from_slice(&count.to_be_bytes());
        }
        let celsius = ((self.temperature_c * 8.0).round() as i16) << 4;
        let enabled = self.register(reg::CRA) & reg::CRA_TEMP_EN != 0;
        let bytes = if enabled { celsius.to_be_bytes() } else { [0; 2] };
        self.registers[usize::from(reg::TEMP_OUT_H)..][..2].copy_from_slice(&bytes);
        self.registers[usize::from(reg::SR)] |= reg::SR_DRDY;
    }

    fn step_pointer(&mut self) {
        self.pointer = match self.pointer {
            LAST_OUTPUT => reg::OUT_X_H,
            12.. => 0,
            other => other + 1,
        };
    }
}

impl Chip for Lsm303dlhcChip {
    fn address(&self) -> u8 {
        reg::ADDRESS
    }

    fn start(&mut self, direction: Direction, clock: &Clock) -> bool {
        self.expects_pointer = direction == Direction::Write;
        // Between a start and a stop the outputs are held together.
        self.convert(clock);
        true
    }

    fn write(&mut self, byte: u8) -> bool {
        if self.expects_pointer {
            self.pointer = byte;
            self.expects_pointer = false;
            return true;
        }
        if self.pointer <= reg::MR {
            self.registers[usize::from(self.pointer)] = byte;
        }
        if self.pointer == reg::MR {
            self.conversions = u64::MAX;
        }
        self.step_pointer();
        true
    }

    fn read(&mut self) -> u8 {
        let byte = self.register(self.pointer);
        if self.pointer == LAST_OUTPUT {
            self.registers[usize::from(reg::SR)] &= !reg::SR_DRDY;
        }
        self.step_pointer();
        byte
    }

    fn stop(&mut self, clock: &Clock) {
        if self.conversions == u64::MAX {
            // The mode was written: conversions begin anew.
            self.converting_since_ns = clock.ns();
            self.conversions = 0;
        }
    }
}
