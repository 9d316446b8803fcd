//! 24-series I²C EEPROM with two-byte addresses (AT24C32 … AT24C512): where a calibration is kept.
//!
//! The driver splits writes at page borders, because a chip wraps *within* a page and would overwrite the
//! page's beginning, and waits out the write time by acknowledge polling: while it writes (about 5 ms), the chip
//! does not answer to its address.

use core::fmt;

use embedded_hal::i2c::{Error as _, ErrorKind, I2c};
use embedded_storage::{ReadStorage, Storage};

/// The largest page of the family (AT24C512).
pub const MAX_PAGE_BYTES: usize = 128;

/// Which chip it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Geometry {
    /// Bus address, 7 bits: 0x50 to 0x57 by the chip's pins.
    pub address: u8,
    /// Size in bytes, at most 65 536.
    pub size_bytes: u32,
    /// Page size in bytes, a power of two and at most [`MAX_PAGE_BYTES`].
    pub page_bytes: u8,
}

impl Geometry {
    /// AT24C32: 4096 bytes in pages of 32, at address 0x50.
    pub const AT24C32: Self = Self { address: 0x50, size_bytes: 4096, page_bytes: 32 };
    /// AT24C256: 32 768 bytes in pages of 64, at address 0x50.
    pub const AT24C256: Self = Self { address: 0x50, size_bytes: 32_768, page_bytes: 64 };
}

/// Why the EEPROM could not be read or written. `E` is the error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EepromError<E> {
    /// The bus failed.
    Bus(E),
    /// The chip does not answer, for longer than any page takes to write: it is not there.
    Timeout,
    /// The range reaches beyond the end of the chip.
    OutOfRange {
        /// First byte asked for.
        offset: u32,
        /// Number of bytes asked for.
        bytes: u32,
    },
    /// The geometry is none of this family; the text says what is wrong with it.
    InvalidConfig(&'static str),
}

impl<E: fmt::Debug> fmt::Display for EepromError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EepromError::Bus(error) => write!(f, "bus error {error:?}"),
            EepromError::Timeout => f.write_str("no answer"),
            EepromError::OutOfRange { offset, bytes } => {
                write!(f, "{bytes} bytes at {offset:#06x} reach beyond the end")
            }
            EepromError::InvalidConfig(what) => write!(f, "invalid geometry: {what}"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for EepromError<E> {}

/// A 24-series EEPROM on bus `I2C`.
#[derive(Debug)]
pub struct At24c<I2C> {
    i2c: I2C,
    geometry: Geometry,
    max_polls: u16,
}

impl<I2C: I2c> At24c<I2C> {
    /// Takes the bus; nothing is sent.
    ///
    /// # Errors
    /// [`EepromError::InvalidConfig`] for a geometry outside the family.
    pub fn new(i2c: I2C, geometry: Geometry) -> Result<Self, EepromError<I2C::Error>> {
        if !geometry.page_bytes.is_power_of_two() || geometry.page_bytes as usize > MAX_PAGE_BYTES {
            return Err(EepromError::InvalidConfig("page_bytes is no power of two up to 128"));
        }
        if geometry.size_bytes == 0 || geometry.size_bytes > 65_536 {
            return Err(EepromError::InvalidConfig("size_bytes is not within 1 to 65536"));
        }
        // 5 ms of write time are 220 polls at 400 kHz; more than twice that is a chip that is not there.
        Ok(Self { i2c, geometry, max_polls: 500 })
    }

    /// How often a silent chip is asked before [`EepromError::Timeout`]; 500 at first, more than twice what a
    /// 400 kHz bus needs for the usual 5 ms.
    #[must_use]
    pub fn with_max_polls(mut self, max_polls: u16) -> Self {
        self.max_polls = max_polls;
        self
    }

    /// Gives the bus back.
    pub fn destroy(self) -> I2C {
        self.i2c
    }

    fn word_address(&self, offset: u32, bytes: usize) -> Result<u16, EepromError<I2C::Error>> {
        let length = u32::try_from(bytes).unwrap_or(u32::MAX);
        let out_of_range = EepromError::OutOfRange { offset, bytes: length };
        match offset.checked_add(length) {
            Some(end) if end <= self.geometry.size_bytes => u16::try_from(offset).map_err(|_| out_of_range),
            _ => Err(out_of_range),
        }
    }

    /// Repeats an address-only write until the chip answers.
    ///
    /// Before every access, not only after a page: a transaction that was cut short starts a page write too,
    /// and so may a restart of the microcontroller find the chip still writing.
    fn wait_for_write(&mut self) -> Result<(), EepromError<I2C::Error>> {
        for _ in 0..self.max_polls {
            match self.i2c.write(self.geometry.address, &[]) {
                Ok(()) => return Ok(()),
                Err(error) if matches!(error.kind(), ErrorKind::NoAcknowledge(_)) => {}
                Err(error) => return Err(EepromError::Bus(error)),
            }
        }
        Err(EepromError::Timeout)
    }
}

impl<I2C: I2c> ReadStorage for At24c<I2C> {
    type Error = EepromError<I2C::Error>;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        if bytes.is_empty() {
            return Ok(());
        }
        let at = self.word_address(offset, bytes.len())?;
        self.wait_for_write()?;
        self.i2c.write_read(self.geometry.address, &at.to_be_bytes(), bytes).map_err(EepromError::Bus)
    }

    fn capacity(&self) -> usize {
        self.geometry.size_bytes as usize
    }
}

impl<I2C: I2c> Storage for At24c<I2C> {
    /// Writes page by page. When it fails, the bytes before the failing page are written and those after it
    /// are not; the page itself holds either.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.word_address(offset, bytes.len())?;
        self.wait_for_write()?;
        let page = usize::from(self.geometry.page_bytes);
        let mut frame = [0; 2 + MAX_PAGE_BYTES];
        let (mut at, mut rest) = (offset, bytes);
        while !rest.is_empty() {
            let room = page - (at as usize & (page - 1));
            let (chunk, later) = rest.split_at(room.min(rest.len()));
            let address = self.word_address(at, chunk.len())?;
            let length = 2 + chunk.len();
            let Some((head, body)) = frame.get_mut(..length).and_then(|f| f.split_at_mut_checked(2)) else {
                return Err(EepromError::InvalidConfig("page larger than the buffer"));
            };
            head.copy_from_slice(&address.to_be_bytes());
            body.copy_from_slice(chunk);
            self.i2c
                .write(self.geometry.address, frame.get(..length).unwrap_or_default())
                .map_err(EepromError::Bus)?;
            self.wait_for_write()?;
            at += chunk.len() as u32;
            rest = later;
        }
        Ok(())
    }
}
