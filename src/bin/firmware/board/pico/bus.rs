//! I²C 0 with a limit on every transfer, and a way out where a chip holds a line down.

use super::time::now_us;
use crate::board::lines;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embassy_rp::gpio::{Level, OutputOpenDrain};
use embassy_rp::i2c::{Async, Config, I2c, InterruptHandler};
use embassy_rp::interrupt::InterruptExt;
use embassy_rp::peripherals::{I2C0, PIN_4, PIN_5};
use embassy_rp::{Peri, bind_interrupts, pac};
use embedded_hal::i2c::{self, ErrorKind, Operation};

/// How long a transaction may take. A sample is 0.3 ms on the wire, and a chip stretches the clock for microseconds, if at all.
const LIMIT_US: u64 = 3_000;

/// How long a stop may take: some bits.
const STOP_LIMIT_US: u64 = 100;

/// Half a bit of the clocks that free a line, at 100 kHz: some cycles of 125 MHz.
const HALF_BIT_CYCLES: u32 = 625;

bind_interrupts!(struct Irqs {
    I2C0_IRQ => InterruptHandler<I2C0>;
});

/// The bus. The driver of the HAL is made anew after an error, because nothing else ends a transfer that hangs.
pub struct Bus {
    i2c: Option<I2c<'static, I2C0, Async>>,
    // They are lent to the HAL's driver and taken back when that is dropped.
    pins: (Peri<'static, I2C0>, Peri<'static, PIN_5>, Peri<'static, PIN_4>),
}

impl Bus {
    /// A bus that is set up by its first transfer. Idle lines need no more than their pull-ups.
    pub(super) fn new(
        i2c: Peri<'static, I2C0>,
        clock: Peri<'static, PIN_5>,
        data: Peri<'static, PIN_4>,
    ) -> Self {
        Self { i2c: None, pins: (i2c, clock, data) }
    }

    /// Clocks a chip out of an unfinished byte, ends the transfer, and begins anew.
    fn free(&mut self) -> Result<(), ErrorKind> {
        self.i2c = None;
        let (_, clock, data) = &mut self.pins;
        let mut clock = OutputOpenDrain::new(clock.reborrow(), Level::High);
        let mut data = OutputOpenDrain::new(data.reborrow(), Level::High);
        clock.set_pullup(true);
        data.set_pullup(true);
        lines::free(&mut clock, &mut data, || cortex_m::asm::delay(HALF_BIT_CYCLES))
    }

    fn set_up(&mut self) -> Result<&mut I2c<'static, I2C0, Async>, ErrorKind> {
        if self.i2c.is_none() {
            self.free()?;
            let mut config = Config::default();
            config.frequency = 400_000;
            // SAFETY: the driver of these very peripherals was dropped by `free`, and the next is made after that only.
            let (i2c, clock, data) = unsafe {
                let (i2c, clock, data) = &self.pins;
                (i2c.clone_unchecked(), clock.clone_unchecked(), data.clone_unchecked())
            };
            self.i2c = Some(I2c::new_async(i2c, clock, data, Irqs, config));
            // Transfers are polled to their end: the sampler runs in an interrupt, and their own would only wake nobody.
            embassy_rp::interrupt::I2C0_IRQ.disable();
        }
        self.i2c.as_mut().ok_or(ErrorKind::Other)
    }
}

impl i2c::ErrorType for Bus {
    type Error = ErrorKind;
}

impl i2c::I2c for Bus {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let driver = self.set_up()?;
        let transfer = embedded_hal_async::i2c::I2c::transaction(driver, address, operations);
        let done = within(LIMIT_US, transfer);
        match done {
            Some(Ok(())) => Ok(()),
            Some(Err(error)) => {
                let kind = i2c::Error::kind(&error);
                // After a missing acknowledgement the bus will be idle; after anything else nobody knows.
                if !matches!(kind, ErrorKind::NoAcknowledge(_)) || !settles() {
                    self.i2c = None;
                }
                Err(kind)
            }
            None => {
                self.i2c = None;
                Err(ErrorKind::Bus)
            }
        }
    }
}

/// Waits for the stop that the port makes by itself after a missing acknowledgement, and forgets it; whether it came. The HAL's
/// driver returns before, and would take this stop for that of its next transfer.
fn settles() -> bool {
    let end_us = now_us() + STOP_LIMIT_US;
    while pac::I2C0.ic_status().read().mst_activity() {
        if now_us() > end_us {
            return false;
        }
    }
    pac::I2C0.ic_clr_intr().read();
    true
}

/// What comes of `transfer`, or nothing where it takes longer.
fn within<T>(limit_us: u64, transfer: impl Future<Output = T>) -> Option<T> {
    let mut transfer = pin!(transfer);
    let mut context = Context::from_waker(Waker::noop());
    let end_us = now_us() + limit_us;
    loop {
        if let Poll::Ready(done) = transfer.as_mut().poll(&mut context) {
            return Some(done);
        }
        if now_us() > end_us {
            return None;
        }
    }
}
