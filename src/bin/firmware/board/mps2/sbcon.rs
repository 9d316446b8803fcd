//! I²C over SBCon, Arm's two-wire port: the program moves the lines itself.

use super::registers::Register;
use super::time;
use embedded_hal::i2c::{self, ErrorKind, I2c, NoAcknowledgeSource, Operation};

/// The "shield 1" port, on which the emulator puts every device of its `i2c-bus`.
const SHIELD1: usize = 0x4002_A000;
// SAFETY: SBCon's registers on the AN386 image; they only move two pins.
const LINES: Register = unsafe { Register::new(SHIELD1, 0) };
// SAFETY: as above.
const CLEAR: Register = unsafe { Register::new(SHIELD1, 4) };

const SCL: u32 = 1;
const SDA: u32 = 2;

/// Cycles of a quarter of a bit: with the loop's own instructions, a little under 400 kHz at 25 MHz.
const QUARTER_BIT_CYCLES: u32 = 16;

/// How long a device may hold the clock low. A sensor or an EEPROM does so for microseconds, if at all; 2 ms is far
/// from both that and the 20 ms between samples.
const STRETCH_LIMIT_US: u32 = 2_000;

/// Why a transfer failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum Error {
    /// No device answered the address.
    AddressNack,
    /// The device refused a byte of data.
    DataNack,
    /// A device held the clock low for longer than [`STRETCH_LIMIT_US`].
    ClockStuckLow,
    /// The data line stayed low, also after nine clocks to let a device finish its byte.
    DataStuckLow,
}

impl i2c::Error for Error {
    fn kind(&self) -> ErrorKind {
        match self {
            Error::AddressNack => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
            Error::DataNack => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
            Error::ClockStuckLow | Error::DataStuckLow => ErrorKind::Bus,
        }
    }
}

/// The bus. There is one: [`super::Board::take`] makes it.
pub struct Sbcon(());

impl Sbcon {
    /// Takes the lines into their idle state.
    pub(super) fn new() -> Self {
        let mut bus = Self(());
        LINES.write(SCL | SDA);
        quarter();
        // A reset in mid-transfer leaves a device waiting for clocks. A line that stays stuck is reported by the first
        // transfer, not here: the console has to work without a bus.
        let _ = bus.recover();
        bus
    }

    /// Clocks a device out of an unfinished byte, then ends the transfer.
    fn recover(&mut self) -> Result<(), Error> {
        for _ in 0..9 {
            if LINES.read() & SDA != 0 {
                break;
            }
            CLEAR.write(SCL);
            quarter();
            self.raise_clock()?;
        }
        self.stop()?;
        if LINES.read() & SDA == 0 { Err(Error::DataStuckLow) } else { Ok(()) }
    }

    /// Lets the clock go and waits until it is up: a device may stretch it.
    fn raise_clock(&mut self) -> Result<(), Error> {
        LINES.write(SCL);
        quarter();
        let start = time::counter();
        while LINES.read() & SCL == 0 {
            if time::counter().wrapping_sub(start) > STRETCH_LIMIT_US * time::TICKS_PER_US {
                return Err(Error::ClockStuckLow);
            }
        }
        Ok(())
    }

    /// A start, or in mid-transfer a repeated start.
    fn start(&mut self) -> Result<(), Error> {
        LINES.write(SDA);
        quarter();
        self.raise_clock()?;
        if LINES.read() & SDA == 0 {
            self.recover()?;
        }
        CLEAR.write(SDA);
        quarter();
        CLEAR.write(SCL);
        quarter();
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Error> {
        CLEAR.write(SDA);
        quarter();
        self.raise_clock()?;
        LINES.write(SDA);
        quarter();
        Ok(())
    }

    /// One bit out, and the line's state while the clock is up. Kept out of line: unrolled eight times over in every
    /// caller it would be most of the bus's code.
    #[inline(never)]
    fn bit(&mut self, high: bool) -> Result<bool, Error> {
        if high {
            LINES.write(SDA)
        } else {
            CLEAR.write(SDA)
        }
        quarter();
        self.raise_clock()?;
        let seen = LINES.read() & SDA != 0;
        quarter();
        CLEAR.write(SCL);
        quarter();
        Ok(seen)
    }

    /// A byte out; whether it was acknowledged.
    fn put(&mut self, byte: u8) -> Result<bool, Error> {
        for shift in (0..8).rev() {
            self.bit(byte >> shift & 1 != 0)?;
        }
        Ok(!self.bit(true)?)
    }

    /// A byte in, acknowledged unless it is the last one wanted.
    fn get(&mut self, acknowledge: bool) -> Result<u8, Error> {
        let mut byte = 0;
        for _ in 0..8 {
            byte = byte << 1 | u8::from(self.bit(true)?);
        }
        self.bit(!acknowledge)?;
        Ok(byte)
    }

    fn address(&mut self, address: u8, read: bool) -> Result<(), Error> {
        self.start()?;
        if self.put(address << 1 | u8::from(read))? { Ok(()) } else { Err(Error::AddressNack) }
    }

    fn run(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        let mut reading = None;
        for index in 0..operations.len() {
            // Adjacent operations of one direction are one run of bytes, without a start between them; only the last
            // byte of a run of reads is left unacknowledged.
            let more_to_read = operations
                .get(index + 1..)
                .unwrap_or(&[])
                .iter()
                .map_while(|next| match next {
                    Operation::Read(buffer) => Some(buffer.len()),
                    Operation::Write(_) => None,
                })
                .any(|len| len > 0);
            match operations.get_mut(index) {
                Some(Operation::Write(bytes)) => {
                    if reading != Some(false) {
                        self.address(address, false)?;
                        reading = Some(false);
                    }
                    for &byte in bytes.iter() {
                        if !self.put(byte)? {
                            return Err(Error::DataNack);
                        }
                    }
                }
                // A read of nothing is left out: after its address the device would drive the line, and no stop could
                // be made.
                Some(Operation::Read(buffer)) if !buffer.is_empty() => {
                    if reading != Some(true) {
                        self.address(address, true)?;
                        reading = Some(true);
                    }
                    let last = buffer.len() - 1;
                    for (at, slot) in buffer.iter_mut().enumerate() {
                        *slot = self.get(at < last || more_to_read)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl i2c::ErrorType for Sbcon {
    type Error = Error;
}

impl I2c for Sbcon {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        if operations.is_empty() {
            return Ok(());
        }
        let done = self.run(address, operations);
        // The bus is given back after an error too; the first error is the one to tell.
        let stopped = self.stop();
        done.and(stopped)
    }
}

/// A quarter of a bit.
#[inline]
fn quarter() {
    cortex_m::asm::delay(QUARTER_BIT_CYCLES);
}
