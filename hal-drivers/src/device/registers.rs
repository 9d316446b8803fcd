//! Registers of a chip on its wires.

use super::mode::{I2c, SpiDevice, both};
use crate::chip::description::Write;
use embedded_hal::spi::Operation;
use ironout_sensor::Error;

/// A chip's registers on an I²C bus.
#[derive(Debug)]
pub struct Registers<I2C> {
    /// The bus.
    pub i2c: I2C,
    /// The chip's 7-bit address.
    pub address: u8,
    /// What is set in a register's address so that the chip goes on to the next.
    pub increment: u8,
    /// Bytes without a meaning before those that are read.
    pub dummies: u8,
}

/// The most bytes of one reading from a chip that sends [`Registers::dummies`] first, with these.
const WITH_DUMMIES: usize = 16;

/// A chip's registers on SPI, as ST's chips have them: bit 7 of the first byte reads, bit 6 goes on to the next register.
#[derive(Debug)]
pub struct SpiRegisters<SPI> {
    /// The chip on its bus, with its chip select.
    pub spi: SPI,
}

const SPI_READ: u8 = 1 << 7;
const SPI_INCREMENT: u8 = 1 << 6;

/// Wires to registers.
#[both(AFIT)]
#[allow(
    async_fn_in_trait,
    reason = "a driver is awaited where it is made: no executor needs to move its futures"
)]
pub trait Wires {
    /// The error of the bus.
    type Error;

    /// Reads from `first` on, all in one transaction.
    ///
    /// # Errors
    /// Those of the bus.
    async fn read_into(&mut self, first: u8, bytes: &mut [u8]) -> Result<(), Self::Error>;

    /// Writes one register.
    ///
    /// # Errors
    /// Those of the bus.
    async fn write(&mut self, register: u8, byte: u8) -> Result<(), Self::Error>;

    /// Reads `N` registers from `first` on, all in one transaction.
    ///
    /// # Errors
    /// Those of the bus.
    async fn read<const N: usize>(&mut self, first: u8) -> Result<[u8; N], Self::Error> {
        let mut bytes = [0; N];
        self.read_into(first, &mut bytes).await?;
        Ok(bytes)
    }

    /// Whether the chip is who it should be, by one to three bytes from a register on.
    ///
    /// # Errors
    /// Those of the bus, and [`Error::NotFound`].
    async fn identify(&mut self, register: u8, bytes: &[u8]) -> Result<(), Error<Self::Error>> {
        let (mut expected, mut found) = ([0; 3], [0; 3]);
        let told = bytes.len().min(3);
        for (to, from) in expected.iter_mut().zip(bytes) {
            *to = *from;
        }
        if let Some(found) = found.get_mut(..told) {
            self.read_into(register, found).await?;
        }
        if found == expected { Ok(()) } else { Err(Error::NotFound { expected, found }) }
    }

    /// Writes a configuration, one register a transaction (not every chip increments its pointer on writing), and reads it back,
    /// neighbours together.
    ///
    /// # Errors
    /// Those of the bus, and [`Error::NotKept`].
    async fn configure(&mut self, writes: &[Write]) -> Result<(), Error<Self::Error>> {
        for write in writes {
            self.write(write.register, write.byte).await?;
        }
        let mut rest = writes;
        while let Some(first) = rest.first() {
            let mut read = [0; 8];
            let run = run(rest, read.len());
            let (now, after) = rest.split_at_checked(run).unwrap_or((rest, &[]));
            rest = after;
            if first.kept == 0 {
                continue;
            }
            if let Some(read) = read.get_mut(..run) {
                self.read_into(first.register, read).await?;
            }
            for (write, &read) in now.iter().zip(&read) {
                if (read ^ write.byte) & write.kept != 0 {
                    return Err(Error::NotKept { register: write.register, written: write.byte, read });
                }
            }
        }
        Ok(())
    }
}

#[both(AFIT)]
impl<I2C: I2c> Wires for Registers<I2C> {
    type Error = I2C::Error;

    async fn read_into(&mut self, first: u8, bytes: &mut [u8]) -> Result<(), I2C::Error> {
        let first = if bytes.len() > 1 { first | self.increment } else { first };
        if self.dummies == 0 {
            return self.i2c.write_read(self.address, &[first], bytes).await;
        }
        let dummies = usize::from(self.dummies);
        let mut all = [0; WITH_DUMMIES];
        if let Some(all) = all.get_mut(..(dummies + bytes.len()).min(WITH_DUMMIES)) {
            self.i2c.write_read(self.address, &[first], all).await?;
        }
        for (to, from) in bytes.iter_mut().zip(all.iter().skip(dummies)) {
            *to = *from;
        }
        Ok(())
    }

    async fn write(&mut self, register: u8, byte: u8) -> Result<(), I2C::Error> {
        self.i2c.write(self.address, &[register, byte]).await
    }
}

#[both(AFIT)]
impl<SPI: SpiDevice> Wires for SpiRegisters<SPI> {
    type Error = SPI::Error;

    async fn read_into(&mut self, first: u8, bytes: &mut [u8]) -> Result<(), SPI::Error> {
        let increment = if bytes.len() > 1 { SPI_INCREMENT } else { 0 };
        let first = [first | SPI_READ | increment];
        self.spi.transaction(&mut [Operation::Write(&first), Operation::Read(bytes)]).await
    }

    async fn write(&mut self, register: u8, byte: u8) -> Result<(), SPI::Error> {
        self.spi.write(&[register, byte]).await
    }
}

/// How many of `writes` are of neighbouring registers that can be read back; 1 at least.
fn run(writes: &[Write], most: usize) -> usize {
    let follow = |pair: &(&Write, &Write)| {
        let (before, after) = pair;
        before.register.checked_add(1) == Some(after.register) && before.kept != 0 && after.kept != 0
    };
    let pairs = writes.iter().zip(writes.iter().skip(1));
    (1 + pairs.take_while(follow).count()).min(most)
}
