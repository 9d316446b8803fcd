//! What all register chips have in common on the wire: a pointer, registers, and measurements in time.

use crate::bus::{Chip, Clock, Direction};
use crate::chips::field::FieldSource;

/// The registers of a chip.
pub type Registers = [u8; 256];

/// The world at the instant of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct World {
    /// The field along the chip's axes, µT.
    pub field_ut: [f64; 3],
    /// The chip's temperature, °C.
    pub temperature_c: f64,
    /// The axis whose sensing element does not answer to the chip's self-test.
    pub dead_axis: Option<usize>,
}

/// What a write makes a chip do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Nothing, or to measure at another rate.
    Settle,
    /// To begin its measurements anew.
    Restart,
    /// To measure once, which takes so long.
    Once(u64),
}

/// One kind of chip, from its datasheet.
pub trait Model {
    /// The registers after power-up.
    fn power_up(&mut self, registers: &mut Registers);
    /// Register, and whether the pointer goes on by itself, of a sub-address byte.
    fn pointer(&self, byte: u8) -> (u8, bool) {
        (byte, true)
    }
    /// The register after this one.
    fn next(&self, pointer: u8) -> u8 {
        pointer.wrapping_add(1)
    }
    /// Bytes without a meaning that it sends at each reading before those of its registers.
    fn dummies(&self) -> u8 {
        0
    }
    /// The bits of a register that can be written.
    fn writable(&self, register: u8) -> u8;
    /// Whether the chip acknowledges its address.
    fn answers(&self, _registers: &Registers, _ns: u64) -> bool {
        true
    }
    /// Follows a write of these bits.
    fn written(&mut self, registers: &mut Registers, register: u8, byte: u8) -> Action;
    /// What a register reads as.
    fn shown(&self, registers: &Registers, register: u8) -> u8 {
        registers[usize::from(register)]
    }
    /// Follows the reading of a register.
    fn was_read(&mut self, registers: &mut Registers, register: u8);
    /// Time between measurements, ns; `None` where it does not measure by itself.
    fn period_ns(&self, registers: &Registers) -> Option<u64>;
    /// One measurement.
    fn measure(&mut self, registers: &mut Registers, world: &World);
}

/// A chip on the bus.
pub struct RegisterChip<M> {
    address: u8,
    /// What kind it is.
    pub model: M,
    /// Its registers.
    pub registers: Registers,
    field: Box<dyn FieldSource>,
    /// °C.
    pub temperature_c: f64,
    /// The axis whose self-test fails.
    pub dead_axis: Option<usize>,
    /// Its measurements do not end any more, though it answers.
    pub frozen: bool,
    pointer: u8,
    goes_on: bool,
    expects_pointer: bool,
    dummies: u8,
    pending: Option<Action>,
    period_ns: Option<u64>,
    since_ns: u64,
    measured: u64,
    once_at_ns: Option<u64>,
}

impl<M: Model> RegisterChip<M> {
    /// A chip of this kind at this address, powered up, in this field.
    pub fn new(address: u8, model: M, field: impl FieldSource + 'static) -> Self {
        let mut chip = Self {
            address,
            model,
            registers: [0; 256],
            field: Box::new(field),
            temperature_c: 25.0,
            dead_axis: None,
            frozen: false,
            pointer: 0,
            goes_on: true,
            expects_pointer: false,
            dummies: 0,
            pending: None,
            period_ns: None,
            since_ns: 0,
            measured: 0,
            once_at_ns: None,
        };
        chip.power_cycle();
        chip
    }

    /// Loses its configuration, as after a dip of the supply.
    pub fn power_cycle(&mut self) {
        self.registers = [0; 256];
        self.model.power_up(&mut self.registers);
        (self.period_ns, self.once_at_ns, self.pending) = (None, None, None);
    }

    /// Puts it into another field.
    pub fn set_field(&mut self, field: impl FieldSource + 'static) {
        self.field = Box::new(field);
    }

    fn measure_at(&mut self, ns: u64) {
        let world = World {
            field_ut: self.field.field_ut(ns as f64 * 1e-9),
            temperature_c: self.temperature_c,
            dead_axis: self.dead_axis,
        };
        self.model.measure(&mut self.registers, &world);
    }

    /// What was measured up to now; only the last of it is still there.
    fn catch_up(&mut self, now_ns: u64) {
        if self.frozen {
            return;
        }
        if let Some(at) = self.once_at_ns.filter(|&at| at <= now_ns) {
            self.once_at_ns = None;
            self.measure_at(at);
            // What was done once may be the change to another mode.
            let period = self.model.period_ns(&self.registers);
            if period != self.period_ns {
                (self.period_ns, self.since_ns, self.measured) = (period, at, 0);
            }
        }
        if let Some(period) = self.period_ns {
            let number = (now_ns - self.since_ns) / period;
            // The last two: some chips carry a setting from one into the next.
            for number in (self.measured + 1).max(number.saturating_sub(1))..=number {
                self.measured = number;
                self.measure_at(self.since_ns + number * period);
            }
        }
    }
}

impl<M: Model> Chip for RegisterChip<M> {
    fn address(&self) -> u8 {
        self.address
    }

    fn start(&mut self, direction: Direction, clock: &Clock) -> bool {
        // Between a start and a stop the registers are held together.
        self.catch_up(clock.ns());
        self.expects_pointer = direction == Direction::Write;
        self.dummies = self.model.dummies();
        self.model.answers(&self.registers, clock.ns())
    }

    fn write(&mut self, byte: u8) -> bool {
        if self.expects_pointer {
            (self.pointer, self.goes_on) = self.model.pointer(byte);
            self.expects_pointer = false;
            return true;
        }
        let mask = self.model.writable(self.pointer);
        let register = &mut self.registers[usize::from(self.pointer)];
        *register = *register & !mask | byte & mask;
        let action = self.model.written(&mut self.registers, self.pointer, byte);
        self.pending = match self.pending {
            Some(earlier) if action == Action::Settle => Some(earlier),
            _ => Some(action),
        };
        if self.goes_on {
            self.pointer = self.model.next(self.pointer);
        }
        true
    }

    fn read(&mut self) -> u8 {
        if self.dummies > 0 {
            self.dummies -= 1;
            return 0x7f;
        }
        let byte = self.model.shown(&self.registers, self.pointer);
        self.model.was_read(&mut self.registers, self.pointer);
        if self.goes_on {
            self.pointer = self.model.next(self.pointer);
        }
        byte
    }

    fn stop(&mut self, clock: &Clock) {
        let Some(action) = self.pending.take() else { return };
        let period = self.model.period_ns(&self.registers);
        if period != self.period_ns || action == Action::Restart {
            (self.period_ns, self.since_ns, self.measured) = (period, clock.ns(), 0);
        }
        if let Action::Once(duration) = action {
            self.once_at_ns = Some(clock.ns() + duration);
        }
    }
}

/// A period of a rate.
pub fn period_of_hz(hz: f64) -> Option<u64> {
    (hz > 0.0).then(|| (1e9 / hz) as u64)
}

/// Whole counts between two ends, and whether the field was beyond them.
pub fn counts(value: f64, least: i32, most: i32) -> (i32, bool) {
    let rounded = value.round();
    (
        rounded.clamp(f64::from(least), f64::from(most)) as i32,
        rounded < f64::from(least) || rounded > f64::from(most),
    )
}

/// 16-bit outputs of this scale, low byte first, from `first` on; whether any axis was beyond the range.
pub fn put_16_bit_le(registers: &mut Registers, first: u8, per_ut: [f64; 3], field_ut: [f64; 3]) -> bool {
    let mut beyond = false;
    for axis in 0..3 {
        let (count, clipped) = counts(field_ut[axis] * per_ut[axis], -32768, 32767);
        beyond |= clipped;
        let at = usize::from(first) + 2 * axis;
        registers[at..at + 2].copy_from_slice(&(count as i16).to_le_bytes());
    }
    beyond
}

/// The field with a self-test's own on top, which a dead axis lacks.
pub fn with_test_field(world: &World, test_ut: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        world.field_ut[axis] + if world.dead_axis == Some(axis) { 0.0 } else { test_ut[axis] }
    })
}
