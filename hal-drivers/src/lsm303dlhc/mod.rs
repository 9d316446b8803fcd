//! ST LSM303DLHC, the magnetic half (address 0x1e): 12-bit counts, ±1.3 to ±8.1 G, 0.75 to 220 Hz.
//!
//! Three things about this chip that its users trip over:
//! - the output registers stand in the order **x, z, y**, high byte first;
//! - z has **another scale** than x and y (datasheet table 75);
//! - an axis out of range reads **−4096**, which is no count.
//!
//! The six output bytes are read in one transaction: the chip holds them together from the first byte to the
//! last. The address pointer of the magnetic half increments by itself; the most significant bit of the
//! sub-address, which the accelerometer half wants, must stay clear here.

mod device;
pub mod register;
mod types;

pub use device::Lsm303dlhc;
pub use types::{Config, DataRate, Range, TemperatureFormat};
