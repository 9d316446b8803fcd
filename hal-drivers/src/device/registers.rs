//! Registers of a chip on a bus.

use super::mode::{I2c, both};
use crate::chip::description::Write;
use ironout_sensor::Error;

/// A chip's registers.
#[derive(Debug)]
pub struct Registers<I2C> {
    /// The bus.
    pub i2c: I2C,
    /// The chip's 7-bit address.
    pub address: u8,
    /// What is set in a register's address so that the chip goes on to the next.
    pub increment: u8,
}

#[both(AFIT)]
impl<I2C: I2c> Registers<I2C> {
    /// Reads from `first` on, all in one transaction.
    pub async fn read_into(&mut self, first: u8, bytes: &mut [u8]) -> Result<(), I2C::Error> {
        let first = if bytes.len() > 1 { first | self.increment } else { first };
        self.i2c.write_read(self.address, &[first], bytes).await
    }

    /// Reads `N` registers from `first` on, all in one transaction.
    pub async fn read<const N: usize>(&mut self, first: u8) -> Result<[u8; N], I2C::Error> {
        let mut bytes = [0; N];
        self.read_into(first, &mut bytes).await?;
        Ok(bytes)
    }

    /// Writes one register.
    pub async fn write(&mut self, register: u8, byte: u8) -> Result<(), I2C::Error> {
        self.i2c.write(self.address, &[register, byte]).await
    }

    /// Whether the chip is who it should be.
    pub async fn identify(&mut self, register: u8, bytes: &[u8]) -> Result<(), Error<I2C::Error>> {
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
    pub async fn configure(&mut self, writes: &[Write]) -> Result<(), Error<I2C::Error>> {
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

/// How many of `writes` are of neighbouring registers that can be read back; 1 at least.
fn run(writes: &[Write], most: usize) -> usize {
    let follow = |pair: &(&Write, &Write)| {
        let (before, after) = pair;
        before.register.checked_add(1) == Some(after.register) && before.kept != 0 && after.kept != 0
    };
    let pairs = writes.iter().zip(writes.iter().skip(1));
    (1 + pairs.take_while(follow).count()).min(most)
}
