//! A simulated I²C bus: register-level chips behind the `I2c` trait that the drivers are written against.
//!
//! The bus works byte by byte and in simulated time. Each byte takes nine bits at 400 kHz, and a chip sees start, address, bytes
//! and stop as the real one would; an address nobody listens to is not acknowledged.

mod fault;

pub use fault::{FaultControl, Faulty, Hit};

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};

/// Nine bits at 400 kHz.
const BYTE_NS: u64 = 22_500;

/// The simulated time, shared by everything on a board.
#[derive(Clone, Debug, Default)]
pub struct Clock(Rc<Cell<u64>>);

impl Clock {
    /// Nanoseconds since power-up.
    pub fn ns(&self) -> u64 {
        self.0.get()
    }

    /// Whole milliseconds since power-up.
    pub fn ms(&self) -> u64 {
        self.ns() / 1_000_000
    }

    /// Seconds since power-up.
    pub fn s(&self) -> f64 {
        self.ns() as f64 * 1e-9
    }

    /// Lets time pass.
    pub fn advance_ns(&self, ns: u64) {
        self.0.set(self.ns() + ns);
    }

    /// Lets time pass up to `ms`; a time already past changes nothing.
    pub fn advance_to_ms(&self, ms: u64) {
        self.0.set(self.ns().max(ms * 1_000_000));
    }
}

/// What a start condition asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Bytes to the chip.
    Write,
    /// Bytes from the chip.
    Read,
}

/// A chip on the bus, at the level of bytes on the wire.
pub trait Chip {
    /// Its 7-bit address.
    fn address(&self) -> u8;
    /// A (repeated) start with this chip's address. Returns whether it acknowledges.
    fn start(&mut self, direction: Direction, clock: &Clock) -> bool;
    /// A byte to the chip. Returns whether it acknowledges.
    fn write(&mut self, byte: u8) -> bool;
    /// A byte from the chip.
    fn read(&mut self) -> u8;
    /// The stop condition.
    fn stop(&mut self, clock: &Clock);
}

type Chips = Rc<RefCell<Vec<Rc<RefCell<dyn Chip>>>>>;

/// The bus. Clones share the wires, so that several drivers can own one.
#[derive(Clone, Default)]
pub struct SimBus {
    clock: Clock,
    chips: Chips,
}

impl SimBus {
    /// A bus without chips.
    pub fn new(clock: Clock) -> Self {
        Self { clock, chips: Rc::default() }
    }

    /// Puts a chip on the bus; the caller may keep a handle to it.
    pub fn attach(&self, chip: Rc<RefCell<dyn Chip>>) {
        self.chips.borrow_mut().push(chip);
    }

    /// Takes the chip at `address` off the bus.
    pub fn detach(&self, address: u8) {
        self.chips.borrow_mut().retain(|chip| chip.borrow().address() != address);
    }

    fn chip(&self, address: u8) -> Option<Rc<RefCell<dyn Chip>>> {
        self.chips.borrow().iter().find(|chip| chip.borrow().address() == address).cloned()
    }
}

impl ErrorType for SimBus {
    type Error = ErrorKind;
}

impl I2c for SimBus {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let byte_passes = || self.clock.advance_ns(BYTE_NS);
        let Some(chip) = self.chip(address) else {
            byte_passes();
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        };
        let mut chip = chip.borrow_mut();
        let mut result = Ok(());
        let mut last = None;
        'bus: for operation in operations {
            let direction = match operation {
                Operation::Write(_) => Direction::Write,
                Operation::Read(_) => Direction::Read,
            };
            // Adjacent operations of one direction are one run of bytes; a change is a repeated start.
            if last != Some(direction) {
                byte_passes();
                if !chip.start(direction, &self.clock) {
                    result = Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
                    break;
                }
                last = Some(direction);
            }
            match operation {
                Operation::Write(bytes) => {
                    for &byte in bytes.iter() {
                        byte_passes();
                        if !chip.write(byte) {
                            result = Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data));
                            break 'bus;
                        }
                    }
                }
                Operation::Read(bytes) => {
                    for byte in bytes.iter_mut() {
                        byte_passes();
                        *byte = chip.read();
                    }
                }
            }
        }
        chip.stop(&self.clock);
        result
    }
}
