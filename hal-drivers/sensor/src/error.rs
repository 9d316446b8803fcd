//! The one error type of the magnetometer drivers.

use core::fmt;

/// Why a driver could not do what it was asked. `E` is the error of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The bus failed: no acknowledge, arbitration lost, line held down. The transaction may be repeated.
    Bus(E),
    /// A chip answered at the address, but with another identity than this driver's chip.
    NotFound {
        /// The identification bytes of the chip this driver is for; zero beyond those that it has.
        expected: [u8; 3],
        /// The bytes that were read; zero beyond those that were.
        found: [u8; 3],
    },
    /// A configuration register does not hold what was written to it: the chip was reset meanwhile, or it is
    /// not the chip it claims to be.
    NotKept {
        /// Address of the register.
        register: u8,
        /// The byte written to it.
        written: u8,
        /// The byte read back.
        read: u8,
    },
    /// The configuration asks for something the chip cannot do; the text says what.
    InvalidConfig(&'static str),
}

impl<E> From<E> for Error<E> {
    fn from(error: E) -> Self {
        Error::Bus(error)
    }
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Bus(error) => write!(f, "bus error {error:?}"),
            Error::NotFound { expected, found } => {
                // A chip of one byte has two that nobody read.
                let told =
                    |bytes: &[u8; 3]| bytes.iter().rposition(|&byte| byte != 0).map_or(1, |last| last + 1);
                let bytes = told(expected).max(told(found));
                let (expected, found) = (expected.get(..bytes), found.get(..bytes));
                write!(
                    f,
                    "identity {:02x?} where {:02x?} is expected",
                    found.unwrap_or(&[]),
                    expected.unwrap_or(&[])
                )
            }
            Error::NotKept { register, written, read } => {
                write!(f, "register {register:#04x} holds {read:#04x} after {written:#04x} was written")
            }
            Error::InvalidConfig(what) => write!(f, "invalid configuration: {what}"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for Error<E> {}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Error;
    use std::string::ToString;

    #[test]
    fn an_identity_is_told_with_the_bytes_that_it_has() {
        let told = |expected, found| Error::<()>::NotFound { expected, found }.to_string();
        assert_eq!(told([0x40, 0, 0], [0x33, 0, 0]), "identity [33] where [40] is expected");
        assert_eq!(told([0x40, 0, 0], [0, 0, 0]), "identity [00] where [40] is expected");
        assert_eq!(told([0x48, 0x09, 0], [0x48, 0x05, 0]), "identity [48, 05] where [48, 09] is expected");
        assert_eq!(told(*b"H43", [0; 3]), "identity [00, 00, 00] where [48, 34, 33] is expected");
    }
}
