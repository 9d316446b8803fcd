//! A two-wire bus that a chip holds down, and one that two drivers share.

use core::cell::RefCell;
use critical_section::Mutex;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};

/// Clocks a chip out of an unfinished byte and ends the transfer. Both lines are open-drain outputs that can be read, let go; `half`
/// waits for half a bit.
///
/// # Errors
/// [`ErrorKind::Bus`] where a line is held down all the same.
pub fn free(
    clock: &mut (impl InputPin + OutputPin),
    data: &mut (impl InputPin + OutputPin),
    half: impl Fn(),
) -> Result<(), ErrorKind> {
    half();
    for _ in 0..9 {
        if data.is_high().unwrap_or(false) {
            break;
        }
        let _ = clock.set_low();
        half();
        let _ = clock.set_high();
        half();
    }
    // The stop condition.
    let _ = data.set_low();
    half();
    let _ = data.set_high();
    half();
    let is_free = clock.is_high().unwrap_or(false) && data.is_high().unwrap_or(false);
    if is_free { Ok(()) } else { Err(ErrorKind::Bus) }
}

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
