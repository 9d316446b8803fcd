//! A chip as data: its registers, and what their bytes mean. No bus.

use ironout_sensor::{Reading, Sensor};

/// Where a chip says who it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// The first register of the identification.
    pub register: u8,
    /// What it reads, one to three bytes.
    pub bytes: &'static [u8],
}

/// One register's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Write {
    /// The register.
    pub register: u8,
    /// What is written to it.
    pub byte: u8,
    /// The bits that read back as written; 0 for a register that cannot be read, or that changes by itself.
    pub kept: u8,
}

impl Write {
    /// A register that keeps all of its bits.
    pub const fn kept(register: u8, byte: u8) -> Self {
        Self { register, byte, kept: 0xff }
    }

    /// A register that is not read back.
    pub const fn unread(register: u8, byte: u8) -> Self {
        Self { register, byte, kept: 0 }
    }
}

/// Where a chip has its temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Thermometer {
    /// It has none, or it is switched off.
    None,
    /// Two bytes from this register on, in one transaction.
    Burst(u8),
    /// Two registers that one transaction cannot read together, the high and the low byte.
    Split {
        /// The register of the high byte.
        high: u8,
        /// The register of the low byte.
        low: u8,
    },
}

/// A magnetometer chip as configured: its register map, for [`Driver`](crate::Driver). Each configuration of this crate is
/// one; a chip that is not here is one `impl` of it.
pub trait Chip {
    /// Who it is.
    const IDENTITY: Identity;
    /// The register that says whether a measurement waits, and the bit in it.
    const STATUS: (u8, u8);
    /// The first of the registers that [`Chip::Output`] is read from.
    const OUTPUT: u8;
    /// What is set in a register's address so that the chip goes on to the next one by itself.
    const INCREMENT: u8 = 0;
    /// Bytes without a meaning that the chip sends before those of its registers, of which at most 14 are then read at once.
    const DUMMIES: u8 = 0;
    /// Measurements after a configuration that are still of the one before.
    const DROPPED: u8 = 0;
    /// For a chip that measures when told: what tells it.
    const TRIGGER: Option<Write> = None;
    /// The output registers of one measurement, for one transaction.
    type Output: AsMut<[u8]> + Default;
    /// The configuration: an array.
    type Writes: AsRef<[Write]>;

    /// The 7-bit address.
    fn address(&self) -> u8;

    /// Whether the chip can be configured like this; the text says what it cannot do.
    ///
    /// # Errors
    /// What is wrong, and what to choose.
    fn check(&self) -> Result<(), &'static str> {
        Ok(())
    }

    /// The registers to write, in this order. Runs of neighbours are read back together.
    fn writes(&self) -> Self::Writes;

    /// The chip as an application sees it, its axes taken for the board's.
    fn sensor(&self) -> Sensor;

    /// Register, what was written to it, and what it reads, where the output registers show that the chip lost its configuration.
    fn lost(&self, _output: &Self::Output) -> Option<(u8, u8, u8)> {
        None
    }

    /// One measurement from its registers.
    fn decode(&self, output: &Self::Output) -> Reading;

    /// Where the temperature is.
    fn thermometer(&self) -> Thermometer {
        Thermometer::None
    }

    /// °C from the temperature's two bytes, in the order they were read (high and low for [`Thermometer::Split`]).
    fn celsius(&self, _bytes: [u8; 2]) -> f32 {
        0.0
    }
}
