//! TDK ICM-20948: its magnetometer is an AK09916 behind a switch, the *bypass*, which puts it on the bus at 0x0c.
//!
//! From the datasheet (DS-000189 revision 1.3): user bank 0, tables 8.1 to 8.4; the axes of the magnetometer, figure 12.
//!
//! | what | where |
//! |---|---|
//! | address | 0x68 or 0x69, by pin AD0 |
//! | identity | WHO_AM_I 0x00 = 0xea (bank 0) |
//! | bank | REG_BANK_SEL 0x7f |
//! | awake | PWR_MGMT_1 0x06 = 1: awake, the best clock |
//! | its own bus master off | USER_CTRL 0x03 bit 5 = 0 |
//! | bypass | INT_PIN_CFG 0x0f bit 1 |

use super::ak09916;
use super::description::Write;
use ironout_sensor::{Axis, AxisMap, Sensor};

/// Both addresses, by the level of pin AD0.
pub const ADDRESSES: [u8; 2] = [0x68, 0x69];
/// Who it is, in bank 0.
pub const WHO_AM_I: u8 = 0x00;
/// What [`WHO_AM_I`] reads.
pub const IDENTITY: u8 = 0xea;
/// Chooses the bank of registers.
pub const REG_BANK_SEL: u8 = 0x7f;
/// Bit 5: the chip's own bus master.
pub const USER_CTRL: u8 = 0x03;
/// Sleep (bit 6), clock (2–0).
pub const PWR_MGMT_1: u8 = 0x06;
/// Bit 1: bypass.
pub const INT_PIN_CFG: u8 = 0x0f;
/// [`INT_PIN_CFG`]: bypass.
pub const BYPASS_EN: u8 = 1 << 1;

/// The magnetometer's axes along those of accelerometer and gyroscope: x, −y, −z.
pub const MAGNETOMETER_AXES: AxisMap = match AxisMap::new([Axis::X, Axis::MinusY, Axis::MinusZ]) {
    Some(axes) => axes,
    None => AxisMap::IDENTITY,
};

/// The whole configuration. The default: address 0x68, 100 Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
    /// The magnetometer in it.
    pub magnetometer: ak09916::Config,
}

impl Default for Config {
    fn default() -> Self {
        Self { address: ADDRESSES[0], magnetometer: ak09916::Config::default() }
    }
}

/// What opens the bypass. Where a bank is to be chosen, the identity stands in bank 0 too.
pub const OPENING: [Write; 3] = [
    Write::kept(PWR_MGMT_1, 1),
    // Reset bits in it clear themselves.
    Write { register: USER_CTRL, byte: 0, kept: 1 << 5 },
    Write { register: INT_PIN_CFG, byte: BYPASS_EN, kept: BYPASS_EN },
];

/// The magnetometer in it, by the name of the whole.
pub fn named(magnetometer: Sensor) -> Sensor {
    Sensor { name: "ICM-20948", ..magnetometer }
}
