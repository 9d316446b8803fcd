//! A probing, the driver of whichever chip it finds, and its samples, for a microcontroller: it links if and only if none of it can
//! panic, because the panic handler calls a function that nowhere is.
//!
//! `cargo build --release --target thumbv6m-none-eabi`, and `thumbv7em-none-eabihf`.
#![no_std]
#![no_main]

use core::ptr::{read_volatile, write_volatile};
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
use ironout_drivers::{AnyMagnetometer, Magnetometer, probe};

unsafe extern "C" {
    /// Nowhere defined: whatever needs it does not link.
    fn a_driver_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never linked, so never called.
    unsafe { a_driver_can_panic() }
}

/// Somewhere that the optimiser knows nothing of.
const PORT: *mut u8 = 0x4000_0000 as *mut u8;

/// A byte of which nothing is known.
fn any_byte() -> u8 {
    // SAFETY: never run; at link time it is what keeps every answer of the bus possible.
    unsafe { read_volatile(PORT) }
}

fn out(byte: u8) {
    // SAFETY: as above.
    unsafe { write_volatile(PORT, byte) }
}

/// A bus that may answer anything.
struct AnyBus;

impl ErrorType for AnyBus {
    type Error = ErrorKind;
}

impl I2c for AnyBus {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        out(address);
        for operation in operations {
            match operation {
                Operation::Read(bytes) => bytes.iter_mut().for_each(|byte| *byte = any_byte()),
                Operation::Write(bytes) => bytes.iter().for_each(|&byte| out(byte)),
            }
            if any_byte() != 0 {
                return Err(ErrorKind::Bus);
            }
        }
        Ok(())
    }
}

struct AnyDelay;

impl DelayNs for AnyDelay {
    fn delay_ns(&mut self, ns: u32) {
        out(ns as u8);
    }
}

fn sample() -> Option<()> {
    let found = probe(&mut AnyBus, &mut AnyDelay).first()?;
    let mut sensor = AnyMagnetometer::new(AnyBus, AnyDelay, found);
    let description = sensor.describe();
    loop {
        sensor.init().ok()?;
        while any_byte() != 0 {
            if !sensor.data_ready().ok()? {
                continue;
            }
            let sample = description.sample(&sensor.read().ok()?);
            sample.counts.iter().flat_map(|count| count.to_le_bytes()).for_each(out);
            if let Some(field_ut) = description.measured_ut(sample) {
                field_ut.iter().flat_map(|ut| ut.to_bits().to_le_bytes()).for_each(out);
            }
            if let Some(celsius) = sensor.temperature_c().ok()? {
                celsius.to_bits().to_le_bytes().into_iter().for_each(out);
            }
        }
    }
}

/// The entry.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> ! {
    loop {
        let _ = sample();
    }
}
