//! The drivers for a bus that is waited for (`embedded-hal`).

#[path = "device/any.rs"]
mod any;
#[path = "device/bmm150.rs"]
mod bmm150;
#[path = "device/bmm350.rs"]
mod bmm350;
#[path = "device/driver.rs"]
mod driver;
#[path = "device/gyroscope.rs"]
mod gyroscope;
#[path = "device/icm20948.rs"]
mod icm20948;
#[path = "device/lsm303_accelerometer.rs"]
mod lsm303_accelerometer;
#[path = "device/memsic.rs"]
mod memsic;
#[path = "device/mode_blocking.rs"]
mod mode;
#[path = "device/probe.rs"]
mod probe;
#[path = "device/registers.rs"]
mod registers;
#[path = "device/rm3100.rs"]
mod rm3100;

pub use any::AnyMagnetometer;
pub use bmm150::Bmm150;
pub use bmm350::Bmm350;
pub use driver::Driver;
pub use gyroscope::L3gd20;
pub use icm20948::Icm20948;
pub use lsm303_accelerometer::Lsm303Accelerometer;
pub use memsic::{Memsic, Mmc5603, Mmc5983ma, NoDelay};
pub use probe::probe;
pub use registers::{Registers, SpiRegisters, Wires};
