//! What the drivers' text means where the bus is waited for: no `async`, no `.await`.

pub use embedded_hal::delay::DelayNs;
pub use embedded_hal::i2c::I2c;
pub use embedded_hal::spi::SpiDevice;
pub use ironout_sensor::{Accelerometer, Gyroscope, Magnetometer};
pub use maybe_async::must_be_sync as both;
