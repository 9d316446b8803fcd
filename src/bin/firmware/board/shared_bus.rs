//! A bus that several drivers use, all in one interrupt.

use core::cell::RefCell;
use critical_section::Mutex;
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};

/// The place of a bus that several drivers use, all in one interrupt.
pub struct Place<B>(Mutex<RefCell<Option<B>>>);

impl<B> Place<B> {
    /// An empty one.
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// Puts the bus there; its users.
    pub fn put(&'static self, bus: B) -> Shared<B> {
        critical_section::with(|section| self.0.borrow(section).replace(Some(bus)));
        Shared(self)
    }
}

/// One user's share of the bus.
pub struct Shared<B: 'static>(&'static Place<B>);

impl<B> Clone for Shared<B> {
    fn clone(&self) -> Self {
        Self(self.0)
    }
}

impl<B> ErrorType for Shared<B> {
    type Error = ErrorKind;
}

impl<B: I2c<Error = ErrorKind>> I2c for Shared<B> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        // Taken out for the time of its work, so that other interrupts go on meanwhile.
        let bus = critical_section::with(|section| self.0.0.borrow(section).take());
        let Some(mut bus) = bus else { return Err(ErrorKind::ArbitrationLoss) };
        let done = bus.transaction(address, operations);
        critical_section::with(|section| self.0.0.borrow(section).replace(Some(bus)));
        done
    }
}
